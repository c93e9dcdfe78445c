"""The reference: populations of particles led from the prior to the posterior.

Sequential Monte Carlo with a likelihood raised to powers from 0 to 1 (Del Moral, Doucet and Jasra,
J. R. Statist. Soc. B 68 (2006) 411). At each power the particles are weighted, drawn anew and
moved many times by differential evolution: a particle steps along the difference of two others
from the population's other half, which stays where it is, so that each move leaves the product of
the particles' densities unchanged. Directions, lengths and bends thus come from the population
itself; nothing is fitted, and no start is given that a search has found.

A mode with one part in a hundred of the mass is crowded long before it is separate. What each
population gives the modes is free of bias when it is weighted by its own estimate of the evidence;
the spread between populations, which know nothing of each other, is the Monte-Carlo error.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.modes.coordinates import System, systems
from tests.benchmarks.modes.fused import LogLikelihood

POPULATIONS, PARTICLES = 8, 2000
MOVES, LAST_MOVES = 40, 1500
"""Of every particle at each power, and at the last one, which is the posterior."""
SNAPSHOTS = 4
"""Moments of the last moves that particles are kept of, the last half of the moves apart."""
_KEPT_SHARE = 0.6  # effective share of the particles after a step of the power
_SMALLEST, _LARGEST = 0.1, 1.5  # lengths of the steps in parts of the best for a Gaussian
_WHOLE = 0.1  # share of steps by a whole difference, which lead from mode to mode
_JITTER = 1e-6  # of the spread, so that equal particles part


@dataclass(frozen=True)
class Reference:
    """Draws of the populations.

    Attributes
    ----------
    points : (populations, draws, 9)
    log_evidence : (populations,) each one's own estimate, of L without its constant
    memory : (populations,) largest correlation of a coordinate before and after the last moves
    """

    points: FloatArray
    log_evidence: FloatArray
    memory: FloatArray

    @property
    def weights(self) -> FloatArray:
        """(populations,) by evidence, of sum one."""
        weights = np.exp(self.log_evidence - self.log_evidence.max())
        return np.asarray(weights / weights.sum())

    @property
    def evidence(self) -> tuple[float, float]:
        """Log of the mean evidence with its standard error from the populations' spread."""
        top = self.log_evidence.max()
        parts = np.exp(self.log_evidence - top)
        error = parts.std(ddof=1) / parts.mean() / math.sqrt(parts.size)
        return float(top + np.log(parts.mean())), float(error)

    def estimate(
        self, statistic: Callable[[FloatArray], FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """A statistic of all populations, with its standard error by the jackknife.

        Parameters
        ----------
        statistic : of weights (populations,), e.g. a weighted mean of the populations' means
        """
        weights = self.weights
        count = weights.size
        without = np.array([statistic(_drop(weights, index)) for index in range(count)])
        spread = ((without - without.mean(axis=0)) ** 2).sum(axis=0)
        return statistic(weights), np.sqrt((count - 1) / count * spread)


def _drop(weights: FloatArray, index: int) -> FloatArray:
    left = weights.copy()
    left[index] = 0.0
    return np.asarray(left / left.sum())


def anneal(
    likelihood: LoopLikelihood,
    log_likelihood: LogLikelihood,
    rng: np.random.Generator,
    populations: int = POPULATIONS,
) -> Reference:
    """Independent populations of the posterior of one loop.

    Parameters
    ----------
    likelihood : of the loop
    log_likelihood : the same, compiled
    rng : source of randomness
    populations : how many
    """
    found = [_population(likelihood, log_likelihood, child) for child in rng.spawn(populations)]
    points, log_evidence, memory = zip(*found, strict=True)
    return Reference(np.array(points), np.array(log_evidence), np.array(memory))


def log_prior(likelihood: LoopLikelihood, points: FloatArray) -> FloatArray:
    """(draws,) log prior density, its constant included."""
    constant = np.log(likelihood.prior.sd).sum() + 0.5 * COUNT * math.log(2 * math.pi)
    return np.asarray(likelihood.log_prior(points) - constant)


@dataclass
class _Particles:
    """Particles with the logs of their prior and likelihood, (particles,) each."""

    points: FloatArray
    prior: FloatArray
    likelihood: FloatArray


def _population(
    likelihood: LoopLikelihood, log_likelihood: LogLikelihood, rng: np.random.Generator
) -> tuple[FloatArray, float, float]:
    points = np.column_stack(
        [likelihood.prior.sample(PARTICLES, rng), rng.logistic(size=PARTICLES)]
    )
    particles = _Particles(points, log_prior(likelihood, points), log_likelihood(points))
    used = systems(likelihood)
    power, log_evidence = 0.0, 0.0
    while power < 1.0:
        following = _next_power(particles.likelihood, power)
        weights, gained = _weights(particles.likelihood, following - power)
        log_evidence, power = log_evidence + gained, following
        places = (np.arange(PARTICLES) + rng.random()) / PARTICLES
        chosen = rng.permutation(
            np.searchsorted(np.cumsum(weights), places).clip(max=PARTICLES - 1)
        )
        particles = _Particles(
            particles.points[chosen], particles.prior[chosen], particles.likelihood[chosen]
        )
        if power == 1.0:
            break
        for number in range(MOVES):
            _move(particles, power, used[number % len(used)], likelihood, log_likelihood, rng)
    before = particles.points.copy()
    kept = []
    moments = np.linspace(LAST_MOVES / 2, LAST_MOVES, SNAPSHOTS).astype(int)
    for number in range(1, LAST_MOVES + 1):
        _move(particles, 1.0, used[number % len(used)], likelihood, log_likelihood, rng)
        if number in moments:
            kept.append(particles.points.copy())
    both = zip(before.T, particles.points.T, strict=True)
    memory = max(float(np.corrcoef(one, other)[0, 1]) for one, other in both)
    return np.concatenate(kept), log_evidence, memory


def _weights(values: FloatArray, step: float) -> tuple[FloatArray, float]:
    """Weights (particles,) of sum one for a step of the power, and the log of their mean."""
    logs = np.where(np.isfinite(values), step * np.nan_to_num(values, neginf=0.0), -np.inf)
    top = logs.max()
    weights = np.exp(logs - top)
    return np.asarray(weights / weights.sum()), float(top + np.log(weights.mean()))


def _next_power(values: FloatArray, power: float) -> float:
    """The power at which the particles' effective share falls to `_KEPT_SHARE`; at most 1."""

    def share(following: float) -> float:
        weights, _ = _weights(values, following - power)
        return float(1 / (weights**2).sum() / weights.size)

    if share(1.0) > _KEPT_SHARE:
        return 1.0
    low, high = power, 1.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if share(middle) > _KEPT_SHARE else (low, middle)
    # At the start, where much of the prior is outside the support, no step may keep that share.
    return low if low > power else high


def _move(
    particles: _Particles,
    power: float,
    system: System,
    likelihood: LoopLikelihood,
    log_likelihood: LogLikelihood,
    rng: np.random.Generator,
) -> None:
    """One step of every particle by differential evolution, one half after the other."""
    halves = np.split(np.arange(PARTICLES), 2)
    best = 2.38 / math.sqrt(2 * particles.points.shape[1])
    for moved, others in (halves, halves[::-1]):
        position = system.forward(particles.points)
        here = position[moved]
        first, second = rng.choice(others, moved.size), rng.choice(others, moved.size)
        length = best * np.exp(rng.uniform(np.log(_SMALLEST), np.log(_LARGEST), moved.size))
        length = np.where(rng.random(moved.size) < _WHOLE, 1.0, length)
        jitter = _JITTER * position[others].std(axis=0) * rng.standard_normal(here.shape)
        proposed = here + length[:, None] * (position[first] - position[second]) + jitter
        points, log_jacobian = system.backward(proposed)
        inside = np.isfinite(log_jacobian) & np.isfinite(points).all(axis=1)
        points[~inside] = particles.points[moved[~inside]]
        prior, data = log_prior(likelihood, points), log_likelihood(points)
        with np.errstate(invalid="ignore"):
            ratio = prior - particles.prior[moved] + power * (data - particles.likelihood[moved])
            ratio += log_jacobian - system.backward(here)[1]
            accepted = inside & np.isfinite(data) & (np.log(rng.random(moved.size)) < ratio)
        taken = moved[accepted]
        particles.points[taken] = points[accepted]
        particles.prior[taken] = prior[accepted]
        particles.likelihood[taken] = data[accepted]
