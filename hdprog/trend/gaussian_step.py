"""The trend with Gaussians for the loops, and how far the loops themselves are from it.

Given the hyperparameters h, linearised loops and trend make one large Gaussian of all states. A
draw of it is a linear function of standard normal numbers z. It lies on the tangents of the loops'
ridges; put onto the ridges (see `ridge_map`) it is what the tests met, y, and beside it come the
tests' own numbers v. Draws of (h, z) then have the density of the whole model but for the factor

    w = p(y | h)/p(u | h) · Π_j L_j(y_j, v_j) φ(v_j) |dy_j/du_j| / (G_j(u_j) q_j(v_j | u_j)),

u the draw on the tangents, G_j the linearised loop, q_j its Gaussian of v_j: a weight for
importance sampling, and the likelihood of a sampler whose prior is the Gaussian step itself. It is
none where teeth are stiffer than they can be.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.information import Linearised
from hdprog.physics.parameters import FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.exact_likelihood import ExactLikelihood, Nuisances
from hdprog.trend.given_measured import GivenMeasured, Predictor
from hdprog.trend.relinearise import JointMode, JointPrior
from hdprog.trend.ridge_map import RidgeMap, onto_ridges
from hdprog.trend.smoother import draw
from hdprog.trend.state_space import Steps, Timeline, steps_of
from hdprog.trend.temperature import SeenTests
from hdprog.trend.wear_coordinates import StatePrior, possible, slope, to_loop
from hdprog.trend.wear_prior import WearPrior


@dataclass(frozen=True)
class Tangents:
    """Draws on the tangents of the loops' ridges, with the tests' own numbers.

    Attributes
    ----------
    states : (draws, tests, n) wear coordinates, scatter included
    nuisances : (tests) of (draws, k)
    """

    states: FloatArray
    nuisances: tuple[FloatArray, ...]

    def rows(self, chosen: NDArray[np.intp]) -> Tangents:
        """Keep some of the draws."""
        return Tangents(self.states[chosen], tuple(own[chosen] for own in self.nuisances))

    def turned(self, centre: Tangents, other: Tangents, angle: FloatArray) -> Tangents:
        """Go along the ellipse through this and other draws about a centre, by angles (draws,)."""
        cosine, sine = np.cos(angle), np.sin(angle)

        def between(one: FloatArray, middle: FloatArray, further: FloatArray) -> FloatArray:
            shape = (-1,) + (1,) * (one.ndim - 1)
            along, across = cosine.reshape(shape), sine.reshape(shape)
            return np.asarray(middle + along * (one - middle) + across * (further - middle))

        each = zip(self.nuisances, centre.nuisances, other.nuisances, strict=True)
        return Tangents(
            between(self.states, centre.states, other.states),
            tuple(between(*three) for three in each),
        )


class _Given:
    """Standard normal numbers that were drawn before, row by row, in the order they are asked."""

    def __init__(self, numbers: FloatArray) -> None:
        self._numbers, self._next = numbers, 0

    def standard_normal(self, shape: tuple[int, ...]) -> FloatArray:
        draws = len(self._numbers)
        width = int(np.prod(shape)) // draws
        some = self._numbers[:, self._next : self._next + width]
        self._next += width
        by_row = shape[0] == draws
        return np.asarray(some.reshape(shape) if by_row else some.T.reshape(shape))


class _Counted:
    """Counts how many standard normal numbers are asked for."""

    count = 0

    def standard_normal(self, shape: tuple[int, ...]) -> FloatArray:
        self.count += int(np.prod(shape))
        return np.zeros(shape)


@dataclass(frozen=True)
class Test:
    """One test: linearised, its ridge, its own numbers, and what it says exactly, if it does."""

    evidence: LoopEvidence
    loop: Linearised
    point: FloatArray
    ridge: RidgeMap
    own: Nuisances
    exact: ExactLikelihood | None

    def own_at(self, met: FloatArray) -> FloatArray:
        """Own numbers (k,) at their mode, given what the test met (n,)."""
        if self.exact is None or not self.own.mean.size:
            return self.own.mean
        return self.exact.own_at(to_loop(met))

    def log_ratio_of_own(self, off: FloatArray, loop: FloatArray, own: FloatArray) -> FloatArray:
        """Log of the part of w (draws,) that a test's own numbers change; −inf without support.

        Parameters
        ----------
        off : (draws, n) state on the tangent, from the point
        loop : (draws, n) the loop's coordinates of what the test met
        own : (draws, k)
        """
        if self.exact is None:
            return np.zeros(len(off))
        found = self.exact.log_likelihood(loop, own) - 0.5 * np.sum(own**2, axis=1)
        found -= self.own.log_density(off, own)
        return np.where(np.isnan(found), -np.inf, found)


@dataclass(frozen=True)
class GaussianStep:
    """The Gaussian step of a trend.

    Attributes
    ----------
    tests : in order
    seen : the tests as Gaussians
    timeline : of the tests
    state_prior, wear_prior : of the states
    """

    tests: tuple[Test, ...]
    seen: SeenTests
    timeline: Timeline
    state_prior: StatePrior
    wear_prior: WearPrior

    @staticmethod
    def of(
        tests: Sequence[LoopEvidence],
        mode: JointMode,
        timeline: Timeline,
        state_prior: StatePrior,
        wear_prior: WearPrior,
        alpha: float,
        softplus_scale: float,
    ) -> GaussianStep:
        """From tests that are linearised at the joint mode."""
        found = []
        for test, loop, point in zip(tests, mode.loops, mode.points, strict=True):
            exact, own = None, Nuisances.none(point.size)
            if test.exact is not None:
                exact, own = test.exact.about(to_loop(point))
                own = replace(own, slope=own.slope * slope(point))
            ridge = RidgeMap(point, alpha, softplus_scale)
            found.append(Test(test, loop, point, ridge, own, exact))
        seen = SeenTests.of(mode.loops, tests, wear_prior)
        return GaussianStep(tuple(found), seen, timeline, state_prior, wear_prior)

    def having(self, tests: Sequence[Test]) -> GaussianStep:
        """Like this, with other Gaussians for the tests."""
        seen = replace(self.seen, loops=[test.loop for test in tests])
        return replace(self, tests=tuple(tests), seen=seen)

    @property
    def gaussian(self) -> bool:
        """Whether linearised loops are all there is to know."""
        return all(test.exact is None for test in self.tests)

    def at(self, deviates: FloatArray) -> StepAt:
        """Given hyperparameters' deviates (draws, k)."""
        steps, scatter = self.steps_of(deviates)
        given = GivenMeasured.of(steps, scatter, self.seen.scales, self.seen.unknown_part)
        return StepAt(self, given.predictor, scatter)

    def steps_of(self, deviates: FloatArray) -> tuple[Steps, FloatArray]:
        """Steps along the tests, and scatter (draws,), of hyperparameters' deviates (draws, k)."""
        return steps_of(deviates, self.timeline, self.state_prior, self.wear_prior)

    def joint_prior(self, deviates: FloatArray) -> JointPrior:
        """What the trend says of all that the tests met, given hyperparameters' deviates (k,)."""
        steps, scatter = self.steps_of(deviates[None])
        return JointPrior.of(steps, float(scatter[0]), self.wear_prior.scales)

    def log_weight(
        self, tangents: Tangents, squares: Callable[[FloatArray], FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Log w (draws,) up to a constant, and what the tests met (draws, tests, n).

        Parameters
        ----------
        tangents : draws
        squares : squared surprise (courses, draws) of courses (courses, draws, tests, n)
        """
        states = tangents.states
        met, log_slope = self._onto_ridges(states)
        off, loops = states - self._points, to_loop(met)
        weight = log_slope - self._log_gaussians(off)
        for number, (test, own) in enumerate(zip(self.tests, tangents.nuisances, strict=True)):
            weight += test.log_ratio_of_own(off[:, number], loops[:, number], own)
        with np.errstate(all="ignore"):
            met_square, tangent_square = squares(np.stack([met, states]))
            weight += 0.5 * (tangent_square - met_square)
        inside = np.isfinite(weight) & possible(met).all(axis=1)
        return np.where(inside, weight, -np.inf), met

    def log_weight_of(
        self, number: int, states: FloatArray, own: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """One test's part of log w (draws,), and what it met (draws, n).

        Beside the parts there is what the trend says of all: p(y | h)/p(u | h).

        Parameters
        ----------
        number : of the test
        states : (draws, n) on its tangent
        own : (draws, k) numbers of its own
        """
        test = self.tests[number]
        if test.exact is None:
            return np.where(possible(states), 0.0, -np.inf), states
        met, log_slope = (each[:, 0] for each in onto_ridges([test.ridge], states[:, None]))
        off = states - test.point
        weight = log_slope + test.log_ratio_of_own(off, to_loop(met), own)
        weight -= np.sum(off * (self._steep[number] - 0.5 * off @ test.loop.precision), axis=1)
        inside = np.isfinite(weight) & possible(met)
        return np.where(inside, weight, -np.inf), met

    def on_tangents(self, met: FloatArray) -> FloatArray:
        """States (tests, n) on the tangents that stand for what the tests met (tests, n)."""
        each = zip(self.tests, met, strict=True)
        return np.stack(
            [
                one if test.exact is None else test.ridge.tangents_of(one[None])[0]
                for test, one in each
            ]
        )

    def _onto_ridges(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What tests met (draws, tests, n), on the ridges of those that are not linear.

        And the log derivative (draws,) of all together.
        """
        met, log_slope = onto_ridges([test.ridge for test in self.tests], states)
        bent = self._bent
        return np.where(bent[:, None], met, states), log_slope[:, bent].sum(axis=1)

    def _log_gaussians(self, off: FloatArray) -> FloatArray:
        """Log of the linearised loops (draws,) at states off their points, (draws, tests, n)."""
        pull = self._steep - 0.5 * np.matmul(self._precision, off[..., None])[..., 0]
        return np.asarray(np.sum((off * pull)[:, self._bent], axis=(1, 2)))

    @cached_property
    def _points(self) -> FloatArray:
        return np.stack([test.point for test in self.tests])

    @cached_property
    def _precision(self) -> FloatArray:
        return np.stack([test.loop.precision for test in self.tests])

    @cached_property
    def _steep(self) -> FloatArray:
        """(tests, n) slopes of the linearised loops at their points."""
        information = np.stack([test.loop.information for test in self.tests])
        return np.asarray(information - np.matmul(self._precision, self._points[..., None])[..., 0])

    @cached_property
    def _bent(self) -> NDArray[np.bool_]:
        """(tests,) whether a test's linearisation is not exact."""
        return np.array([test.exact is not None for test in self.tests])

    def own_drawn(self, states: FloatArray, deviates: Sequence[FloatArray]) -> Tangents:
        """Draws with the tests' own numbers from standard normal ones (tests) of (draws, k)."""
        each = zip(self.tests, deviates, strict=True)
        own = (
            test.own.draw(states[:, number] - test.point, given)
            for number, (test, given) in enumerate(each)
        )
        return Tangents(states, tuple(own))

    def numbers(self, deviates: FloatArray) -> int:
        """How many standard normal numbers a draw takes."""
        counted = _Counted()
        self.at(deviates[:1])._states(cast("np.random.Generator", counted))
        return counted.count + sum(test.own.mean.size for test in self.tests)

    def own_numbers(self, numbers: int) -> tuple[slice, ...]:
        """Which of all numbers each test's own are drawn from; the others make the states."""
        ends = np.cumsum([0, *(test.own.mean.size for test in self.tests)])
        first = numbers - ends[-1]
        return tuple(slice(first + a, first + b) for a, b in itertools.pairwise(ends))


@dataclass(frozen=True)
class StepAt:
    """The Gaussian step given hyperparameters, for many draws of them.

    Attributes
    ----------
    step : whose it is
    predictor : of what each test met
    scatter : (draws,) of remounting
    """

    step: GaussianStep
    predictor: Predictor
    scatter: FloatArray

    def tangents(self, numbers: FloatArray) -> Tangents:
        """Draws from standard normal numbers (draws, numbers); their centre from zeros."""
        given = cast("np.random.Generator", _Given(numbers))
        states = self._states(given)
        sizes = (test.own.mean.size for test in self.step.tests)
        own = [given.standard_normal((len(numbers), size)) for size in sizes]
        return self.step.own_drawn(states, own)

    def log_weight(self, tangents: Tangents) -> tuple[FloatArray, FloatArray]:
        """Log w (draws,) up to a constant, and what the tests met (draws, tests, n)."""
        return self.step.log_weight(tangents, self.predictor.squares)

    def _states(self, rng: np.random.Generator) -> FloatArray:
        seen = self.step.seen
        course = draw(self.predictor.steps, seen.observations, self.scatter, rng)
        return seen.draw_measured(course.states, self.scatter, rng)
