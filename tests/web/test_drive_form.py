"""The form of a drive: what it has no fields for is not lost, and numbers stay as they were."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import pytest

from hdprog.errors import BadInputError
from hdprog.store.drives import content_of, find_drive
from hdprog.web.drive_form import content_of_form, fields_of
from hdprog.web.facts import read_facts
from tests.web.conftest import ClientOf, service_in
from tests.web.server import csrf_of

CONTENT = {
    "drive": {"id": "cell3-axis2", "model": "CSF-25-80", "rated_torque_Nm": 63.0},
    "limits": [{"quantity": "lost_motion_arcmin", "above": 2.0}],
    "forecast": {"horizon_hours": 20000.0},
    "columns": {"torque": "M"},
    "select": {"cycle": [2]},
    "report": {"torque_unit": "in·lbf"},
}
FULL: dict[str, Any] = {
    "drive": {
        "id": "full",
        "rated_torque_Nm": 63.0,
        "reference_torque_Nm": 30.123456789,
        "ratio": 80,
    },
    "limits": [
        {"quantity": "secant_stiffness_Nm_per_rad", "at_torque_Nm": float(at), "below": 12345.678}
        for at in range(10, 19)
    ],
    "forecast": {},
    "noise": {"angle_resolution_rad": 9.7738438e-06},
    "columns": {"torque": "T:Nm", "angle": "A:mrad", "time": ""},
    "select": {"cycle": [2]},
}


class SettingsForm(HTMLParser):
    """What a browser would send of the settings' form."""

    def __init__(self) -> None:
        super().__init__()
        self.fields: dict[str, str] = {}
        self._inside, self._select = False, ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if tag == "form":
            self._inside = given.get("action", "").endswith("/settings")
        elif not self._inside:
            return
        elif tag == "input":
            self.fields[given["name"]] = given["value"]
        elif tag == "select":
            self._select = given["name"]
        elif tag == "option" and ("selected" in given or self._select not in self.fields):
            self.fields[self._select] = given["value"]


@pytest.mark.parametrize("content", [CONTENT, FULL])
def test_a_form_sent_back_as_it_came_changes_nothing(content: dict[str, Any]) -> None:
    assert content_of_form(fields_of(content), content) == content


def test_the_page_sent_back_as_it_came_changes_nothing(program: ClientOf, person: ClientOf) -> None:
    assert program("engineer").post("/api/v1/drives", json=FULL).status_code == 201
    client = person("engineer")
    form = SettingsForm()
    form.feed(client.get("/drives/full/settings").text)
    assert form.fields["rated_torque_Nm"] == "63"
    assert form.fields["reference_torque_Nm"] == "30.123456789"
    sent = client.post("/drives/full/settings", data=form.fields, follow_redirects=False)
    assert sent.status_code == 303
    with service_in(client).store.reading() as session:
        drive = find_drive(session, "full")
        assert drive is not None
        assert content_of(drive) == FULL


def test_what_is_emptied_in_the_form_goes() -> None:
    fields = fields_of(CONTENT) | {"columns_torque": "", "forecast_horizon_hours": ""}
    content = content_of_form(fields, CONTENT)
    assert "columns" not in content
    assert "forecast" not in content
    assert content["report"] == CONTENT["report"]


def test_what_a_form_does_not_send_stays() -> None:
    sent = {name: text for name, text in fields_of(FULL).items() if not name.startswith("limit8")}
    del sent["reference_torque_Nm"]
    assert content_of_form(sent, FULL) == FULL
    emptied = content_of_form(sent | {"limit0_quantity": ""}, FULL)
    assert emptied["limits"] == FULL["limits"][1:]


@pytest.mark.parametrize("text", ["12,500", "12,000", "1,234,567", "100,000"])
def test_commas_between_thousands_are_asked_about(text: str) -> None:
    plain = text.replace(",", "")
    with pytest.raises(BadInputError, match=rf"such as {plain} or {plain}\.0"):
        content_of_form(fields_of(CONTENT) | {"forecast_horizon_hours": text})
    with pytest.raises(BadInputError, match=rf"such as {plain} or {plain}\.0"):
        read_facts({"service_hours": text})


@pytest.mark.parametrize(("text", "meant"), [("2.000", "2.0000"), ("12.500", "12.5000")])
def test_points_between_thousands_are_asked_about(text: str, meant: str) -> None:
    plain = text.replace(".", "")
    with pytest.raises(BadInputError) as caught:
        read_facts({"service_hours": text})
    assert "whose point may stand between thousands" in str(caught.value)
    assert f"such as {plain} or {plain}.0. Leave the point out, or write {meant} if" in str(
        caught.value
    )
    assert read_facts({"service_hours": meant}).service_hours == float(meant)


@pytest.mark.parametrize(("text", "value"), [("63,5", 63.5), ("0,125", 0.125), ("12,5000", 12.5)])
def test_a_comma_before_decimals_is_read(text: str, value: float) -> None:
    said = content_of_form(fields_of(CONTENT) | {"rated_torque_Nm": text})
    assert said["drive"]["rated_torque_Nm"] == value
    assert read_facts({"service_hours": text}).service_hours == value


@pytest.mark.parametrize(("size", "ratio"), [("²", "80"), ("25", "80²"), ("25", "x")])
def test_what_is_no_size_of_the_catalogue_is_said_so(
    person: ClientOf, size: str, ratio: str
) -> None:
    """A raised 2 ended as a mistake of the program."""
    asked = {"series": "CSF", "size": size, "ratio": ratio}
    page = person("engineer").get("/drives/new", params=asked)
    assert page.status_code == 422
    assert "Pick series, size and ratio" in page.text


@pytest.mark.parametrize("name", ["Achse 3 ä\u2013ö", "a\u0308xis\u2014\u8a66+1"])
def test_a_drive_is_found_under_any_name_that_it_may_have(
    program: ClientOf, person: ClientOf, loop_file: Path, name: str
) -> None:
    """A dash that a run takes was refused here."""
    api, browser = program("engineer"), person("engineer")
    at = f"/drives/{quote(name, safe='')}"
    csrf = csrf_of(browser.get("/drives/new").text)
    form = {"csrf": csrf, "id": name, "series": "CSF", "size": "25", "ratio": "80"}
    made = browser.post("/drives/new", data=form, follow_redirects=False)
    assert made.status_code == 303
    page = browser.get(made.headers["location"])
    assert page.status_code == 200
    assert name in page.text
    sent = browser.post(f"{at}/uploads", data={"csrf": csrf}, files={"files": loop_file.open("rb")})
    assert sent.status_code == 200
    assert unquote(sent.url.raw_path.decode()) == f"/drives/{name}/uploads"
    again = browser.post(f"{at}/uploads", data={"csrf": csrf})
    assert unquote(again.url.raw_path.decode()) == f"/drives/{name}?said=empty"
    assert f'href="{at}"' in browser.get("/").text
    assert api.get(f"/api/v1{at}").status_code == 200
    other = api.post("/api/v1/drives", json={"drive": {"id": f"{name}2"}}).json()
    assert other["url"] == f"{at}2"
    assert browser.get(other["url"]).status_code == 200
