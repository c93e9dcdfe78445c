"""Whether an effect that is followed came at once between two tests, rather than with wear.

    y_j = l + g·w(t_j) + s·1(j ≥ k) + e_j

y_j is what test j says of an effect's amplitude, in units of the largest that any test showed; w a
course of the wear clock, from 0 at the first test to 1 at the last, over the hours and, where the
load is known, over hours that follow it more or less; e_j the test's own error and the scatter of
remounting. l, g and s are Gaussians as wide as the amplitude of a new drive, so
that the likelihood of all tests is a Gaussian. It is averaged over courses that start slowly, run
straight, level off and speed up, over the scatter, and over the tests k before which the step may
lie, and compared with that of s = 0 (a Bayes factor, Kass & Raftery, J. Am. Stat. Assoc. 90, 1995).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp

from hdprog.inference.priors import Prior
from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.results import lives
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.wear_clock import ServiceClock, WearClock
from hdprog.trend.wear_coordinates import StatePrior, from_loop, linearise
from hdprog.trend.wear_prior import SuddenStep, WearPrior

CLEAR = float(np.log(20.0))
"""Log Bayes factor from which a step is called; "strong" to Kass & Raftery."""
_WIDER = 10.0  # than their prior: amplitudes that a test does not show stay finite
_EITHER_SIDE = 2  # tests: the last alone may be a knee, the first alone a start that levels off
_EXPONENTS = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 4.0)
_CURVATURES = (-4.0, -2.0, 0.0, 2.0, 4.0, 8.0, 16.0)  # of wear that would be 1 at the last test
_NODES, _WEIGHTS = np.sqrt(3.0) * np.array([-1.0, 0.0, 1.0]), np.array([1.0, 4.0, 1.0]) / 6.0
"""Of a normal deviate (Gauss-Hermite quadrature of three points)."""


def came_at_once(
    tests: Sequence[FittedLoop], prior: Prior, wear_prior: WearPrior
) -> frozenset[str]:
    """Ids of the followed effects of which an amplitude has stepped; see `sudden_steps`."""
    followed = tests[0].followed
    if followed is None:
        return frozenset()
    steps = sudden_steps(tests, prior, wear_prior.following(followed.size, followed.greased))
    return frozenset(followed.owners[step.amplitude] for step in steps)


def sudden_steps(
    tests: Sequence[LoopEvidence], prior: Prior, wear_prior: WearPrior
) -> tuple[SuddenStep, ...]:
    """Find the steps of followed amplitudes, at most one of each between two replacements.

    Parameters
    ----------
    tests : in order of service hours
    prior : of the loops' coordinates
    wear_prior : of a state that holds the amplitudes
    """
    seen, spread = _amplitudes_seen(tests, StatePrior.of(prior, wear_prior))
    clock, found = ServiceClock.of(tests), []
    for own_tests in lives([test.event for test in tests]):
        life, first = tests[own_tests], own_tests.start
        new = life[0].service_hours if life[0].event == "replaced" else 0.0
        hours = np.array([test.service_hours for test in life])
        by_load = clock(hours) - clock(np.array(new)) if clock.by_load else None
        declared = np.array([wear_prior.event_variance(test.event) > 0 for test in life])
        for amplitude in range(wear_prior.followed):
            own = seen[own_tests, amplitude], spread[own_tests, amplitude]
            stepped = declared[:, len(NAMES) + amplitude]
            step = clear_step(hours - new, *own, stepped, wear_prior, by_load)
            if step is not None:
                found.append(SuddenStep(first + step, amplitude))
    return tuple(found)


def clear_step(
    age: FloatArray,
    seen: FloatArray,
    spread: FloatArray,
    declared: FloatArray,
    wear_prior: WearPrior,
    by_load: FloatArray | None = None,
) -> int | None:
    """Place of the first test after a step that the tests clearly show; None where none does.

    Parameters
    ----------
    age : (tests,) service hours since the drive was new
    seen, spread : (tests,) an amplitude and its standard deviation by each test alone, in units
        of the largest; where the effect was not found, about zero and how well that is known
    declared : (tests,) True where an event is declared that may leave a step
    wear_prior : for the size of amplitudes and the scatter of remounting
    by_load : (tests,) the same hours counted by load, where it is known: growth in a stretch of
        heavy load is wear
    """
    count = age.size
    places = [
        at
        for at in range(_EITHER_SIDE, count - _EITHER_SIDE + 1)
        if not declared[at] and age[at] > age[at - 1]
    ]
    if not places:
        return None
    belief = wear_prior.effect
    after = np.triu(np.ones((count, count)))  # row k is 1 from test k on
    constant = np.vstack([np.ones(count), after[np.flatnonzero(declared[1:]) + 1]])
    courses = np.concatenate([_courses(counted) for counted in _counted(age, by_load, wear_prior)])
    size = courses[:, :, None] * courses[:, None, :] + constant.T @ constant
    scatter = belief.scatter_scale * wear_prior.remounting_scatter.at(_NODES)
    noise = np.stack([np.diag(spread**2 + sd**2) for sd in scatter])
    grown = belief.initial_sd**2 * size + noise[:, None]

    def evidence(step: FloatArray) -> float:
        by_course = _log_density(seen, grown + belief.initial_sd**2 * np.outer(step, step))
        return float(logsumexp(by_course, b=_WEIGHTS[:, None] / len(courses)))

    gains = np.array([evidence(after[at]) for at in places]) - evidence(np.zeros(count))
    if logsumexp(gains) - np.log(len(places)) < CLEAR:
        return None
    return places[int(np.argmax(gains))]


def _counted(
    age: FloatArray, by_load: FloatArray | None, wear_prior: WearPrior
) -> list[FloatArray]:
    """Hours (tests,) by which wear may count: those served, and mixed with those by load."""
    if by_load is None:
        return [age]
    shares = wear_prior.load_share.at(_NODES)
    return [age, *((1.0 - share) * age + share * by_load for share in shares)]


def _courses(age: FloatArray) -> FloatArray:
    """(courses, tests) of the wear clock, from 0 at the first test to 1 at the last."""
    exponent, curvature = (grid.ravel() for grid in np.meshgrid(_EXPONENTS, _CURVATURES))
    clock = WearClock(np.ones_like(exponent), exponent, curvature, float(age[-1]))
    wear = clock.level(clock.expected(age))
    since = wear - wear[:, :1]
    return np.asarray(since / since[:, -1:])


def _log_density(value: FloatArray, covariance: FloatArray) -> FloatArray:
    """Log density (...) at (n,), up to a constant, of Gaussians of mean zero, (..., n, n)."""
    root = np.linalg.cholesky(covariance)
    whitened = np.linalg.solve(root, np.broadcast_to(value, root.shape[:-1])[..., None])[..., 0]
    widths = np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
    return np.asarray(-0.5 * np.sum(whitened**2, axis=-1) - widths)


def _amplitudes_seen(
    tests: Sequence[LoopEvidence], state_prior: StatePrior
) -> tuple[FloatArray, FloatArray]:
    """What each test alone says of the amplitudes: mean and standard deviation, (tests, k) each.

    By its likelihood, linearised at its own posterior's mean, and the prior of the loop's
    coordinates; amplitudes have next to none. A test in whose fit the effect is missing so tells
    how much of it there may be.
    """
    known = state_prior.sd**-2
    known[len(NAMES) :] /= _WIDER**2
    means, spreads = [], []
    for test in tests:
        loop = linearise(test, from_loop(test.posterior.mean(axis=0)))
        covariance = np.linalg.inv(loop.precision + np.diag(known))
        means.append(covariance @ (loop.information + known * state_prior.mean))
        spreads.append(np.sqrt(np.diag(covariance)))
    return np.array(means)[:, len(NAMES) :], np.array(spreads)[:, len(NAMES) :]
