"""Where the truth of a loop lies among the draws of its posterior.

Quantities: the eight unconstrained coordinates, the standard figures of merit, the nuisances
(fraction of the initial slip, angle offset, noise), and the log-likelihood. The last one sees what
no parameter alone shows, e.g. a posterior that is right in each but too narrow along a ridge
(Modrák et al., Bayesian Analysis 20 (2025) 461).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hdprog.inference.likelihood import COUNT, sigmoid
from hdprog.inference.posterior import Posterior
from hdprog.physics.figures import Operation, figures, standard_requests
from hdprog.physics.parameters import NAMES, FloatArray
from tests.benchmarks.calibration.loops import DRIVE, TWO_SIDED, Drawn, prior_of

LOG_LIKELIHOOD = "log-likelihood"
NUISANCES = ("initial slip", "angle offset", "noise")
assert DRIVE.rated_torque is not None
OPERATION = Operation(
    DRIVE.alpha, DRIVE.rated_torque, DRIVE.rated_torque, prior_of(TWO_SIDED).catalogue_torques
)
FIGURES = tuple(request.key for request in standard_requests(OPERATION))
QUANTITIES = (*NAMES, *FIGURES, *NUISANCES, LOG_LIKELIHOOD)
"""All that is ranked, in the order of the results."""
TIMES = 4
"""Moments of the sampling at which every walker's position is a draw for the ranks.

At one moment the walkers of an ensemble are independent draws of the posterior, since what an
ensemble samples is the product of its walkers' posteriors; the ensembles are independent anyway.
The moments lie a third of the chains apart: 16 autocorrelation times where a fit converged.
"""
HIGHEST = 383
"""L: 4 ensembles of 24 walkers at 4 moments are 384 draws. One is left out, so that 384 ranks are
possible, which many numbers of places divide evenly."""
_DRAWS = 2000


@dataclass(frozen=True)
class Located:
    """Quantities of one posterior.

    Attributes
    ----------
    truth : by name
    draws : by name, (draws,) all those that figures are computed of
    independent : by name, (HIGHEST,) the draws for the ranks
    points : (draws, 9) that `draws` are of
    """

    truth: Mapping[str, float]
    draws: Mapping[str, FloatArray]
    independent: Mapping[str, FloatArray]
    points: FloatArray

    def ranks(self, rng: np.random.Generator) -> list[int]:
        """Number of independent draws below the truth; among equal ones any place is as likely."""
        found = []
        for name in QUANTITIES:
            draws, truth = self.independent[name], self.truth[name]
            equal = int((draws == truth).sum())
            found.append(int((draws < truth).sum()) + int(rng.integers(equal + 1)))
        return found

    def shares(self, log_weights: FloatArray | None = None) -> list[float]:
        """Share of the posterior below the truth, of draws with log weights (draws,) or equal."""
        count = len(self.points)
        weights = np.full(count, 1.0 / count)
        if log_weights is not None:
            weights = np.exp(log_weights - log_weights.max())
            weights /= weights.sum()
        return [float(weights @ (self.draws[name] < self.truth[name])) for name in QUANTITIES]


def located(drawn: Drawn, posterior: Posterior) -> Located:
    """All quantities of a posterior and of its truth.

    Raises
    ------
    ValueError
        for a posterior with too few walkers for the ranks
    """
    ensembles, _, walkers, _ = posterior.chains.shape
    if ensembles * walkers * TIMES < HIGHEST:
        raise ValueError(f"{ensembles} x {walkers} walkers at {TIMES} times: below {HIGHEST} draws")
    chosen = posterior.thinned(_DRAWS)
    points, offset, scale = posterior.points, posterior.offset, posterior.noise_scale
    draws = _quantities(posterior, points[chosen], _flat(offset)[chosen], _flat(scale)[chosen])
    at = np.linspace(0, offset.shape[1] - 1, TIMES).round().astype(int)
    moments = posterior.chains[:, at].reshape(-1, points.shape[1])
    independent = _quantities(posterior, moments, offset[:, at].ravel(), scale[:, at].ravel())
    return Located(
        truth=_truth(drawn, posterior),
        draws=draws,
        independent={name: values[-HIGHEST:] for name, values in independent.items()},
        points=points[chosen],
    )


def rank_of(share: float) -> int:
    """The rank from 0 to `HIGHEST` that a share of the posterior comes to."""
    return int(np.clip(share * (HIGHEST + 1), 0, HIGHEST))


def _flat(chains: FloatArray) -> FloatArray:
    """(draws,) of (ensembles, steps, walkers), in the order of `Posterior.points`."""
    return chains.transpose(0, 2, 1).ravel()


def _quantities(
    posterior: Posterior, points: FloatArray, offset: FloatArray, scale: FloatArray
) -> dict[str, FloatArray]:
    """By name, (draws,) each, of points (draws, 9), offsets and noise scales (draws,)."""
    parameters = posterior.prior.to_physical(points[:, :COUNT])
    nuisances = (sigmoid(points[:, COUNT]), offset, scale * reading_sd(posterior))
    return {
        **{name: points[:, index] for index, name in enumerate(NAMES)},
        **figures(standard_requests(OPERATION), parameters, OPERATION),
        **dict(zip(NUISANCES, nuisances, strict=True)),
        LOG_LIKELIHOOD: posterior.likelihood.log_likelihood(points),
    }


def _truth(drawn: Drawn, posterior: Posterior) -> dict[str, float]:
    scale = drawn.noise / reading_sd(posterior)
    true = _quantities(posterior, drawn.point[None, :], np.array([drawn.offset]), np.array([scale]))
    return {name: float(values[0]) for name, values in true.items()}


def reading_sd(posterior: Posterior) -> float:
    """Standard deviation of a reading in rad for a noise scale of one."""
    likelihood = posterior.likelihood
    return float(np.median(likelihood.noise.white_sd * np.sqrt(likelihood.reduced.count)))
