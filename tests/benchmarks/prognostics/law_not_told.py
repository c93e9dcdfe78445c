"""The best forecast by one who is not told the law: a full Bayesian over the six laws.

Known are the laws and how their populations are drawn (laws.py), each law as likely as any other;
not known are the fleet's law and its population. Each law's populations are drawn by adaptive
importance sampling in their normal space (Cappé et al., Stat. Comput. 18, 2008), from Student laws
that come nearer by tempered steps, with a share from the prior (Hesterberg, Technometrics 37,
1995), and weighted by the chance of all readings given them (evidence.py). The forecast is the mean
of the oracle's over populations of all laws, resampled systematically by weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, multivariate_t

from tests.benchmarks.prognostics.evidence import Evidence, unit_evidence
from tests.benchmarks.prognostics.laws import LAWS, FloatArray, Law
from tests.benchmarks.prognostics.method import GRID, Learnt, Told
from tests.benchmarks.prognostics.oracle import oracle
from tests.benchmarks.prognostics.populations import COORDINATES, Populations, populations_at

NOT_TOLD = "law not told"
_STEP, _LAST = 300, 500
_WORTH = 100.0
"""Effective number of populations below which a step is tempered."""
_TAILS = 5  # degrees of freedom of the Student proposals
_PRIOR_SHARE = 0.1
_FORECASTS = 24


@dataclass(frozen=True)
class Sample:
    """Weighted populations of one law.

    Attributes
    ----------
    populations : drawn
    log_weight : (populations,) whose mean, not as a logarithm, is the law's evidence
    """

    populations: Populations
    log_weight: FloatArray

    def with_unit(self, evidence: Evidence) -> Sample:
        """The same with one unit's readings beside those weighed already."""
        return Sample(self.populations, self.log_weight + evidence(self.populations))


def learn(others: FloatArray, rng: np.random.Generator) -> Learnt:
    """Weigh each law's populations by the other units' readings."""
    samples = []
    for law in LAWS:
        each = [unit_evidence(law, values, False, rng) for values in others]
        samples.append(sample(law, each, rng))

    def forecast(values: FloatArray, rng: np.random.Generator) -> Told:
        weighed = with_new_unit(samples, values, rng)
        return Told({NOT_TOLD: mean_forecast(weighed, values, rng)})

    return Learnt(forecast)


def with_new_unit(
    samples: Sequence[Sample], values: FloatArray, rng: np.random.Generator
) -> list[Sample]:
    """Samples of all laws that know a new unit's readings (5,), too."""
    return [one.with_unit(unit_evidence(one.populations.law, values, True, rng)) for one in samples]


def law_chances(samples: Sequence[Sample]) -> FloatArray:
    """Posterior probability (laws,) of each law."""
    evidence = [logsumexp(one.log_weight) - np.log(one.log_weight.size) for one in samples]
    return np.asarray(np.exp(evidence - logsumexp(evidence)))


def mean_forecast(
    samples: Sequence[Sample], values: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Distribution function (times,) on `GRID`, the oracle's averaged over populations."""
    weights = [
        chance * np.exp(one.log_weight - logsumexp(one.log_weight))
        for chance, one in zip(law_chances(samples), samples, strict=True)
    ]
    places = [(law, at) for law, weight in enumerate(weights) for at in range(weight.size)]
    passed = np.cumsum(np.concatenate(weights))
    levels = passed[-1] * (np.arange(_FORECASTS) + rng.uniform()) / _FORECASTS
    chosen, counts = np.unique(np.searchsorted(passed, levels), return_counts=True)
    total = np.zeros_like(GRID)
    for number, count in zip(chosen, counts, strict=True):
        law, at = places[number]
        total += count * oracle(samples[law].populations[at], values, GRID, rng).probability
    return np.asarray(total / _FORECASTS)


def sample(law: Law, units: Sequence[Evidence], rng: np.random.Generator) -> Sample:
    """Populations of a law given units that were tested before.

    Parameters
    ----------
    law : which
    units : evidence of each
    rng : source of randomness
    """
    points, log_ratio, heat = rng.standard_normal((_STEP, COORDINATES)), np.zeros(_STEP), 0.0
    while True:
        populations = populations_at(law, points)
        said = np.sum([unit(populations) for unit in units], axis=0)
        if heat == 1.0:
            return Sample(populations, log_ratio + said)
        heat = _heat(log_ratio, said, heat)
        weight = _normed(log_ratio + heat * said)
        points, log_ratio = _nearer(points, weight, _LAST if heat == 1.0 else _STEP, rng)


def _nearer(
    points: FloatArray, weight: FloatArray, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """New points where the weighted ones are, and their log prior over what they are drawn from."""
    centre = weight @ points
    away = points - centre
    covariance = np.einsum("d,di,dj->ij", weight, away, away) + 1e-6 * np.eye(COORDINATES)
    student = multivariate_t(centre, covariance, df=_TAILS)
    from_prior = rng.uniform(size=(count, 1)) < _PRIOR_SHARE
    normal = rng.standard_normal((count, COORDINATES))
    drawn = np.where(from_prior, normal, student.rvs(count, random_state=rng))
    log_prior = multivariate_normal(np.zeros(COORDINATES)).logpdf(drawn)
    log_student = np.log1p(-_PRIOR_SHARE) + student.logpdf(drawn)
    return drawn, log_prior - np.logaddexp(np.log(_PRIOR_SHARE) + log_prior, log_student)


def _heat(log_ratio: FloatArray, said: FloatArray, least: float) -> float:
    """Largest power of the evidence that leaves the wanted effective number of populations.

    It rises by a tenth at the least, so that the steps come to an end.
    """
    low, high = min(1.1 * least, 1.0), 1.0
    if _worth(log_ratio + said) >= _WORTH:
        return 1.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        if _worth(log_ratio + middle * said) >= _WORTH:
            low = middle
        else:
            high = middle
    return low


def _normed(log_weight: FloatArray) -> FloatArray:
    return np.asarray(np.exp(log_weight - logsumexp(log_weight)))


def _worth(log_weight: FloatArray) -> float:
    return float(1.0 / np.sum(_normed(log_weight) ** 2))
