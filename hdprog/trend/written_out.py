"""The Gaussian step written out: all tests' states at once, for draws of the hyperparameters.

The filter of `gaussian_step.StepAt` draws step by step, from more random numbers than there are
states. Here a draw is m + P^{-1/2} z with as many numbers as states, so that a move of the states
is a move of their numbers, too, and all tests can be moved along their ridges together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri, dtrtri

from hdprog.physics.parameters import FloatArray
from hdprog.trend.gaussian_step import GaussianStep, Tangents
from hdprog.trend.joint_gaussian import joint_gaussian


@dataclass(frozen=True)
class WrittenOut:
    """The Gaussian step given hyperparameters, for many draws of them; N = tests·n.

    Attributes
    ----------
    step : whose it is
    expected : (draws, N) of what the tests meet, before they are looked at
    trend : (draws, N, N) its precision
    log_root_trend : (draws,) half the log of its determinant
    centre : (draws, N) by trend and loops
    factor : (draws, N, N) lower Cholesky factor of the precision of both
    root : (draws, N, N) its inverse
    """

    step: GaussianStep
    expected: FloatArray
    trend: FloatArray
    log_root_trend: FloatArray
    centre: FloatArray
    factor: FloatArray
    root: FloatArray

    @staticmethod
    def of(step: GaussianStep, deviates: FloatArray) -> WrittenOut:
        """Given hyperparameters' deviates (draws, k)."""
        mean, covariance = joint_gaussian(*step.steps_of(deviates), step.wear_prior.scales)
        expected = mean.reshape(len(mean), -1)
        trend, log_root_trend = _inverse(covariance)
        pull, both = np.matmul(trend, expected[..., None])[..., 0], trend.copy()
        count = mean.shape[-1]
        for number, test in enumerate(step.tests):
            block = slice(number * count, (number + 1) * count)
            both[:, block, block] += test.loop.precision
            pull[:, block] += test.loop.information
        factor = _factors(both)
        root = np.array([dtrtri(one, lower=1)[0] for one in factor])
        centre = np.matmul(np.swapaxes(root, 1, 2), np.matmul(root, pull[..., None]))[..., 0]
        return WrittenOut(step, expected, trend, log_root_trend, centre, factor, root)

    @cached_property
    def own(self) -> tuple[slice, ...]:
        """Which of all numbers each test's own are drawn from; those before make the states."""
        return self.step.own_numbers(self.numbers)

    def having(self, rows: NDArray[np.intp], other: WrittenOut, of: NDArray[np.intp]) -> WrittenOut:
        """In some rows draws `of` another."""
        pairs = zip(self._parts, other._parts, strict=True)
        return WrittenOut(self.step, *(with_rows(a, rows, b[of]) for a, b in pairs))

    def having_only(self, rows: NDArray[np.intp]) -> WrittenOut:
        """Some of the draws."""
        return WrittenOut(self.step, *(part[rows] for part in self._parts))

    @property
    def _parts(self) -> tuple[FloatArray, ...]:
        trend = self.expected, self.trend, self.log_root_trend
        return *trend, self.centre, self.factor, self.root

    @property
    def size(self) -> int:
        """N, how many numbers the states are drawn from."""
        return int(self.centre.shape[1])

    @property
    def numbers(self) -> int:
        """How many standard normal numbers a draw takes."""
        return self.size + sum(test.own.mean.size for test in self.step.tests)

    @property
    def spread(self) -> FloatArray:
        """(draws, N) standard deviation of each of the states' numbers."""
        return np.asarray(np.sqrt(np.sum(self.root**2, axis=1)))

    def tangents(self, numbers: FloatArray) -> Tangents:
        """Draws from standard normal numbers (draws, numbers); their centre from zeros."""
        of_states = numbers[:, : self.size]
        away = np.einsum("dji,dj->di", self.root, of_states)
        states = (self.centre + away).reshape(len(numbers), len(self.step.tests), -1)
        return self.step.own_drawn(states, [numbers[:, own] for own in self.own])

    def numbers_of(self, tangents: Tangents, rows: NDArray[np.intp] | None = None) -> FloatArray:
        """The numbers (draws, numbers) that make these draws; rows as in `log_weight`."""
        states, own = tangents.states, []
        for place, (test, met) in enumerate(zip(self.step.tests, tangents.nuisances, strict=True)):
            own.append(test.own.deviates(states[:, place] - test.point, met))
        return np.hstack([self.numbers_of_states(states, rows), *own])

    def numbers_of_states(
        self, states: FloatArray, rows: NDArray[np.intp] | None = None
    ) -> FloatArray:
        """The numbers (draws, N) that make states (draws, tests, n); rows as in `log_weight`."""
        centre, factor = self.centre, self.factor
        if rows is not None:
            centre, factor = centre[rows], factor[rows]
        away = states.reshape(len(states), -1) - centre
        return np.asarray(np.einsum("dji,dj->di", factor, away))

    def log_weight(
        self, tangents: Tangents, rows: NDArray[np.intp] | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Log w up to a constant, and what the tests met (draws, tests, n).

        Parameters
        ----------
        tangents : draws
        rows : which of the draws of the hyperparameters they belong to; all of them if None
        """
        expected, trend = self.expected, self.trend
        if rows is not None:
            expected, trend = expected[rows], trend[rows]

        def squares(courses: FloatArray) -> FloatArray:
            return _squares(courses, expected, trend)

        return self.step.log_weight(tangents, squares)

    def given_others(
        self, block: slice, states: FloatArray, numbers: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Mean (draws, n) of one test's state given all others', and a draw's way from it.

        Parameters
        ----------
        block : of N, which of the states' numbers are the test's
        states : (draws, n) where the test is
        numbers : (draws, N) from which all states are drawn
        rng : source of randomness
        """
        rows = self.factor[:, block]
        precision = np.matmul(rows, np.swapaxes(rows, 1, 2))
        pull = np.matmul(rows, numbers[..., None])
        away = np.linalg.solve(precision, pull)[..., 0]
        upper = np.swapaxes(np.linalg.cholesky(precision), 1, 2)
        drawn = np.linalg.solve(upper, rng.standard_normal(pull.shape))[..., 0]
        return np.asarray(states - away), np.asarray(drawn)

    def trend_of(
        self, block: slice, courses: FloatArray
    ) -> Callable[[NDArray[np.intp], FloatArray], FloatArray]:
        """By how much the trend's log density (courses, rows) changes with one test alone.

        Parameters
        ----------
        block : of N, which numbers are the test's
        courses : (courses, draws, tests, n) from which they change

        Returns
        -------
        of rows of the draws, and changes (courses, rows, n)
        """
        away = courses.reshape(*courses.shape[:2], -1) - self.expected
        slope = np.matmul(self.trend[:, block], away[..., None])[..., 0]
        own = self.trend[:, block, block]

        def change(rows: NDArray[np.intp], by: FloatArray) -> FloatArray:
            bent = np.matmul(own[rows], by[..., None])[..., 0]
            return np.asarray(-np.sum(by * (slope[:, rows] + 0.5 * bent), axis=-1))

        return change

    def log_trend(self, courses: FloatArray) -> FloatArray:
        """Log density (courses, draws) that the trend has of courses (courses, draws, tests, n)."""
        return self.log_root_trend - 0.5 * _squares(courses, self.expected, self.trend)


def with_rows(old: FloatArray, rows: NDArray[np.intp], new: FloatArray) -> FloatArray:
    """A copy with other rows in some places."""
    found = old.copy()
    found[rows] = new
    return found


def _squares(courses: FloatArray, expected: FloatArray, trend: FloatArray) -> FloatArray:
    """Squared surprise (courses, draws) of courses (courses, draws, tests, n)."""
    away = courses.reshape(*courses.shape[:2], -1) - expected
    return np.asarray(np.sum(away * np.matmul(trend, away[..., None])[..., 0], axis=-1))


def _factors(matrices: FloatArray) -> FloatArray:
    """Lower Cholesky factors (draws, N, N); not numbers where a matrix is not positive.

    Such a draw of the hyperparameters has no weight, and is not taken.
    """
    found = np.empty_like(matrices)
    for into, one in zip(found, matrices, strict=True):
        factor, failed = dpotrf(one, lower=1)
        into[:] = np.nan if failed else factor
    return found


def _inverse(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Inverses (draws, N, N) of symmetric positive matrices; by LAPACK, a third of the work.

    And half the log of their determinants (draws,).
    """
    factors = _factors(covariance)
    found = np.array([dpotri(factor, lower=1)[0] for factor in factors])
    log_root = -np.sum(np.log(np.diagonal(factors, axis1=1, axis2=2)), axis=1)
    return np.asarray(np.tril(found) + np.swapaxes(np.tril(found, -1), 1, 2)), log_root
