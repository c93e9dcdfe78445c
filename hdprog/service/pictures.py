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
    from hdprog.reporting.figures.service_life import life_picture, trend_pictures
    from hdprog.reporting.reader_units import shown_in
    from hdprog.reporting.style import house_style

    with house_style(), shown_in(result.drive.report):
        life = life_picture(result)
        trends = [drawn for _, drawn in trend_pictures(result)]
    return trends if life is None else [life, *trends]
