"""The coordinates in which wear runs straight, and the loops' likelihoods in them.

They are the loops' own unconstrained coordinates but for the mesh threshold T_T. On a new drive
it is near zero, where the loops' softplus coordinate is a logarithm: straight wear in Nm would be
bent there, and bend the clock that all parameters share. Here its softplus is five times sharper.
Amplitudes of effects that are followed come behind the eight (n numbers in all), as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.information import Linearised
from hdprog.inference.likelihood import sigmoid
from hdprog.inference.priors import Prior
from hdprog.physics.parameters import BY_NAME, NAMES, FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.wear_prior import WearPrior

_K_F, _b, _T_T = (NAMES.index(name) for name in ("K_F", "b", "T_T"))
_SHARPER = 5.0
_SOFTPLUS = BY_NAME["T_T"]
STIFFEST_TEETH = 20.0
"""Times the cup's stiffness that the teeth's b may be. New gears have twice to thrice the cup's;
beyond this loops see the cup alone, and nothing would hold a trend that lets teeth heal."""


def to_loop(wear: FloatArray) -> FloatArray:
    """Unconstrained coordinates (..., n) of a loop from wear coordinates (..., n)."""
    loop = wear.copy()
    value = _SOFTPLUS.from_coordinate(wear[..., _T_T], 1.0 / _SHARPER)
    loop[..., _T_T] = _SOFTPLUS.to_coordinate(np.maximum(value, np.finfo(float).tiny))
    return loop


def from_loop(loop: FloatArray) -> FloatArray:
    """Wear coordinates (..., n) from unconstrained ones of a loop (..., n)."""
    wear = loop.copy()
    value = _SOFTPLUS.from_coordinate(loop[..., _T_T])
    scaled = np.maximum(value, np.finfo(float).tiny)
    wear[..., _T_T] = _SOFTPLUS.to_coordinate(scaled, 1.0 / _SHARPER)
    return wear


def mesh_threshold(wear: FloatArray, softplus_scale: float) -> FloatArray:
    """T_T (...) in Nm of wear coordinates (..., n); the scale, in Nm, is the loops'."""
    return np.asarray(_SOFTPLUS.from_coordinate(wear[..., _T_T], softplus_scale / _SHARPER))


def slope(wear: FloatArray) -> FloatArray:
    """Differentiate the loop's coordinates by the wear coordinates; (..., n) each."""
    found = np.ones_like(wear)
    inner = sigmoid(wear[..., _T_T]) / _SHARPER
    found[..., _T_T] = inner / sigmoid(to_loop(wear)[..., _T_T])
    return found


def possible(coordinates: FloatArray) -> NDArray[np.bool_]:
    """Whether teeth are no stiffer than they can be, (...,) of wear coordinates (..., n).

    Of the loops' coordinates as well: only T_T differs.
    """
    return np.asarray(coordinates[..., _b] - coordinates[..., _K_F] <= np.log(STIFFEST_TEETH))


@dataclass(frozen=True)
class StatePrior:
    """The loop prior in wear coordinates, as independent Gaussians.

    Attributes
    ----------
    mean, sd : (n,); of T_T the Gaussian that agrees one standard deviation each way
    """

    mean: FloatArray
    sd: FloatArray

    @staticmethod
    def of(prior: Prior, wear_prior: WearPrior) -> StatePrior:
        """From the prior of the loops and, for amplitudes of effects, that of wear."""
        low, high = from_loop(prior.mean - prior.sd), from_loop(prior.mean + prior.sd)
        none = np.zeros(wear_prior.followed)
        return StatePrior(
            np.concatenate([(low + high) / 2, none]),
            np.concatenate([(high - low) / 2, none + wear_prior.effect.initial_sd]),
        )


def linearise(test: LoopEvidence, point: FloatArray) -> Linearised:
    """Information form of a loop's likelihood at wear coordinates (n,)."""
    at = to_loop(point)
    found = test.linearise(at)
    steep = slope(point)
    precision = steep[:, None] * found.precision * steep
    pull = steep * (found.information - found.precision @ at)
    return Linearised(precision, precision @ point + pull, found.log_likelihood)
