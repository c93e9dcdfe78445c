"""Chromium as the tests open pages with it."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.image
import numpy as np
import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
needs_chromium = (
    pytest.mark.chromium,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium browser is installed"),
)


@contextmanager
def chromium() -> Iterator[Browser]:
    """Open a headless browser for as long as the block runs."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield opened
        opened.close()


def render(page: str, folder: Path, width: int, height: int) -> np.ndarray:
    """Pixels (height, width, 3) of a page's first screen of that size."""
    source = folder / "report.html"
    source.write_text(page, "utf-8")
    with chromium() as browser:
        opened = browser.new_page(viewport={"width": width, "height": height})
        opened.goto(source.as_uri())
        return matplotlib.image.imread(io.BytesIO(opened.screenshot()))[..., :3]


def near(pixels: np.ndarray, colour: str) -> int:
    """Count of pixels of a colour."""
    wanted = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return int((np.abs(pixels - wanted).max(axis=-1) < 0.03).sum())


def violations(page: Page, only: str | None = None) -> list[str]:
    """What axe-core finds against the accessibility of a page, with the first place of each.

    Parameters
    ----------
    page : open in the browser
    only : one rule to look for; all where it is left out
    """
    from axe_playwright_python.sync_playwright import Axe

    # What passes is told by one place each: listing all of them takes as long as looking.
    options = {"resultTypes": ["violations"]} | ({"runOnly": [only]} if only else {})
    found = Axe().run(page, options=options).response["violations"]
    return [f"{one['id']}: {one['help']}: {one['nodes'][0]['html'][:200]}" for one in found]
