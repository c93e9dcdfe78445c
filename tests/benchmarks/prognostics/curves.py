"""Chance of a unit's readings where it is a curve, for many populations at once.

A curve is written in the deviates that it would have in one population of the law, the reference:
there the units of every population are Gaussian, and how well a curve meets the readings does not
hang on the population. One set of curves, drawn in steps that come nearer to the readings, serves
all populations with weights (importance sampling from the mixture of all proposals, Owen & Zhou,
J. Am. Stat. Assoc. 95, 2000; proposals by kernels, West, JRSS B 55, 1993).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import logsumexp

from tests.benchmarks.prognostics.fleets import NOW, TEST_HOURS
from tests.benchmarks.prognostics.laws import (
    MIDDLE_CHANGE,
    Accelerating,
    ChangeOfPace,
    FloatArray,
    Law,
    Power,
    Saturating,
    Smooth,
)
from tests.benchmarks.prognostics.populations import COORDINATES, Populations, populations_at

_REFERENCES: dict[type, Smooth] = {
    Power: Power(1.0, 1.0, 1.0, 0.0),
    Accelerating: Accelerating(1.0, 1.0, 1.0, 1.0),
    Saturating: Saturating(1.0, 1.0, 1.0, 1.3),
    ChangeOfPace: ChangeOfPace(1.0, 1.0, 1.0, 1.0),
}
_FIRST, _DRAWS, _KERNELS = 3000, 300, 100
_BLURS = (0.6, 0.25, 0.1, 0.04, 0.015, 0.006)
"""Noises by which the proposals come nearer: from far above a fleet's largest to its least."""
_SERVING = 4
"""How many of the last proposals are drawn from for good, beside the prior."""
_LIVES = 400
"""Units of each population by which the chance of living up to `NOW` is counted."""


def curve_evidence(
    law: Law, readings: FloatArray, new: bool, rng: np.random.Generator
) -> Callable[[Populations], FloatArray]:
    """Log density of one unit's readings given populations of a smooth law.

    Parameters
    ----------
    law, readings, new, rng : as for `evidence.unit_evidence`
    """
    reference = _REFERENCES[law.kind]
    hours = TEST_HOURS[: readings.size]

    def squares(curves: FloatArray) -> FloatArray:
        missed = np.sum((readings - reference.level(curves, hours)) ** 2, axis=1)
        return np.where(_alive(reference, curves), missed, np.inf) if new else missed

    curves, log_proposal = _curves(law, reference, squares, rng)
    missed = squares(curves)
    kept = np.isfinite(missed)
    curves, missed, log_proposal = curves[kept], missed[kept], log_proposal[kept]
    features = np.column_stack([curves**2, curves, np.ones(len(curves)), missed])
    log_count = np.log(kept.size)
    shared = rng.standard_normal((_LIVES, reference.deviates))

    def evidence(populations: Populations) -> FloatArray:
        mean, spread = in_reference(populations)
        size = mean.shape[1]
        constant = (
            -0.5 * np.sum((mean / spread) ** 2, axis=1)
            - np.log(spread).sum(axis=1)
            - 0.5 * (size + readings.size) * np.log(2 * np.pi)
            - readings.size * np.log(populations.noise)
        )
        of_features = np.column_stack(
            [-0.5 / spread**2, mean / spread**2, constant, -0.5 / populations.noise**2]
        )
        log_weight = of_features @ features.T - log_proposal
        top = log_weight.max(axis=1)
        said = top + np.log(np.exp(log_weight - top[:, None]).sum(axis=1)) - log_count
        if new:
            units = mean[:, None] + spread[:, None] * shared
            alive = _alive(reference, units.reshape(-1, size)).reshape(units.shape[:2])
            said -= np.log((alive.sum(axis=1) + 1.0) / (_LIVES + 1.0))
        return np.asarray(said)

    return evidence


def in_reference(populations: Populations) -> tuple[FloatArray, FloatArray]:
    """Mean and spread (populations, deviates) of the units' deviates in the reference."""
    reference = _REFERENCES[populations.law.kind]
    log_pace, shape = np.log(populations.pace), populations.shape
    mean = np.zeros((shape.size, reference.deviates))
    if isinstance(reference, Power):
        mean[:, 0], mean[:, 1] = log_pace, shape / 0.1
    elif isinstance(reference, Accelerating):
        mean[:, 0] = log_pace - np.log(np.expm1(shape) / np.expm1(reference.shape))
        mean[:, 1] = np.log(shape / reference.shape) / 0.15
    elif isinstance(reference, Saturating):
        middle = np.log1p(-1.0 / reference.shape) / np.log1p(-1.0 / shape)
        mean[:, 0] = np.log(middle) - log_pace
        mean[:, 1] = np.log(shape / reference.shape) / 0.15
    else:
        mean[:, 0] = log_pace - np.log(1.0 + (shape - 1.0) * (1.0 - MIDDLE_CHANGE))
        mean[:, 1] = np.log(shape) / 0.25
    spread = np.ones_like(mean)
    spread[:, 0] = populations.scatter
    return mean, spread


def _alive(reference: Smooth, curves: FloatArray) -> FloatArray:
    # Curves rise, so that one below 1 has not crossed.
    return np.asarray(reference.level(curves, np.array([NOW]))[:, 0] < 1.0)


class _Kernels:
    """Equal mixture of Gaussians of one covariance around some points."""

    def __init__(self, centres: FloatArray, covariance: FloatArray) -> None:
        self._centres = centres
        self._root = np.linalg.cholesky(covariance)

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        chosen = self._centres[rng.integers(len(self._centres), size=count)]
        return np.asarray(chosen + rng.standard_normal(chosen.shape) @ self._root.T)

    def log_density(self, points: FloatArray) -> FloatArray:
        size = points.shape[1]
        inverse = np.linalg.inv(self._root).T
        points, centres = points @ inverse, self._centres @ inverse
        inner = points @ centres.T - 0.5 * np.sum(centres**2, axis=1)
        top = inner.max(axis=1)
        total = top + np.log(np.exp(inner - top[:, None]).sum(axis=1))
        constant = np.log(len(centres)) + np.log(np.diag(self._root)).sum()
        constant += 0.5 * size * np.log(2 * np.pi)
        return np.asarray(total - 0.5 * np.sum(points**2, axis=1) - constant)


def _curves(
    law: Law,
    reference: Smooth,
    squares: Callable[[FloatArray], FloatArray],
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Curves (draws, deviates), and the log density of the mixture they are drawn from."""
    mean, spread = in_reference(populations_at(law, rng.standard_normal((_FIRST, COORDINATES))))
    drawn = mean + spread * rng.standard_normal(mean.shape)
    size = reference.deviates
    prior = _Kernels(drawn.mean(axis=0, keepdims=True), np.cov(drawn.T))
    # Silverman's rule, made wider: weights of too wide a proposal do not vary as much.
    narrower = 2.5 * (4.0 / ((size + 2) * _KERNELS)) ** (2.0 / (size + 4))
    proposals, each = [prior], [prior.draw(_DRAWS, rng)]
    log_ratio = np.zeros(_FIRST)
    for blur in _BLURS:
        log_weight = log_ratio - 0.5 * squares(drawn) / blur**2
        weight = np.exp(log_weight - logsumexp(log_weight))
        away = drawn - weight @ drawn
        covariance = np.einsum("d,di,dj->ij", weight, away, away) + 1e-6 * np.eye(size)
        chosen = drawn[rng.choice(len(drawn), size=_KERNELS, p=weight)]
        proposals.append(_Kernels(chosen, narrower * covariance))
        drawn = proposals[-1].draw(_DRAWS, rng)
        log_ratio = prior.log_density(drawn) - proposals[-1].log_density(drawn)
        each.append(drawn)
    proposals = [prior, *proposals[-_SERVING:]]
    curves = np.concatenate([each[0], *each[-_SERVING:]])
    densities = [proposal.log_density(curves) for proposal in proposals]
    return curves, np.asarray(logsumexp(densities, axis=0) - np.log(len(densities)))
