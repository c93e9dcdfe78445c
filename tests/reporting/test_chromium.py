"""The report as a browser shows it."""

from __future__ import annotations

import subprocess
from pathlib import Path

import matplotlib.image
import numpy as np

from hdprog.reporting.build import build_report
from tests.browser import CHROMIUM, needs_chromium
from tests.reporting import drives

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
)

pytestmark = list(needs_chromium)


def render(page: str, folder: Path, width: int, height: int) -> np.ndarray:
    """Pixels (height, width, 3) of a page."""
    source, picture = folder / "report.html", folder / "report.png"
    source.write_text(page, "utf-8")
    subprocess.run(
        [
            str(CHROMIUM),
            *OPTIONS,
            f"--user-data-dir={folder / 'profile'}",
            f"--window-size={width},{height}",
            f"--screenshot={picture}",
            source.as_uri(),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    return matplotlib.image.imread(picture)[..., :3]


def near(pixels: np.ndarray, colour: str) -> int:
    """Count of pixels of a colour."""
    wanted = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return int((np.abs(pixels - wanted).max(axis=-1) < 0.03).sum())


def test_the_first_screen_holds_the_verdict_and_the_pictures_are_drawn(tmp_path: Path) -> None:
    pixels = render(build_report(drives.past_limit()), tmp_path, 1000, 3000)
    # The verdict's edge in the colour of "act", on the first screen.
    assert near(pixels[:600], "#a82b00") > 1000
    # The limit line of the trend and the fitted loops.
    assert near(pixels, "#C44601") > 300
    assert near(pixels, "#0072B2") > 1000


def test_a_phone_needs_no_sideways_scrolling_of_the_page(tmp_path: Path) -> None:
    probe = (
        "<p id=probe></p><script>document.getElementById('probe').style.cssText="
        "'position:fixed;inset:0;z-index:9;margin:0;max-width:none;background:'+"
        "(document.documentElement.scrollWidth<=innerWidth?'#00ff00':'#ff0000')</script></body>"
    )
    page = build_report(drives.wearing(drives.LOST_MOTION, drives.SECANT, count=3))
    # The page's own policy forbids scripts; the probe needs one.
    policy = page.index('<meta http-equiv="Content-Security-Policy"')
    page = page[:policy] + page[page.index("\n", policy) :]
    pixels = render(page.replace("</body>", probe), tmp_path, 500, 800)
    assert near(pixels, "#00ff00") > 0.9 * pixels.shape[0] * pixels.shape[1]
