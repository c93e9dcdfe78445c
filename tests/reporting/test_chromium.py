"""The report as a browser shows it."""

from __future__ import annotations

from pathlib import Path

from hdprog.reporting.build import build_report
from hdprog.reporting.figures.residual_strip import ADDED, RISING
from tests.browser import near, needs_chromium, render
from tests.reporting import drives, explanations

pytestmark = list(needs_chromium)


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


def test_a_browser_shows_the_residual_and_the_line_of_what_was_added(tmp_path: Path) -> None:
    page = build_report(explanations.single(explanations.record()))
    start = page.index('<section aria-labelledby="effects">')
    end = page.index('<section aria-labelledby="tests">')
    alone = page[: page.index("<header>")] + page[start:end] + "</body></html>"
    pixels = render(alone, tmp_path, 1000, 900)
    assert near(pixels, ADDED) > 500
    assert near(pixels, RISING) > 20
    # Thin outlines are mixed with the ground: what is warm is the falling branch.
    assert int((pixels[..., 0] - pixels[..., 2] > 0.3).sum()) > 300
