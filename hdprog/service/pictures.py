"""The pictures of a drive's page, drawn once when it is analysed: remaining life, then trends."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from hdprog.atomic import atomic_write_text

if TYPE_CHECKING:
    from hdprog.reporting.style import Picture
    from hdprog.results import DriveResult


def write_pictures(result: DriveResult, folder: Path) -> None:
    """Write each picture as an SVG, and the words of all as pictures.json.

    Parameters
    ----------
    result : of a drive's run
    folder : to be made
    """
    folder.mkdir(exist_ok=True)
    words = []
    for number, picture in enumerate(_pictures(result)):
        atomic_write_text(folder / f"{number}.svg", svg_of(picture.uri))
        words.append(
            {
                "alt": picture.alt,
                "shows": picture.shows,
                "action": picture.action,
                "width": picture.width,
                "height": picture.height,
            }
        )
    atomic_write_text(folder / "pictures.json", json.dumps(words, indent=1))


def svg_of(uri: str) -> str:
    """Give the text of an SVG in a `data:` address."""
    return unquote(uri.partition(",")[2])


def _pictures(result: DriveResult) -> list[Picture]:
    from hdprog.reporting import outlook
    from hdprog.reporting.figures.remaining_life import remaining_life
    from hdprog.reporting.figures.trend_fan import trend_fan
    from hdprog.reporting.reader_units import shown_in
    from hdprog.reporting.style import house_style

    drawn: list[Picture] = []
    coming = outlook.not_passed(result.forecasts)
    with house_style(), shown_in(result.drive.report):
        if outlook.overall(coming) is not None:
            ahead = result.drive.forecast.next_shutdown_hours
            shown = ahead if outlook.shutdown_ahead(result) else None
            drawn.append(
                remaining_life(
                    coming,
                    shown,
                    doubtful=not result.converged,
                    passed=outlook.passed(result.forecasts),
                )
            )
        if result.trend is not None:
            drawn += [
                trend_fan(
                    result.trend.figures[one.limit.key],
                    one,
                    result.tests,
                    doubtful=not result.converged,
                )
                for one in result.forecasts
                if one.limit is not None and one.limit.key in result.trend.figures
            ]
    return drawn
