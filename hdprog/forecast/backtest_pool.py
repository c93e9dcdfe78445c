"""Scores of many forecasts taken together: how often they held, how late they came."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.forecast.backtest import CrossingScore, FigureScore, OriginScores
from hdprog.forecast.scores import (
    coverage_range,
    cumulative_relative_accuracy,
    kupiec_p_value,
    prognostic_horizon,
)
from hdprog.results import Provenance

FEW = 10
"""Crossings below which a share of forecasts that held says too little for a verdict."""
KNOWN = 3
"""Tests from which on the pace of wear is the drive's more than the prior's."""
_ACCURATE = 0.5


@dataclass(frozen=True)
class DriveScores:
    """The backtest of one drive.

    Attributes
    ----------
    drive_id, name : of the drive, and of its folder
    tests : how many it has
    horizon_hours : of its forecasts, in service hours
    unfitted : ids of tests whose fit did not converge
    origins : from the first test to the last but one
    warnings : in words
    """

    drive_id: str
    name: str
    tests: int
    horizon_hours: float
    unfitted: tuple[str, ...]
    origins: tuple[OriginScores, ...]
    warnings: tuple[str, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether every fit and every trend converged."""
        return not self.unfitted and all(origin.converged for origin in self.origins)

    @property
    def crossings(self) -> tuple[CrossingScore, ...]:
        """Scores of crossings from all origins."""
        return tuple(score for origin in self.origins for score in origin.crossings)

    @property
    def figures(self) -> tuple[FigureScore, ...]:
        """Scores of figures from all origins."""
        return tuple(score for origin in self.origins for score in origin.figures)


@dataclass(frozen=True)
class BacktestResult:
    """The backtest of a drive or of a fleet.

    Attributes
    ----------
    name : of the folder
    drives : in order of their folders
    left_out : names of drives that could not be used, and why
    provenance : how it came about
    seconds : spent by stage
    """

    name: str
    drives: tuple[DriveScores, ...]
    left_out: tuple[tuple[str, str], ...]
    provenance: Provenance
    seconds: Mapping[str, float]

    @property
    def converged(self) -> bool:
        """Whether every fit and every trend converged."""
        return all(drive.converged for drive in self.drives)


@dataclass(frozen=True)
class Coverage:
    """How often an interval held the truth.

    Attributes
    ----------
    nominal : share that the interval is named after, e.g. 0.9
    held, count : how many did, of how many
    expected : share that calibrated forecasts would hold, from the forecasts themselves
    """

    nominal: float
    held: int
    count: int
    expected: float

    @property
    def share(self) -> float:
        """Share that held."""
        return self.held / self.count

    @property
    def range(self) -> tuple[float, float]:
        """Clopper-Pearson 95 % range of the share, were the forecasts independent."""
        return coverage_range(self.held, self.count)

    @property
    def p_value(self) -> float | None:
        """Kupiec's against the expected share; None where that is 1."""
        return kupiec_p_value(self.held, self.count, self.expected) if self.expected < 1 else None


@dataclass(frozen=True)
class FigureSkill:
    """How well later tests' values of one figure were predicted.

    Attributes
    ----------
    key : the figure's
    count : predictions
    crps, line_error : mean over them, in the figure's unit
    """

    key: str
    count: int
    crps: float
    line_error: float

    @property
    def ratio(self) -> float | None:
        """CRPS over the straight line's; below 1 is better than the line."""
        return self.crps / self.line_error if self.line_error > 0 else None


@dataclass(frozen=True)
class CrossingCourse:
    """The forecasts of one crossing that was seen, from origin to origin.

    Attributes
    ----------
    drive, key : name of its folder, and the limit's figure
    first_hours : service hours of the drive's first test, since it was replaced if it was
    crossed_at : service hours of the crossing
    origins : service hours of the origins
    scores : at the origins
    prognostic_horizon : hours before the crossing from the first accurate forecast, or None
    accuracy : cumulative relative accuracy of the forecasts with a median, or None without one
    """

    drive: str
    key: str
    first_hours: float
    crossed_at: float
    origins: tuple[float, ...]
    scores: tuple[CrossingScore, ...]
    prognostic_horizon: float | None
    accuracy: float | None


def bins_for(transforms: int) -> int:
    """Bins of a histogram of so many transforms: six in each at least, ten at most."""
    return int(np.clip(transforms // 6, 2, 10))


def crossing_coverage(scores: Sequence[CrossingScore], level: float) -> Coverage | None:
    """How many intervals of a level held the crossing; None without forecasts."""
    if not scores:
        return None
    expected = float(np.mean([score.own_probability[level] for score in scores]))
    return Coverage(level, sum(score.held[level] for score in scores), len(scores), expected)


def figure_coverage(scores: Sequence[FigureScore], level: float) -> Coverage | None:
    """How many intervals of a level held a later test's figure; None without predictions."""
    if not scores:
        return None
    return Coverage(level, sum(score.held[level] for score in scores), len(scores), level)


def lateness(drives: Sequence[DriveScores], known: int = 1) -> float | None:
    """How late the typical forecast came: the middle one of the relative errors.

    Each is the error of the median forecast over the remaining life; above zero is late, infinite
    for a median past the horizon, so that the middle one is what half of the forecasts exceed.
    None without a crossing that was seen.

    Parameters
    ----------
    drives : scored
    known : fewest tests that a forecast rests on, to be counted
    """
    errors = [
        math.inf
        if score.late_hours is None
        else score.late_hours / (score.crossed_at - origin.service_hours)
        for drive in drives
        for origin in drive.origins
        for score in origin.crossings
        if score.crossing_seen and origin.known >= known
    ]
    return float(np.quantile(errors, 0.5, method="inverted_cdf")) if errors else None


@dataclass(frozen=True)
class Lateness:
    """How late a forecast's even odds came, as far as what came tells.

    Attributes
    ----------
    share : error over the remaining life; above zero is late, infinite past the horizon
    within_tests : the even odds lie between the tests between which the limit was passed, so that
        they are not known to be early or late
    """

    share: float
    within_tests: bool


def known_lateness(drives: Sequence[DriveScores], known: int = 1) -> Lateness | None:
    """Find the middle forecast of those that came early, between the tests, and late.

    As `lateness`, where forecasts between the tests count as neither. None without a crossing that
    was seen.

    Parameters
    ----------
    drives : scored
    known : fewest tests that a forecast rests on, to be counted
    """
    found = []
    for drive in drives:
        for origin in drive.origins:
            for score in origin.crossings:
                if not score.crossing_seen or origin.known < known:
                    continue
                late = score.late_hours
                life = score.crossed_at - origin.service_hours
                share = math.inf if late is None else late / life
                found.append(Lateness(share, score.within_tests))
    found.sort(key=lambda one: 0.0 if one.within_tests else one.share)
    return found[(len(found) - 1) // 2] if found else None


def figure_skills(scores: Sequence[FigureScore]) -> tuple[FigureSkill, ...]:
    """Skill of each figure, in the order of the scores."""
    skills = []
    for key in dict.fromkeys(score.key for score in scores):
        own = [score for score in scores if score.key == key]
        crps = float(np.mean([score.crps for score in own]))
        skills.append(
            FigureSkill(key, len(own), crps, float(np.mean([score.line_error for score in own])))
        )
    return tuple(skills)


def crossing_courses(drives: Sequence[DriveScores]) -> tuple[CrossingCourse, ...]:
    """Forecasts of every crossing that was seen, by drive, limit and hour.

    A limit may be crossed again, by the drive that replaced another or after a repair.
    """
    courses = []
    for drive in drives:
        seen = [score for score in drive.crossings if score.crossing_seen]
        for limit, crossed_at in dict.fromkeys((one.limit, one.crossed_at) for one in seen):
            found = [
                (origin, score)
                for origin in drive.origins
                for score in origin.crossings
                if (score.limit, score.crossed_at) == (limit, crossed_at)
            ]
            hours = [origin.service_hours for origin, _ in found]
            scores = [score for _, score in found]
            accurate = [(score.within_alpha or 0.0) > _ACCURATE for score in scores]
            known = [score.accuracy for score in scores if score.accuracy is not None]
            accuracy = cumulative_relative_accuracy(known)
            courses.append(
                CrossingCourse(
                    drive.name,
                    limit.key,
                    found[0][0].new_at_hours,
                    crossed_at,
                    tuple(hours),
                    tuple(scores),
                    prognostic_horizon(hours, accurate, crossed_at),
                    None if math.isnan(accuracy) else accuracy,
                )
            )
    return tuple(courses)


def distinct_crossings(drives: Sequence[DriveScores]) -> int:
    """Crossings (of a limit by a drive) that were forecast, from however many origins.

    What is crossed again counts once all the same: tests that scatter about a limit cross it often.
    A drive that replaced another is one of its own.
    """
    return sum(
        len(
            {
                (origin.new_at_hours, score.limit)
                for origin in one.origins
                for score in origin.crossings
            }
        )
        for one in drives
    )
