"""A loop's likelihood near a point in information form, its nuisances integrated out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.likelihood import COUNT, sigmoid
from hdprog.physics.parameters import FloatArray


@dataclass(frozen=True)
class Linearised:
    """Likelihood of a loop in information form: log L(x) ≈ const − ½ xᵀΛx + ηᵀx.

    Attributes
    ----------
    precision : (n, n) Λ, Gauss-Newton curvature, never negative
    information : (n,) η
    log_likelihood : at the point of linearisation, nuisances at their best, up to a constant of
        the loop: to be compared between points
    """

    precision: FloatArray
    information: FloatArray
    log_likelihood: float


def information_form(
    residual: FloatArray,
    derivative: FloatArray,
    state: FloatArray,
    point: FloatArray,
    columns: NDArray[np.intp],
    variance: float,
) -> Linearised:
    """Integrate all but the state out of a linearised residual.

    Parameters
    ----------
    residual, derivative : (blocks,) and (blocks, size) at the point, whitened
    state : (n,) the state's numbers there
    point : (size,) coordinates of the likelihood there
    columns : (n,) which columns of the derivative are by the state's numbers; the others are
        nuisances with the priors that `LoopLikelihood.log_prior` gives them
    variance : s², the noise scale squared
    """
    information = derivative.T @ derivative / variance
    gradient = -derivative.T @ residual / variance
    others = np.setdiff1d(np.arange(point.size), columns)
    # Curvature and slope of the nuisances' priors; then their Schur complement.
    fraction = float(sigmoid(point[COUNT]))
    logit = others == COUNT
    curvature = np.where(logit, 2 * fraction * (1 - fraction), 1.0)
    slope = np.where(logit, 1 - 2 * fraction, -point[others])
    nuisance = information[np.ix_(others, others)] + np.diag(curvature)
    pull = gradient[others] + slope
    cross = information[np.ix_(columns, others)]
    solved = np.linalg.solve(nuisance, np.column_stack([cross.T, pull]))
    precision = information[np.ix_(columns, columns)] - cross @ solved[:, :-1]
    left = gradient[columns] - cross @ solved[:, -1]
    return Linearised(
        precision=0.5 * (precision + precision.T),
        information=precision @ state + left,
        log_likelihood=float(-0.5 * residual @ residual / variance + 0.5 * pull @ solved[:, -1]),
    )
