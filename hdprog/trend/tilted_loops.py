"""Gaussians of the loops that agree with the loops themselves where the trend lets them lie.

A loop linearised at one point knows its curvature there. All tests together leave a single test
wider than that holds: along its ridge a loop falls off faster on one side than on the other. By
expectation propagation (Minka, UAI 2001; Vehtari et al., J. Mach. Learn. Res. 21 (2020) 17) each
test's Gaussian becomes the one that has, beside what all other tests and the trend say of it (its
cavity), the mean and the covariance that the loop itself has there. Moments are those of weighted
draws. What is to come still weighs, or samples, by the loops: better Gaussians make it easier.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.information import Linearised
from hdprog.inference.pareto_weights import pareto_weights, worth
from hdprog.physics.parameters import FloatArray
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.gaussian_step import GaussianStep, Test
from hdprog.trend.relinearise import JointPrior
from hdprog.trend.ridge_map import onto_ridges
from hdprog.trend.wear_coordinates import possible, to_loop

_ROUNDS = 2
_DRAWS = 1500
_FEWEST = 100.0  # effective draws that moments are taken from
_TAILS = 8  # degrees of freedom of the draws
_WIDER = 1.2  # than the test's Gaussian, which the draws are
_HIGHEST_TOP = 4.0  # twice how far above its height at the mean a direction's top may be, in nats
_LITTLE = 0.1  # of the curvature of all that is said: no direction is given more


@dataclass(frozen=True)
class _Gaussian:
    """One test's numbers, (n,) and (n, n)."""

    mean: FloatArray
    covariance: FloatArray

    def squares(self, points: FloatArray) -> FloatArray:
        """Squared surprise (draws,) of points (draws, n)."""
        lower = np.linalg.cholesky(self.covariance)
        return np.asarray(np.sum(np.linalg.solve(lower, (points - self.mean).T) ** 2, axis=0))

    @staticmethod
    def weighted(points: FloatArray, weight: FloatArray) -> _Gaussian:
        """Of points (draws, n) by weights (draws,) that sum to one."""
        mean = weight @ points
        off = points - mean
        return _Gaussian(mean, np.asarray((weight[:, None] * off).T @ off))

    def as_if(self, seen: _Gaussian, right: _Gaussian) -> _Gaussian:
        """Moved and stretched as it takes to bring what was seen to what is right."""
        mend = np.linalg.cholesky(right.covariance) @ np.linalg.inv(
            np.linalg.cholesky(seen.covariance)
        )
        mean = right.mean + mend @ (self.mean - seen.mean)
        return _Gaussian(np.asarray(mean), np.asarray(mend @ self.covariance @ mend.T))


@dataclass(frozen=True)
class _Cavity:
    """What all but a test itself say of it: the Gaussian of all, over the test's own.

    Attributes
    ----------
    among : N(m, S) of all
    held : (n, n) the test's own precision Λ
    left : (n,) Λm − η
    """

    among: _Gaussian
    held: FloatArray
    left: FloatArray

    @staticmethod
    def of(among: _Gaussian, loop: Linearised) -> _Cavity:
        """Without a test's own loop."""
        held = loop.precision
        return _Cavity(among, held, np.asarray(held @ among.mean - loop.information))

    def log_density(self, points: FloatArray) -> FloatArray:
        """(draws,) of points (draws, n), up to a constant."""
        away = points - self.among.mean
        own = 0.5 * np.einsum("di,ij,dj->d", away, self.held, away) + away @ self.left
        return np.asarray(own - 0.5 * self.among.squares(points))

    def loop_of(self, found: _Gaussian) -> Linearised:
        """The loop that beside the cavity makes this Gaussian of all."""
        lower = np.asarray(np.linalg.cholesky(self.among.covariance))
        before = np.linalg.inv(self.among.covariance)
        gained = np.linalg.inv(found.covariance) - before
        # η' = Λ'm' + (S⁻¹ − Λ)(m' − m) − (Λm − η): the mean is the new one whatever was cut off.
        moved = found.mean - self.among.mean
        slope = (before - self.held) @ moved - self.left
        precision = _with_a_top(gained + self.held, slope, lower)
        return Linearised(precision, precision @ found.mean + slope, 0.0)


def with_tilted_loops(
    step: GaussianStep, deviates: FloatArray, rng: np.random.Generator
) -> GaussianStep:
    """The step with Gaussians that are taken from the loops.

    A test whose weighted draws are too few keeps the Gaussian that it has.

    Parameters
    ----------
    step : with linearised loops
    deviates : (k,) of the hyperparameters, which the trend is held at meanwhile
    rng : source of randomness
    """
    prior = step.joint_prior(deviates)
    for _ in range(_ROUNDS):
        step = _tilted(step, prior, rng)
    return step


def _tilted(step: GaussianStep, prior: JointPrior, rng: np.random.Generator) -> GaussianStep:
    """All tests at once, each by the others as they were."""
    count = prior.mean.shape[1]
    blocks = [slice(place * count, (place + 1) * count) for place in range(len(step.tests))]
    precision, pull = prior.precision.copy(), prior.precision @ prior.mean.ravel()
    for block, test in zip(blocks, step.tests, strict=True):
        precision[block, block] += test.loop.precision
        pull[block] += test.loop.information
    before = np.asarray(np.linalg.inv(prior.precision), dtype=float)
    covariance = np.asarray(np.linalg.inv(precision), dtype=float)
    mean = covariance @ pull
    tests = []
    for place, (block, test) in enumerate(zip(blocks, step.tests, strict=True)):
        if test.exact is not None:
            alone = _Gaussian(prior.mean[place], before[block, block])
            among = _Gaussian(mean[block], covariance[block, block])
            test = _test_tilted(test, alone, among, 1.0 / len(blocks), rng)
        tests.append(test)
    return step.having(tests)


def _test_tilted(
    test: Test, alone: _Gaussian, among: _Gaussian, share: float, rng: np.random.Generator
) -> Test:
    """One test's Gaussian, and that of its own numbers, anew.

    What the trend says of going round the ridge's bend it says of all tests together: a test
    counts its share of that.

    Parameters
    ----------
    test : as it is
    alone : what the trend says of it without any test
    among : what the trend and all tests say of it
    share : of one test in all
    rng : source of randomness
    """
    cavity = _Cavity.of(among, test.loop)
    drawn, proposed = _drawn(among, rng)
    met, log_slope = (each[:, 0] for each in onto_ridges([test.ridge], drawn[:, None]))
    off = drawn - test.point
    own = test.own.draw(off, rng.standard_normal((_DRAWS, test.own.mean.size)))
    with np.errstate(all="ignore"):
        bend = log_slope - 0.5 * (alone.squares(met) - alone.squares(drawn))
        said = test.log_ratio_of_own(off, to_loop(met), own) + share * bend
    inside = np.isfinite(said) & possible(met)
    if not inside.any():
        return test
    log_weight = np.where(inside, cavity.log_density(drawn) + said - proposed, -np.inf)
    weight, _ = pareto_weights(log_weight)
    if worth(weight) < _FEWEST:
        return test
    # The same draws tell moments that are known, too: by how much these err, those err alike.
    plain = np.exp(-0.5 * among.squares(drawn) - proposed)
    known = _Gaussian.weighted(drawn, plain / plain.sum())
    found = _Gaussian.weighted(drawn, weight).as_if(known, among)
    some = rng.choice(_DRAWS, _DRAWS, p=weight)
    fitted = Nuisances.fitted(off[some], own[some]) if own.shape[1] else test.own
    return replace(test, loop=cavity.loop_of(found), own=fitted)


def _drawn(among: _Gaussian, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draws (draws, n) of Student's t about a Gaussian, wider, and their log density (draws,)."""
    count = among.mean.size
    normal = rng.standard_normal((_DRAWS, count))
    normal *= np.sqrt(_TAILS / rng.chisquare(_TAILS, _DRAWS))[:, None]
    drawn = among.mean + _WIDER * normal @ np.linalg.cholesky(among.covariance).T
    density = -0.5 * (_TAILS + count) * np.log1p(np.sum(normal**2, axis=1) / _TAILS)
    return np.asarray(drawn), np.asarray(density)


def _with_a_top(precision: FloatArray, slope: FloatArray, lower: FloatArray) -> FloatArray:
    """A precision (n, n) without directions that speak for going away.

    Where there is a slope (n,), a direction has some curvature, if little: else the loop would be
    the likelier the farther one goes, and wear beyond all bounds with it.

    `lower` is the factor of the covariance in whose spreads directions are counted.
    """
    strength, vectors = np.linalg.eigh(lower.T @ precision @ lower)
    least = np.minimum((vectors.T @ (lower.T @ slope)) ** 2 / _HIGHEST_TOP, _LITTLE)
    root = np.linalg.solve(lower.T, vectors * np.sqrt(np.maximum(strength, least)))
    return np.asarray(root @ root.T)
