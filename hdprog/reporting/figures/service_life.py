"""The pictures of a drive's service life, for its report and its page: remaining life, trends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hdprog.config import Limit
from hdprog.reporting import outlook
from hdprog.reporting.figures.remaining_life import remaining_life
from hdprog.reporting.figures.trend_fan import trend_fan
from hdprog.reporting.picture_data import file_name
from hdprog.reporting.style import Picture
from hdprog.results import DriveResult


def life_picture(result: DriveResult) -> Picture | None:
    """Remaining life against the limits that are not passed yet; None if there is none."""
    coming = outlook.not_passed(result.forecasts)
    if outlook.overall(coming) is None:
        return None
    ahead = result.drive.forecast.next_shutdown_hours
    shown = ahead if outlook.shutdown_ahead(result) else None
    return remaining_life(
        coming,
        shown,
        doubtful=not result.converged,
        passed=outlook.passed(result.forecasts),
        dated=outlook.dated(result),
    )


def trend_pictures(result: DriveResult) -> list[tuple[Limit, Picture]]:
    """The course of each figure that has a limit, and that limit."""
    main = outlook.overall(result.forecasts)
    if result.trend is None or main is None:
        return []
    drawn = [
        (
            forecast.limit,
            trend_fan(
                result.trend.figures[forecast.limit.key],
                forecast,
                result.tests,
                doubtful=not result.converged,
                dated=outlook.dated(result),
                due=outlook.inspect_now(result, main),
            ),
        )
        for forecast in result.forecasts
        if forecast.limit is not None and forecast.limit.key in result.trend.figures
    ]
    return _named_apart(drawn)


def _named_apart(drawn: Sequence[tuple[Limit, Picture]]) -> list[tuple[Limit, Picture]]:
    """Give the files of a figure with several limits names of their own."""
    keys, apart = [limit.key for limit, _ in drawn], []
    for limit, found in drawn:
        data = found.data
        if data is not None and keys.count(limit.key) > 1:
            name = f"trend-{limit.key}-{limit.direction}-{limit.threshold:.9g}"
            found = replace(found, data=replace(data, file=file_name(name)))
        apart.append((limit, found))
    return apart
