"""The whole story in a browser: log in, make a drive, upload ten tests, see the forecast."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.browser import chromium, needs_chromium, violations
from tests.web.server import PASSWORD, PATIENCE, Server, hdprog, wait_for_jobs

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

LOOPS = Path(__file__).resolve().parents[2] / "datasets" / "wearing-csf-25-80" / "loops"

pytestmark = list(needs_chromium)


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    hdprog("user", "add", "ada", "--data", str(data), given=PASSWORD + "\n")
    started = Server(data, seconds=1.0).start()
    yield started
    started.kill()


@pytest.fixture(scope="module", name="browser")
def browser_fixture() -> Iterator[Browser]:
    with chromium() as opened:
        yield opened


def open_page(
    browser: Browser, server: Server, *, script: bool, width: int, scheme: str | None = None
) -> Page:
    context = browser.new_context(
        base_url=server.address,
        color_scheme=scheme,  # type: ignore[arg-type]
        bypass_csp=scheme is not None,  # where the page is looked at by a script of the test's own
        java_script_enabled=script,
        viewport={"width": width, "height": 850},
        accept_downloads=True,
    )
    context.set_default_timeout(1000 * PATIENCE)
    page = context.new_page()
    page.goto("/")
    page.get_by_label("Name").fill("ada")
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Log in").click()
    page.get_by_role("heading", name="Fleet").wait_for()
    return page


@pytest.mark.parametrize(("script", "width"), [(False, 390), (True, 1200)])
def test_from_login_to_report(
    browser: Browser, server: Server, tmp_path: Path, script: bool, width: int
) -> None:
    page = open_page(browser, server, script=script, width=width)
    refused: list[str] = []
    page.on("console", lambda line: refused.append(line.text) if line.type == "error" else None)
    name = f"cell3-axis{width}"
    page.get_by_role("link", name="New drive").click()
    page.get_by_label("Series").select_option("CSF")
    page.get_by_label("Size").select_option("25")
    page.get_by_label("Ratio").first.select_option("80")
    page.get_by_role("button", name="Fill in prior and limits").click()
    assert page.get_by_label("Model").input_value() == "CSF-25-80"
    assert page.get_by_label("Rated torque in Nm").input_value() == "63"
    page.locator("#id").fill(name)
    page.get_by_role("button", name="Make the drive").click()
    page.get_by_role("heading", name=name).wait_for()

    files = sorted(LOOPS.glob("*.csv"))
    assert len(files) == 10
    page.locator("#files").set_input_files([*files, LOOPS.parents[2] / "README.md"])
    page.get_by_role("button", name="Read and show").click()
    page.get_by_text("README.md cannot be used").wait_for()
    assert page.get_by_text("usable: 900 samples").count() == 10
    assert page.get_by_text("3.0 two-sided cycles").count() == 10
    hours = page.get_by_label("Service hours")
    for number in range(10):
        hours.nth(number).fill(str(100 * number))
    hours.last.press("Enter")  # as the button that accepts all, not as one that discards
    page.get_by_role("heading", name=name).wait_for()
    for _ in range(800):
        page.goto(f"/drives/{name}")
        if page.get_by_role("heading", name="Forecast").count():
            break
        page.wait_for_timeout(500)
    page.get_by_role("heading", name="Forecast").wait_for()
    assert "The stand-in saw 10 tests" in page.inner_text("section.verdict")
    assert page.locator("table a").count() == 10
    with page.expect_download() as download:
        page.get_by_role("link", name="Save it").click()
    saved = tmp_path / download.value.suggested_filename
    download.value.save_as(saved)
    assert saved.name == f"{name}-report.html"
    assert f"Report of {name}" in saved.read_text("utf-8")

    page.goto("/")
    page.get_by_role("link", name=name).click()
    page.locator("table a").first.click()
    page.get_by_role("heading", name="Report of this test").wait_for()
    if width > 600:
        inside = page.frame_locator("iframe.report").get_by_role("heading")
        assert inside.inner_text().startswith("Report of t")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth") if script else True
    # A file that cannot be used is answered 422; nothing else may trouble the browser.
    assert [text for text in refused if "status of 422" not in text] == []


def test_by_keyboard_alone(browser: Browser, server: Server) -> None:
    page = open_page(browser, server, script=True, width=1200)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.goto("/drives/new")
    reached = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.id || document.activeElement.innerText"))
    assert {"series", "size", "ratio", "id", "Make the drive"} <= reached


def test_every_field_has_a_label_and_every_page_a_heading(browser: Browser, server: Server) -> None:
    page = open_page(browser, server, script=True, width=390)
    for path in ("/", "/drives/new", "/settings", "/audit", "/drives/nosuch", "/nosuch"):
        page.goto(path)
        found = json.loads(
            page.evaluate(
                """() => JSON.stringify({
                unlabelled: [...document.querySelectorAll("input,select,textarea")]
                    .filter((field) => field.type !== "hidden")
                    .filter((field) => !field.labels.length).map((field) => field.name),
                headings: document.querySelectorAll("h1").length,
                twice: [...document.querySelectorAll("[id]")].map((one) => one.id)
                    .filter((id, at, all) => all.indexOf(id) !== at),
                wide: document.documentElement.scrollWidth > innerWidth})"""
            )
        )
        assert found == {"unlabelled": [], "headings": 1, "twice": [], "wide": False}, path


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_barrier(browser: Browser, server: Server, scheme: str) -> None:
    name = f"axe-{scheme}"
    with server.api() as api:
        assert api.post("/drives", json={"drive": {"id": name}}).status_code == 201
        with next(LOOPS.glob("*.csv")).open("rb") as file:
            taken = api.post(
                f"/drives/{name}/tests", files={"file": file}, data={"service_hours": "1"}
            ).json()
        wait_for_jobs(api, [taken["job_id"]])
    page = open_page(browser, server, script=True, width=390, scheme=scheme)
    own = (f"/drives/{name}", f"/drives/{name}/settings", f"/drives/{name}/uploads")
    results = (f"/tests/{taken['test_uid']}", f"/jobs/{taken['job_id']}")
    for path in ("/", "/drives/new", "/settings", "/audit", "/nosuch", *own, *results):
        page.goto(path)
        assert violations(page) == [], path


def test_too_much_is_said_before_it_is_sent(
    browser: Browser, server: Server, tmp_path: Path
) -> None:
    with server.api() as api:
        assert api.post("/drives", json={"drive": {"id": "large"}}).status_code == 201
    large = tmp_path / "large.csv"
    large.write_bytes(b"1,2\n" * 20_000_000)
    page = open_page(browser, server, script=True, width=1200)
    page.goto("/drives/large")
    page.locator("#files").set_input_files(large)
    assert "80 MB; the server takes 64 MB" in page.inner_text("[data-hint]")
    page.get_by_role("button", name="Read and show").click()
    assert page.url.endswith("/drives/large")

    page = open_page(browser, server, script=False, width=1200)
    page.goto("/drives/large")
    page.locator("#files").set_input_files(large)
    page.get_by_role("button", name="Read and show").click()
    page.get_by_role("heading", name="Too large").wait_for()


def test_files_dropped_on_the_form_are_chosen(browser: Browser, server: Server) -> None:
    content = {"drive": {"id": "dropped"}}
    with server.api() as api:
        assert api.post("/drives", json=content).status_code == 201
    page = open_page(browser, server, script=True, width=1200)
    page.goto("/drives/dropped")
    page.evaluate(
        """() => {
        const data = new DataTransfer();
        data.items.add(new File(["x"], "dropped.csv"));
        document.querySelector("[data-drop]").dispatchEvent(
            new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
        }"""
    )
    assert page.evaluate("document.querySelector('#files').files[0].name") == "dropped.csv"
    assert "dropped.csv" in page.inner_text("[data-hint]")


def test_what_is_to_be_filled_in_is_not_on_paper(browser: Browser, server: Server) -> None:
    with server.api() as api:
        assert api.post("/drives", json={"drive": {"id": "on-paper"}}).status_code == 201
    page = open_page(browser, server, script=False, width=1200)
    for address, ours in (("/", "#q"), ("/drives/on-paper", "#upload")):
        page.goto(address)
        assert page.is_visible(ours)
        page.emulate_media(media="print")
        assert not page.is_visible(ours)
        page.emulate_media(media="screen")
