"""How far the prior, and how far the record, carries each parameter and figure of merit.

The prior of the eight parameters, or the likelihood, is raised to a power near 1 by importance
weights, and the cumulative Jensen-Shannon distance between the weighted and the plain draws is
taken for each quantity. Its rate of change with the power's binary logarithm is the sensitivity
(Kallioinen, Paananen, Bürkner & Vehtari, Statistics and Computing 34 (2024) 57); 0.05 stands for a
shift by about 0.3 posterior standard deviations where the power is doubled. The definition is that
of ArviZ's `psens`; all quantities are done at once here.

Both sensitivities are above 0.05 wherever prior and record share a parameter, agreeing or not: the
paper's rule would call a third of sound fits conflicts. A conflict is told here by how far the
record has moved the parameter. Over repeated drives from the prior the posterior mean m of a
coordinate scatters about the prior mean with variance τ² − E[v] (law of total variance; τ² prior, v
posterior variance), so that

    z = (m − prior mean) / sqrt(τ² − v)

is standard normal where all is linear and Gaussian. τ² − v is taken as a tenth of τ² at least: a
record that says little cannot disagree by chance, and one whose posterior is wider than the prior,
torn between two modes, still can.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.likelihood import COUNT
from hdprog.inference.posterior import FIGURE_DRAWS, Posterior
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.results import Diagnosis, Sensitivity

THRESHOLD = 0.05
CONFLICT = 2.73
"""|z| that one of eight parameters passes in 5 % of sound fits at most (Bonferroni, two-sided)."""
_LEAST_MOVED = 0.1
_DELTA = 0.01


def loop_sensitivities(
    posterior: Posterior, drawn: Mapping[str, FloatArray]
) -> tuple[dict[str, Sensitivity], dict[str, Sensitivity]]:
    """Sensitivities of a loop's parameters and figures to the prior and to the record.

    Parameters
    ----------
    posterior : of one loop
    drawn : figures of merit, as `posterior.figures` draws them

    Returns
    -------
    by parameter and by figure's key
    """
    points = posterior.points[posterior.thinned(FIGURE_DRAWS)]
    coordinates = points[:, :COUNT]
    quantities = np.vstack([coordinates.T, *drawn.values()])
    prior = power_scaling(quantities, posterior.prior.log_density(coordinates))
    record = power_scaling(quantities, posterior.likelihood.log_likelihood(points))
    shift = prior_shift(
        posterior.coordinates,
        posterior.prior.mean,
        posterior.prior.sd,
        posterior.diagnostics.ess_bulk[:COUNT],
    )
    found = {
        name: Sensitivity(
            float(prior[index]),
            float(record[index]),
            diagnose(float(prior[index]), float(record[index]), float(shift[index])),
            float(shift[index]),
        )
        for index, name in enumerate(NAMES)
    }
    of_figures = {
        key: Sensitivity(float(by_prior), float(by_record), diagnose(by_prior, by_record))
        for key, by_prior, by_record in zip(drawn, prior[COUNT:], record[COUNT:], strict=True)
    }
    return found, of_figures


def diagnose(prior: float, record: float, shift: float = 0.0) -> Diagnosis:
    """What sensitivities to the prior and to the record say; `shift` is z, where it is known."""
    if abs(shift) > CONFLICT:
        return "overruled" if prior < THRESHOLD else "conflict"
    if prior < THRESHOLD:
        return "record"
    return "prior" if record < THRESHOLD else "shared"


def prior_shift(
    coordinates: FloatArray, mean: FloatArray, sd: FloatArray, effective: FloatArray
) -> FloatArray:
    """How far the record moved each coordinate, in what a sound fit would, (n,).

    Parameters
    ----------
    coordinates : (draws, n) of the posterior
    mean, sd : (n,) of the Gaussian prior
    effective : (n,) effective draws, whose Monte-Carlo error is allowed for

    Returns
    -------
    z of the module's docstring
    """
    variance = coordinates.var(axis=0)
    moved = np.maximum(sd**2 - variance, _LEAST_MOVED * sd**2)
    error = variance / np.maximum(effective, 1.0)
    return np.asarray((coordinates.mean(axis=0) - mean) / np.sqrt(moved + error))


def power_scaling(quantities: FloatArray, component: FloatArray) -> FloatArray:
    """Sensitivity of each quantity to the power of one component of the posterior.

    Parameters
    ----------
    quantities : (quantities, draws)
    component : (draws,) log of the component's density at the draws, up to a constant

    Returns
    -------
    (quantities,) at least 0
    """
    order = np.argsort(quantities, axis=1)
    ordered = np.take_along_axis(quantities, order, axis=1)
    distances = np.zeros(len(quantities))
    for power in (1 / (1 + _DELTA), 1 + _DELTA):
        weights = np.exp(arviz().psislw((power - 1) * component)[0])
        weighted = (weights / weights.sum())[order]
        distances += np.maximum(
            _distance(ordered, weighted), _distance(-ordered[:, ::-1], weighted[:, ::-1])
        )
    return np.asarray(distances / (2 * np.log2(1 + _DELTA)))


def _distance(ordered: FloatArray, weights: FloatArray) -> FloatArray:
    """Cumulative Jensen-Shannon distance (quantities,) of weighted from plain sorted draws.

    Both arguments are (quantities, draws). Nguyen & Vreeken, ECML PKDD 2015.
    """
    count = ordered.shape[1]
    width = np.diff(ordered, axis=1)
    plain = np.linspace(1 / count, 1 - 1 / count, count - 1)[None, :]
    scaled = np.cumsum(weights, axis=1)[:, :-1]
    middle = np.log2(0.5 * (plain + scaled))
    area_plain = np.sum(width * plain, axis=1)
    area_scaled = np.sum(width * scaled, axis=1)
    excess = 0.5 / np.log(2) * (area_scaled - area_plain)
    one = np.sum(width * plain * (np.log2(plain) - middle), axis=1) + excess
    other = np.sum(width * scaled * (np.log2(scaled) - middle), axis=1) - excess
    total = area_plain + area_scaled
    moved = np.maximum(one, 0.0) + np.maximum(other, 0.0)
    share = np.divide(moved, total, out=np.zeros_like(total), where=total > 0)
    return np.asarray(np.sqrt(share))
