"""The checked-in examples in a real browser: light and dark, phone and desktop, and on paper."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from hdprog.reporting.fleet_index import build_fleet_index, fleet_drive
from hdprog.reporting.summary import summary_json
from tests.browser import chromium, needs_chromium, violations
from tests.example_reports.build import REPORTS
from tests.reporting.situations import SITUATIONS, report_of

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

EXAMPLES = sorted(REPORTS.glob("*.html"))
PATIENCE = 120_000  # ms; a loaded machine draws slowly
LOOKS = [("light", 1200), ("dark", 390)]
A4 = (int((210 - 2 * 13) / 25.4 * 96), int((297 - 2 * 14) / 25.4 * 96))  # px inside the margins

pytestmark = list(needs_chromium)


@pytest.fixture(scope="module", name="browser")
def browser_fixture() -> Iterator[Browser]:
    with chromium() as opened:
        yield opened


def opened(browser: Browser, path: Path, scheme: str, width: int) -> tuple[Page, list[str]]:
    """Page of a file, and what the browser complains of or asks for outside of the file."""
    context = browser.new_context(
        color_scheme="dark" if scheme == "dark" else "light",
        viewport={"width": width, "height": 900},
    )
    context.set_default_timeout(PATIENCE)
    page, faults = context.new_page(), []
    page.on("console", lambda line: faults.append(line.text) if line.type != "log" else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on(
        "request",
        lambda asked: (
            None if asked.url.startswith(("data:", path.as_uri())) else faults.append(asked.url)
        ),
    )
    page.goto(path.as_uri())
    return page, faults


def test_there_are_examples_to_open() -> None:
    assert len(EXAMPLES) >= 6


@pytest.mark.parametrize(("scheme", "width"), LOOKS)
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_opens_without_a_fault(
    browser: Browser, path: Path, scheme: str, width: int
) -> None:
    page, faults = opened(browser, path, scheme, width)
    assert page.evaluate("[...document.images].filter(i => !i.naturalWidth).map(i => i.alt)") == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert violations(page) == []
    assert faults == []
    page.context.close()


@pytest.mark.parametrize("name", SITUATIONS)
def test_every_situation_is_accessible(browser: Browser, tmp_path: Path, name: str) -> None:
    path = tmp_path / "report.html"
    path.write_text(report_of(name), "utf-8")
    page, faults = opened(browser, path, "light", 1200)
    assert violations(page) == []
    page.emulate_media(color_scheme="dark")
    assert violations(page, only="color-contrast") == []
    assert faults == []
    page.context.close()


@pytest.mark.parametrize(("scheme", "width"), LOOKS)
def test_the_fleet_index_is_accessible(
    browser: Browser, tmp_path: Path, scheme: str, width: int
) -> None:
    made = [summary_json(SITUATIONS[name]()) for name in ("past-the-limit", "healthy")]
    content = {
        "fleet": "cell 3",
        "created": "2026-03-02T05:58:00+00:00",
        "quick": False,
        "seed": 0,
        "command": "hdprog fleet cell3",
        "hdprog_version": "0.1.0",
        "drives": [fleet_drive(f"d{i}", f"drives/d{i}", one) for i, one in enumerate(made)],
        "left_out": [{"folder": "d9", "reason": "no tests.csv"}],
    }
    path = tmp_path / "index.html"
    path.write_text(build_fleet_index(content), "utf-8")
    page, faults = opened(browser, path, scheme, width)
    assert violations(page) == []
    assert faults == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.context.close()


def test_axe_finds_a_fault_that_is_there(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    page_text = report_of("healthy")
    path.write_text(page_text.replace('<html lang="en">', "<html>"), "utf-8")
    page, _ = opened(browser, path, "light", 1200)
    assert any(found.startswith("html-has-lang") for found in violations(page))
    page.context.close()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_no_picture_is_cut_on_paper(browser: Browser, path: Path) -> None:
    page, _ = opened(browser, path, "light", A4[0])
    page.emulate_media(media="print")
    pictures = "[...document.querySelectorAll('figure .card')]"
    heights = page.evaluate(f"{pictures}.map(one => one.getBoundingClientRect().height)")
    # A picture that is lower than a page is moved to the next one as a whole.
    kept = page.evaluate(
        f"{pictures}.every(one => getComputedStyle(one).breakInside === 'avoid' && "
        "one.querySelectorAll('img, svg').length > 0)"
    )
    assert kept
    assert max(heights, default=0.0) < A4[1]
    page.context.close()


def test_the_numbers_of_a_picture_are_saved_as_a_file(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    path.write_text(report_of("unexplained"), "utf-8")
    page, _ = opened(browser, path, "light", 1200)
    with page.expect_download() as waiting:
        page.get_by_role("link", name="t01-loop.csv").click()
    assert waiting.value.suggested_filename == "t01-loop.csv"
    saved = tmp_path / "saved.csv"
    waiting.value.save_as(saved)
    assert saved.read_text("utf-8").startswith("reading,torque [Nm],measured [arcmin],")
    page.context.close()
