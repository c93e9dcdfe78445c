"""A backtest in plain words: how often forecasts held, how late they came, how few they are."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hdprog.forecast.backtest import CrossingScore, FigureScore
from hdprog.forecast.backtest_pool import (
    FEW,
    KNOWN,
    BacktestResult,
    Coverage,
    DriveScores,
    Lateness,
    crossing_coverage,
    distinct_crossings,
    figure_coverage,
    figure_skills,
    known_lateness,
)
from hdprog.reporting.rounding import hours, percent, share, significant
from hdprog.reporting.verdict import Status, Verdict
from hdprog.reporting.words import agree, capital, counted, listed, quantity, tidy


def headline(result: BacktestResult) -> tuple[str, ...]:
    """Sentences in the order of their weight: convergence, crossings, lateness, later tests."""
    said = [] if result.converged else [_not_converged(result)]
    said += [_held(result), *_late(result), *_few(result), *_next_tests(result)]
    return tuple(tidy(sentence) for sentence in said)


def verdict(result: BacktestResult) -> Verdict:
    """Headline with a label; a judgement only where there are enough crossings for one."""
    drives = result.drives
    found = crossing_coverage(crossings(drives), 0.9)
    status: Status = "present"
    if found is None:
        label = "Nothing to score"
    elif distinct_crossings(drives) < FEW:
        label = "Too few forecasts for a verdict"
    elif agrees(found):
        status, label = "good", "Held as often as they should"
    else:
        status = "act"
        label = "Intervals too narrow" if found.share < found.expected else "Intervals too wide"
    if not result.converged:
        label += " \u2013 provisional"
    return Verdict(status, not result.converged, label, headline(result))


def crossings(drives: Sequence[DriveScores]) -> list[CrossingScore]:
    """Scores of crossings of all drives."""
    return [score for drive in drives for score in drive.crossings]


def figures(drives: Sequence[DriveScores], ahead: int | None = None) -> list[FigureScore]:
    """Scores of figures of all drives, of the tests so many after the origin only if asked."""
    scores = [score for drive in drives for score in drive.figures]
    return [score for score in scores if ahead in (None, score.ahead)]


def agrees(found: Coverage) -> bool:
    """Whether the share that should hold lies in the range that the count allows."""
    low, high = found.range
    return low <= found.expected <= high


def range_words(found: Coverage) -> str:
    """Share with its range: "89 % (71 to 98 %)"."""
    low, high = found.range
    return f"{share_words(found.share)} ({100 * low:.0f} to {share_words(high)})"


def share_words(value: float) -> str:
    """Counted share in whole per cent."""
    return share(round(value, 2))


def _not_converged(result: BacktestResult) -> str:
    parts = []
    for drive in result.drives:
        fits = [f"the {agree(len(drive.unfitted), 'fit', 'fits')} of {listed(drive.unfitted)}"]
        trends = [origin.test_id for origin in drive.origins if not origin.converged]
        own = fits if drive.unfitted else []
        if trends:
            own.append(f"the {agree(len(trends), 'trend', 'trends')} up to {listed(trends)}")
        if own:
            name = f"{drive.name}: " if len(result.drives) > 1 else ""
            parts.append(name + listed(own))
    return f"Not converged: {'; '.join(parts)}. Scores that rest on them are provisional."


def _held(result: BacktestResult) -> str:
    scores = crossings(result.drives)
    found = crossing_coverage(scores, 0.9)
    if found is None:
        return (
            "There is no forecast to score: every limit was passed by the first test, or nothing "
            "later was seen."
        )
    seen = sum(score.crossing_seen for score in scores)
    count = distinct_crossings(result.drives)
    noun = "crossing" if seen == found.count else "limit"
    forecasts = f"{counted(found.count, 'forecast')} of {counted(count, noun)}"
    interval = f"{agree(found.count, 'its', 'their')} 90 % interval"
    if not seen:
        chance = sum(score.crossed_by_then for score in scores) / len(scores)
        ends = {score.seen_until for score in scores}
        end = hours(max(ends)) if len(ends) == 1 else "the end of what was seen"
        return (
            f"No limit was passed by {end}: {forecasts} had given that {percent(1 - chance)} on "
            f"average, and {found.held} of them {agree(found.held, 'holds', 'hold')} it in "
            f"{interval}."
        )
    missing = found.count - seen
    what = f"what came (for {missing} that the limit was not passed)" if missing else "the crossing"
    return (
        f"Of {forecasts}, {found.held} held {what} in {interval}: "
        f"{range_words(found)} by count, where {_should(found)}."
    )


def _should(found: Coverage) -> str:
    """What share should hold: "90 % should"; where it is another than the name says, why."""
    should = f"{share_words(found.expected)} should"
    if share_words(found.expected) == share_words(found.nominal):
        return should
    return f"{should}, as intervals that run past what was seen hold more than their name says"


def late_words(late: Lateness | None) -> str:
    """Typical lateness: "12 % late", "3 % early", "past the horizon"; an en dash for none.

    "Between its tests" where the tests of the crossing do not tell early from late.
    """
    if late is None:
        return "\u2013"
    if late.within_tests:
        return "between its tests"
    if math.isinf(late.share):
        return "past the horizon"
    side = "late" if late.share > 0 else "early"
    return "on time" if abs(late.share) < 0.005 else f"{share_words(abs(late.share))} {side}"


def _late(result: BacktestResult) -> list[str]:
    late = known_lateness(result.drives)
    if late is None:
        return []
    informed = known_lateness(result.drives, known=KNOWN)
    said = f"Typically the even odds came {_late_by(late)}"
    if informed is not None and _late_by(informed) != _late_by(late):
        said += f"; with {KNOWN} tests and more known, {_late_by(informed)}"
    return [said + "."]


def _late_by(late: Lateness) -> str:
    if late.within_tests:
        return "between the two tests between which the limit was passed"
    words = late_words(late)
    number, _, side = words.rpartition(" ")
    return f"{number} of the remaining life {side}" if side in ("late", "early") else words


def _few(result: BacktestResult) -> list[str]:
    count = distinct_crossings(result.drives)
    if not 0 < count < FEW:
        return []
    return [
        "Forecasts of one limit from test after test are right or wrong together: "
        f"{counted(count, 'limit')} {agree(count, 'is', 'are')} too few for a verdict on the "
        "intervals."
    ]


def _next_tests(result: BacktestResult) -> list[str]:
    scores = figures(result.drives, ahead=1)
    found = figure_coverage(scores, 0.9)
    if found is None:
        return []
    ratios = [
        f"{significant(skill.ratio, 2)} for {quantity(skill.key).name}"
        for skill in figure_skills(figures(result.drives))
        if skill.ratio is not None and skill.count >= FEW
    ]
    said = (
        f"Of {counted(found.count, 'prediction')} of a figure at the very next test {found.held} "
        f"held what was measured in {agree(found.count, 'its', 'their')} 90 % interval: "
        f"{range_words(found)}."
    )
    if not ratios:
        return [said]
    error = "Over all later tests the error (CRPS) in parts of a straight line's is "
    return [said, capital(f"{error}{listed(ratios)}; below 1 is better than the line.")]
