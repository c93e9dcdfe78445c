"""Tables and words of a backtest's report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.forecast.backtest import ALPHA, CrossingScore, FigureScore
from hdprog.forecast.backtest_pool import (
    BacktestResult,
    Coverage,
    CrossingCourse,
    crossing_coverage,
    figure_skills,
    known_lateness,
)
from hdprog.reporting.backtest_words import crossings, late_words, range_words, share_words
from hdprog.reporting.figures.backtest_coverage import CoverageRow
from hdprog.reporting.outlook import limit_words
from hdprog.reporting.rounding import hours, share, significant, without_unit
from hdprog.reporting.sections.method import Passage
from hdprog.reporting.sections.table import Cell, Row, Table, Value
from hdprog.reporting.words import QUICK_RUN, capital, counted, listed, quantity, with_unit

_NONE = "\u2013"


def warnings(result: BacktestResult) -> list[str]:
    """What should not be trusted, the gravest first."""
    fleet = len(result.drives) > 1
    found = [f"Left out: {name}: {reason}" for name, reason in result.left_out]
    for drive in result.drives:
        name = f"{drive.name}: " if fleet else ""
        trends = [origin.test_id for origin in drive.origins if not origin.converged]
        if drive.unfitted:
            found.append(f"{name}Fits not converged: {listed(drive.unfitted)}.")
        if trends:
            found.append(
                f"{name}Trends not converged: those up to {listed(trends)} (marked * below)."
            )
        found += [name + text for text in drive.warnings]
        for key in dict.fromkeys(key for origin in drive.origins for key in origin.passed):
            count = sum(key in origin.passed for origin in drive.origins)
            found.append(
                f"{name}{capital(quantity(key).name)} had passed a limit at "
                f"{counted(count, 'test')}; nothing was left to forecast of that limit there."
            )
    if result.provenance.quick:
        found.append(QUICK_RUN)
    return found


def by_known(result: BacktestResult) -> Table:
    """Forecasts by the number of tests, of a drive that replaced another its own."""
    groups: list[tuple[str, str, list[CrossingScore]]] = [
        ("1 test", "the pace of wear is the prior's, or that of the drive before", []),
        ("2 tests", "the pace leans on the prior", []),
        ("3 tests and more", "", []),
    ]
    for drive in result.drives:
        for origin in drive.origins:
            groups[min(origin.known, 3) - 1][2].extend(origin.crossings)
    rows = [Row(name, _score_cells(scores), note=note) for name, note, scores in groups if scores]
    return Table.flat(
        "Forecasts of crossings by the tests that they rest on. CRPS is the error of a whole "
        "forecast in hours (for a forecast of one hour, its distance from the truth); the log "
        "score is in nats; both are better the smaller they are.",
        ("known", "forecasts", "held by 90 %", "held by 50 %", "CRPS", "log score"),
        rows,
    )


def by_drive(result: BacktestResult) -> Table:
    """One row a drive."""
    rows = []
    for drive in result.drives:
        seen = sum(score.crossing_seen for score in drive.crossings)
        rows.append(
            Row(
                drive.name,
                (
                    str(drive.tests),
                    *_score_cells(drive.crossings),
                    str(seen),
                    late_words(known_lateness([drive])),
                ),
                doubtful=not drive.converged,
            )
        )
    return Table.flat(
        "Forecasts of crossings by drive. Typically: the middle one of the errors of the median "
        "forecasts, in parts of the remaining life; “between its tests” where that forecast lies "
        "between the two tests between which the limit was passed, which do not tell early from "
        "late.",
        (
            "drive",
            "tests",
            "forecasts",
            "held by 90 %",
            "held by 50 %",
            "CRPS",
            "log score",
            "crossing seen",
            "typically",
        ),
        rows,
    )


def _score_cells(scores: Sequence[CrossingScore]) -> tuple[str, ...]:
    wide, narrow = crossing_coverage(scores, 0.9), crossing_coverage(scores, 0.5)
    if wide is None or narrow is None:
        return ("0", _NONE, _NONE, _NONE, _NONE)
    return (
        str(wide.count),
        _held(wide),
        _held(narrow),
        hours(float(np.mean([score.crps_hours for score in scores]))),
        significant(float(np.mean([score.log_score for score in scores]))),
    )


def _held(found: Coverage) -> str:
    """Count, and the share that should hold with the digits that the verdict has."""
    return f"{found.held} of {found.count}, {share_words(found.expected)} should"


def coverages(rows: Sequence[CoverageRow]) -> Table:
    """Counted shares with their ranges; p-values where the forecasts can be judged."""
    return Table.flat(
        "Share of intervals that held what came, with the range by count (Clopper-Pearson, 95 %) "
        "as if the forecasts were independent. Kupiec's p-value stands only where they nearly are.",
        ("what", "interval", "held", "share (95 % range)", "should be", "p-value"),
        [
            Row(
                capital(row.name),
                (
                    share(found.nominal),
                    f"{found.held} of {found.count}",
                    range_words(found),
                    share_words(found.expected),
                    significant(found.p_value, 2) if row.judged else _NONE,
                ),
            )
            for row in rows
            for found in [row.coverage]
        ],
    )


def accuracies(courses: Sequence[CrossingCourse], *, fleet: bool) -> Table:
    """Prognostic horizon and relative accuracy of each crossing that was seen.

    Parameters
    ----------
    courses : one a crossing
    fleet : whether there are other drives, so that each crossing is said to be whose
    """
    rows = []
    limits = dict.fromkeys(score.limit for course in courses for score in course.scores)
    keys = [limit.key for limit in limits]
    for course in courses:
        name = quantity(course.key).name
        if keys.count(course.key) > 1:
            name = limit_words(course.scores[0].limit)
        name = capital(name)
        horizon = course.prognostic_horizon
        rows.append(
            Row(
                f"{course.drive}: {name}" if fleet else name,
                (
                    _passed_at(course),
                    str(len(course.scores)),
                    _NONE if horizon is None else f"{hours(horizon)} before",
                    _relative_accuracy(course),
                    _last(course),
                ),
            )
        )
    return Table.flat(
        "Each crossing that was seen; where tests tell of it, below it the hours of the two "
        "between which the limit was passed, in which a forecast is neither early nor late. "
        "Prognostic horizon: from the first forecast with more than "
        f"even odds within {share(ALPHA)} of the remaining life. Cumulative relative accuracy: "
        "mean of 1 less the relative error of the remaining life, over the forecasts whose even "
        "odds came before the horizon (said where those are not all); 1 is exact, below 0 is an "
        "error of more than the whole.",
        (
            "crossing",
            "passed at",
            "forecasts",
            "prognostic horizon",
            "relative accuracy",
            "last forecast",
        ),
        rows,
    )


def _relative_accuracy(course: CrossingCourse) -> str:
    """Accuracy, and of how many forecasts where some had no median to be judged by."""
    if course.accuracy is None:
        return _NONE
    known = sum(score.accuracy is not None for score in course.scores)
    of = f" of {counted(known, 'forecast')}" if known < len(course.scores) else ""
    return significant(course.accuracy, 2) + of


def _passed_at(course: CrossingCourse) -> Cell:
    """Hour of the crossing; where tests tell of it, these two below it."""
    between = course.scores[-1].passed_between
    if between is None:
        return hours(course.crossed_at)
    first, last = map(hours, between)
    return Value(f"about {hours(course.crossed_at)}", f"{without_unit(first)} to {last}")


def _last(course: CrossingCourse) -> str:
    """How late the median of the last forecast was; one past the horizon has no number."""
    late = course.scores[-1].late_hours
    if course.scores[-1].within_tests:
        return "between its tests"
    if late is None:
        return "past the horizon"
    if abs(late) < 0.5:
        return "on time"
    return f"{hours(abs(late))} {'late' if late > 0 else 'early'}"


def skills(scores: Sequence[FigureScore]) -> Table:
    """Error of predictions of later tests' figures against a straight line's."""
    rows = []
    for name, chosen in (
        ("next test", [score for score in scores if score.ahead == 1]),
        ("all later tests", list(scores)),
    ):
        for skill in figure_skills(chosen):
            unit = quantity(skill.key).unit
            rows.append(
                Row(
                    f"{capital(quantity(skill.key).name)}, {name}",
                    (
                        str(skill.count),
                        with_unit(significant(skill.crps), unit),
                        with_unit(significant(skill.line_error), unit),
                        significant(skill.ratio, 2),
                    ),
                )
            )
    return Table.flat(
        "Error of the predicted figures (CRPS, in the figure's unit) against that of a straight "
        "line through the medians of the tests known; a ratio below 1 is better than the line.",
        ("figure", "predictions", "CRPS", "line's error", "ratio"),
        rows,
    )


def what_came(result: BacktestResult) -> str:
    """What the forecasts are compared with, in short."""
    scores = crossings(result.drives)
    truth = sum(score.from_truth for score in scores)
    model = "Loops were fitted with the drive model alone, without effects beside it."
    if not truth:
        return f"{model} What came later is read off the later tests."
    some = "" if truth == len(scores) else f" for {truth} of {len(scores)} forecasts"
    return (
        f"{model} The drive is simulated: what came later{some} is the true crossing from "
        "truth.json, which also reaches beyond the last test."
    )


def method(result: BacktestResult) -> list[Passage]:
    """How the scores came about."""
    scores = crossings(result.drives)
    truth = sum(score.from_truth for score in scores)
    came = (
        "What came later is read off the later tests: the hour at which straight lines between "
        "the medians of the figure, from the test of the forecast on, first pass the limit. Where "
        "wear speeds up, that is before the limit was passed, and where it slows down after it, by "
        "up to a good part of the time between the two tests; scores are by that hour all the "
        "same. “Early” and “late” are said of forecasts before or after both tests only. "
        "Where they do not, the limit counts as not passed up to the last test, and scores look "
        "at the hours up to there only. What lies behind a test with an event (regreased, "
        "reassembled, replaced) is left out, as no earlier forecast could know of it."
    )
    if truth:
        came = (
            f"For {counted(truth, 'forecast')} of {len(scores)} what came is the true crossing of "
            "a simulated drive (truth.json), seen up to the forecast's horizon, or to the last "
            "test before one with an event"
            + ("." if truth == len(scores) else f". For the others: {came}")
        )
    return [
        Passage(
            "Fits and trends",
            "Each loop was fitted once, with the drive model alone: effects beside it are found "
            "by pooling all tests, which would let an early forecast know of later ones. From "
            "each test but the last the trend was fitted anew to the tests up to there, and to "
            "nothing later. With one test only there is no pace of wear to be seen and the "
            "forecast is the wear prior's; with two it leans on it; both are scored like the "
            "others and stand in rows of their own.",
        ),
        Passage("What came later", came),
        Passage(
            "Scores of crossings",
            "CRPS: integral of the squared difference between the forecast distribution function "
            "and the step at the crossing (Gneiting & Ranjan 2011). Log score: negative log of "
            "the forecast density at the crossing, or of the chance of a later one where none was "
            "seen (Good 1952). Where what came fell: the distribution function at the crossing, "
            "drawn at random inside the lump of what lies behind the end (Czado et al. 2009). "
            "Alpha-lambda, prognostic horizon, relative accuracy: Saxena et al. 2010. A limit "
            "that was passed by the test of the forecast is not scored. As that is known of those "
            "that are, their forecasts are taken given that the limit was not passed by then: "
            "`hdprog run` at that test gives the chance of it as well.",
        ),
        Passage(
            "Scores of later tests",
            "The prediction of a later test is the state of the drive then, the scatter of a new "
            "mounting, and the spread that this test's own posterior turned out to have; it is "
            "scored by the median of that posterior. The line it is compared with is the "
            "least-squares line through the medians of the tests known, or their one median.",
        ),
        Passage(
            "What it does not say",
            "Forecasts from one test after another share their data and the crossing that they "
            "forecast, so a dozen of them weighs less than a dozen drives. Ranges and bands take "
            "them for independent. The whole says how forecasts of these drives would have been, "
            f"as far as what came was seen{_seen(result)}, not how the next drive's will be.",
        ),
    ]


def _seen(result: BacktestResult) -> str:
    """Where the scores end, if all at one hour: seldom the horizon that the drive declares."""
    ends = {score.seen_until for score in crossings(result.drives)}
    return f" (to {hours(*ends)})" if len(ends) == 1 else ""
