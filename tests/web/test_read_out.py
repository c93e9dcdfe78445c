"""What was read out of a record belongs to the settings of its drive."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from hdprog.store.audit import COMMAND_LINE, trail
from hdprog.store.drives import change_drive, find_drive
from hdprog.store.tables import AuditRow
from hdprog.store.uploads import find_test
from tests.web.conftest import ClientOf, service_in
from tests.web.server import csrf_of, text_of

MRAD, RAD = "A:mrad", "A:rad"


def declared(name: str, angle: str) -> dict[str, Any]:
    return {"drive": {"id": name}, "columns": {"torque": "T:Nm", "angle": angle}}


@pytest.fixture(name="record")
def record_fixture(loop_file: Path) -> bytes:
    """Give a record whose header does not say the angle's unit."""
    head, _, rows = loop_file.read_text().partition("\n")
    return f"{head.replace('torque_Nm', 'T').replace('angle_rad', 'A')}\n{rows}".encode()


@pytest.fixture(name="api")
def api_fixture(program: ClientOf) -> TestClient:
    return program("engineer")


def make(api: TestClient, name: str, angle: str) -> None:
    assert api.post("/api/v1/drives", json=declared(name, angle)).status_code == 201


def upload(api: TestClient, name: str, data: bytes, hours: str = "1") -> dict[str, Any]:
    answer = api.post(
        f"/api/v1/drives/{name}/tests",
        files={"file": ("a.csv", io.BytesIO(data))},
        data={"service_hours": hours},
    )
    assert answer.status_code == 202
    found: dict[str, Any] = answer.json()
    return found


def renamed(api: TestClient, name: str, angle: str) -> None:
    """Have what is declared change behind the pages' back."""
    with service_in(api).store.writing() as session:
        drive = find_drive(session, name)
        assert drive is not None
        change_drive(session, COMMAND_LINE, drive, declared(name, angle))


def stiffness(api: TestClient, uid: str) -> float:
    with service_in(api).store.reading() as session:
        test = find_test(session, uid)
        assert test is not None
        found: float = test.quality["secant_stiffness"]
        return found


@pytest.mark.parametrize("accepted", [True, False])
def test_a_further_upload_renews_what_was_read(
    api: TestClient, person: ClientOf, record: bytes, accepted: bool
) -> None:
    name = f"renewed-{accepted}"
    make(api, name, MRAD)
    client = person("engineer")
    form = csrf_of(client.get("/drives/new").text)

    def send() -> str:
        if accepted:
            return str(upload(api, name, record)["test_uid"])
        sent = {"files": ("a.csv", record)}
        page = client.post(f"/drives/{name}/uploads", data={"csrf": form}, files=sent).text
        return page.split('<h2 id="')[1].split('"')[0]

    uid = send()
    soft, picture = stiffness(api, uid), client.get(f"/tests/{uid}/picture.svg").text
    renamed(api, name, RAD)
    assert send() == uid
    assert stiffness(api, uid) == pytest.approx(soft / 1000, rel=1e-6)
    assert client.get(f"/tests/{uid}/picture.svg").text != picture
    if not accepted:
        client.post(f"/drives/{name}/uploads/accept", data={"csrf": form, "discard": uid})
        renamed(api, name, MRAD)
        assert send() == uid
        assert stiffness(api, uid) == pytest.approx(soft, rel=1e-6)


def test_a_known_test_is_compared_with_those_before_it(api: TestClient, loop_file: Path) -> None:
    made = api.post("/api/v1/drives", json={"drive": {"id": "order"}})
    assert made.status_code == 201
    first = loop_file.read_bytes()
    head, *rows = loop_file.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    softer = [[time, torque, str(1.5 * float(angle))] for time, torque, angle in cells]
    second = "\n".join([head, *(",".join(row) for row in softer)]).encode()
    assert upload(api, "order", first, "1")["warnings"] == []
    for _ in range(2):
        [words] = upload(api, "order", second, "2")["warnings"]
        assert "-33 %" in words
    assert upload(api, "order", first, "1")["warnings"] == []


def test_a_record_is_held_against_no_test_that_was_removed(
    api: TestClient, person: ClientOf, loop_file: Path
) -> None:
    """Once the one with the wrong unit was gone, the right one was still asked about its units."""
    assert api.post("/api/v1/drives", json={"drive": {"id": "taken-out"}}).status_code == 201
    right = loop_file.read_bytes()
    wrong = upload(api, "taken-out", right.replace(b"angle_rad", b"angle_mrad"))["test_uid"]
    uid = upload(api, "taken-out", right, "2")["test_uid"]
    client = person("engineer")
    assert "Are the units of torque and angle right?" in client.get(f"/tests/{uid}").text
    form = csrf_of(client.get("/drives/new").text)
    client.post(f"/tests/{wrong}", data={"csrf": form, "remove": "yes"})
    assert "Is this the right drive?" not in client.get(f"/tests/{uid}").text


def test_what_a_person_answered_is_not_asked_again(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "answered", RAD)
    upload(api, "answered", record)
    head, *rows = record.decode().splitlines()
    softer = [",".join([*row.split(",")[:2], str(1.5 * float(row.split(",")[2]))]) for row in rows]
    second = "\n".join([head, *softer]).encode()
    client = person("engineer")
    uid = waits(client, "answered", second)
    assert "Is this the right drive?" in client.get(f"/tests/{uid}").text
    assert accepting(client, "answered", uid).status_code == 422
    assert accepting(client, "answered", uid, **{f"{uid}-sure": "on"}).status_code == 303
    for _ in range(2):
        words = text_of(client.get(f"/tests/{uid}").text)
        assert "Is this the right drive?" not in words
        assert "33 % from that of test" in words
        assert "That it is the right drive was said by engineer on 20" in words
        assert upload(api, "answered", second, "123.5")["warnings"] == []
    [line] = (one for one in trail_of(api) if one.details.get("right_drive"))
    assert (line.action, line.actor) == ("test accepted", "engineer")
    assert api.put("/api/v1/drives/answered", json=declared("answered", MRAD)).status_code == 200
    assert "was said by engineer" in client.get(f"/tests/{uid}").text


def trail_of(api: TestClient) -> Sequence[AuditRow]:
    with service_in(api).store.reading() as session:
        return trail(session)


def test_another_drive_does_not_change_the_picture(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "first-drive", MRAD)
    make(api, "second-drive", RAD)
    first = f"/tests/{upload(api, 'first-drive', record)['test_uid']}/picture.svg"
    viewer = person("viewer")
    before = viewer.get(first)
    assert before.status_code == 200
    second = f"/tests/{upload(api, 'second-drive', record)['test_uid']}/picture.svg"
    assert viewer.get(first).text == before.text
    assert viewer.get(second).text != before.text


def test_a_picture_of_an_earlier_version_is_shown(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "old-picture", RAD)
    uid = upload(api, "old-picture", record)["test_uid"]
    with service_in(api).store.reading() as session:
        test = find_test(session, uid)
        assert test is not None
        files, digest, drive = service_in(api).store.files, test.sha256, test.drive_id
    files.picture(digest, drive).rename(files.record(digest).with_suffix(".svg"))
    assert person("viewer").get(f"/tests/{uid}/picture.svg").status_code == 200
    assert "picture.svg" in person("viewer").get(f"/tests/{uid}").text


def test_records_are_read_anew_when_their_columns_are_named_otherwise(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "put-right", MRAD)
    uid = upload(api, "put-right", record)["test_uid"]
    soft = stiffness(api, uid)
    viewer = person("viewer")
    picture = viewer.get(f"/tests/{uid}/picture.svg").text
    answer = api.put("/api/v1/drives/put-right", json=declared("put-right", RAD))
    assert answer.status_code == 200
    assert stiffness(api, uid) == pytest.approx(soft / 1000, rel=1e-6)
    assert viewer.get(f"/tests/{uid}/picture.svg").text != picture
    assert "earlier settings" not in viewer.get(f"/tests/{uid}").text
    another = record[: record.rstrip().rindex(b"\n") + 1]  # a reading less
    assert upload(api, "put-right", another, "2")["warnings"] == []

    client = person("engineer")
    form = csrf_of(client.get("/drives/put-right/settings").text)
    sent = {"csrf": form, "columns_angle": MRAD}
    assert client.post("/drives/put-right/settings", data=sent).status_code == 200
    assert stiffness(api, uid) == pytest.approx(soft, rel=1e-6)


def test_what_cannot_be_read_anew_is_said_to_be_old_and_compared_with_nothing(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "other-head", MRAD)
    uid = upload(api, "other-head", record)["test_uid"]
    client = person("engineer")
    form = csrf_of(client.get("/drives/new").text)
    waiting = {"files": ("b.csv", b"# waits\n" + record)}
    client.post("/drives/other-head/uploads", data={"csrf": form}, files=waiting)
    soft = stiffness(api, uid)
    said = declared("other-head", RAD) | {"columns": {"torque": "X:Nm", "angle": "Y:rad"}}
    assert api.put("/api/v1/drives/other-head", json=said).status_code == 200
    assert stiffness(api, uid) == soft
    for page in (f"/tests/{uid}", "/drives/other-head/uploads"):
        words = client.get(page).text
        assert "read with earlier settings" in words
        assert "With the settings of now it cannot be read." in words
    head, _, rows = record.partition(b"\n")
    renamed_record = head.replace(b"T", b"X").replace(b"A", b"Y") + b"\n" + rows
    assert upload(api, "other-head", renamed_record, "2")["warnings"] == []


def test_a_renewal_that_other_settings_overtook_changes_nothing(
    api: TestClient, record: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    make(api, "overtaken", MRAD)
    uid = upload(api, "overtaken", record)["test_uid"]
    soft = stiffness(api, uid)
    service = service_in(api)
    read = service.readers.read

    def slowly(path: Path, name: str, content: Any) -> Any:
        found = read(path, name, content)
        renamed(api, "overtaken", MRAD)
        return found

    renamed(api, "overtaken", RAD)
    monkeypatch.setattr(service.readers, "read", slowly)
    service.read_anew("overtaken")
    assert stiffness(api, uid) == soft


def waits(client: TestClient, name: str, record: bytes, called: str = "a.csv") -> str:
    """Upload a record that waits to be looked at."""
    form = csrf_of(client.get("/drives/new").text)
    sent = {"files": (called, record)}
    page = client.post(f"/drives/{name}/uploads", data={"csrf": form}, files=sent).text
    return page.split('<h2 id="')[-1].split('"')[0]


def accepting(client: TestClient, name: str, uid: str, **more: str) -> Any:
    form = csrf_of(client.get("/drives/new").text)
    said = {"csrf": form, f"{uid}-service_hours": "123.5", **more}
    return client.post(f"/drives/{name}/uploads/accept", data=said, follow_redirects=False)


def state(api: TestClient, uid: str) -> str:
    with service_in(api).store.reading() as session:
        test = find_test(session, uid)
        assert test is not None
        return test.state


def test_removed_tests_are_read_anew_too(api: TestClient, person: ClientOf, record: bytes) -> None:
    make(api, "removed", MRAD)
    client = person("engineer")
    uid = upload(api, "removed", record)["test_uid"]
    soft = stiffness(api, uid)
    form = csrf_of(client.get("/drives/new").text)
    client.post(f"/tests/{uid}", data={"csrf": form, "remove": "yes"})
    assert state(api, uid) == "removed"
    assert api.put("/api/v1/drives/removed", json=declared("removed", RAD)).status_code == 200
    assert stiffness(api, uid) == pytest.approx(soft / 1000, rel=1e-6)
    assert state(api, uid) == "removed"
    assert "earlier settings" not in client.get(f"/tests/{uid}").text


def test_a_record_that_cannot_be_read_any_more_is_not_accepted(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "unreadable", MRAD)
    client = person("engineer")
    uid = waits(client, "unreadable", record)
    other = declared("unreadable", RAD) | {"columns": {"torque": "X:Nm", "angle": "Y:rad"}}
    assert api.put("/api/v1/drives/unreadable", json=other).status_code == 200
    answer = accepting(client, "unreadable", uid)
    assert answer.status_code == 422
    assert "Not accepted yet" in answer.text
    assert "With the settings of now it cannot be read" in answer.text
    assert "/drives/unreadable/settings" in answer.text
    assert 'value="123.5"' in answer.text
    assert state(api, uid) == "preview"
    back = api.put("/api/v1/drives/unreadable", json=declared("unreadable", MRAD))
    assert back.status_code == 200
    assert accepting(client, "unreadable", uid).status_code == 303
    assert state(api, uid) == "accepted"


def test_records_that_cannot_be_accepted_do_not_hold_back_the_others(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "one-bad", MRAD)
    client = person("engineer")
    bad = waits(client, "one-bad", record)
    other = declared("one-bad", MRAD) | {"columns": {"torque": "X:Nm", "angle": "A:mrad"}}
    assert api.put("/api/v1/drives/one-bad", json=other).status_code == 200
    named = record.replace(b"T", b"X", 1)
    good, bare = (waits(client, "one-bad", named + b"\n" * n, f"{n}.csv") for n in (1, 2))
    form = csrf_of(client.get("/drives/one-bad/uploads").text)
    said = {f"{bad}-service_hours": "1", f"{good}-service_hours": "2", f"{bare}-service_hours": ""}
    said |= {"csrf": form, f"{bare}-note": "dry"}
    answer = client.post("/drives/one-bad/uploads/accept", data=said)
    assert answer.status_code == 422
    assert [state(api, uid) for uid in (bad, good, bare)] == ["preview", "accepted", "preview"]
    words = text_of(answer.text)
    assert "Accepted: 1 record" in words
    assert "Not accepted: a.csv and 2.csv, for what is said below." in words
    assert "With the settings of now it cannot be read" in words
    assert "no service hours" in words
    assert 'value="dry"' in answer.text
    again = client.post("/drives/one-bad/uploads/accept", data=said)
    assert "1.csv: somebody has accepted it meanwhile" in text_of(again.text)


def test_a_record_that_was_not_read_anew_yet_is_shown_before_it_is_accepted(
    api: TestClient, person: ClientOf, record: bytes
) -> None:
    make(api, "not-yet", MRAD)
    client = person("engineer")
    uid = waits(client, "not-yet", record)
    soft = stiffness(api, uid)
    renamed(api, "not-yet", RAD)  # and whoever should have read it anew was killed
    for page in (f"/tests/{uid}", "/drives/not-yet/uploads"):
        shown = client.get(page)
        assert shown.status_code == 200
        assert "load this page again in a moment" in shown.text
    answer = accepting(client, "not-yet", uid)
    assert answer.status_code == 422
    assert "read anew" in answer.text
    assert "no other record is compared with it" not in answer.text
    assert 'value="123.5"' in answer.text
    assert stiffness(api, uid) == pytest.approx(soft / 1000, rel=1e-6)
    assert state(api, uid) == "preview"
    assert accepting(client, "not-yet", uid).status_code == 303


def test_settings_that_change_while_a_record_is_read_are_the_ones_it_is_read_with(
    api: TestClient, record: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    make(api, "meanwhile", MRAD)
    soft = stiffness(api, upload(api, "meanwhile", record)["test_uid"])
    readers = service_in(api).readers
    read = readers.read

    def slowly(path: Path, name: str, content: Any) -> Any:
        found = read(path, name, content)
        renamed(api, "meanwhile", RAD)
        return found

    monkeypatch.setattr(readers, "read", slowly)
    uid = upload(api, "meanwhile", b"# another\n" + record, "2")["test_uid"]
    assert stiffness(api, uid) == pytest.approx(soft / 1000, rel=1e-6)


def test_a_refused_upload_leaves_no_file(api: TestClient, record: bytes) -> None:
    make(api, "no-file", MRAD)
    files = service_in(api).store.files
    sent = {"service_hours": "1", "test_id": "t01"}

    def send(data: bytes) -> int:
        file = {"file": ("a.csv", io.BytesIO(data))}
        return api.post("/api/v1/drives/no-file/tests", files=file, data=sent).status_code

    assert send(b"# first\n" + record) == 202
    before = sorted(files.raw.rglob("*"))
    assert send(b"# the id is taken\n" + record) == 422
    assert sorted(files.raw.rglob("*")) == before
    assert not list(files.incoming.glob("*.part"))
