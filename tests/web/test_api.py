"""The JSON API, as the contract has it."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

import pytest
from starlette.testclient import TestClient

from hdprog.data.check import check_path
from hdprog.store import workers
from hdprog.web.api.models import DriveFile
from tests.web.conftest import ClientOf, service_in

DRIVE = {
    "drive": {"id": "api-1", "model": "CSF-25-80", "rated_torque_Nm": 63.0},
    "limits": [{"quantity": "lost_motion_arcmin", "above": 2.0}],
}


@pytest.fixture(scope="module")
def api(program: ClientOf) -> TestClient:
    client = program("engineer")
    assert client.post("/api/v1/drives", json=DRIVE).status_code == 201
    return client


def upload(api: TestClient, path: Path, name: str = "loop.csv", **fields: str) -> object:
    with path.open("rb") as file:
        return api.post(
            "/api/v1/drives/api-1/tests",
            files={"file": (name, file)},
            data={"service_hours": "12.5", **fields},
        )


def test_health_needs_no_token(app_client: TestClient) -> None:
    answer = app_client.get("/healthz")
    assert answer.status_code == 200
    assert answer.json()["status"] == "ok"
    assert answer.json()["workers"] == 0


@pytest.mark.parametrize("path", ["/healthz", "/login", "/", "/nowhere", "/static/report.css"])
def test_head_is_get_without_the_body(app_client: TestClient, path: str) -> None:
    """It was refused with 405."""
    got = app_client.get(path, follow_redirects=False)
    answer = app_client.head(path, follow_redirects=False)
    assert (answer.status_code, answer.content) == (got.status_code, b"")
    for name in ("content-length", "content-type", "location"):
        assert answer.headers.get(name) == got.headers.get(name)


def test_a_drive_is_made_once(api: TestClient) -> None:
    again = api.post("/api/v1/drives", json=DRIVE)
    assert again.status_code == 409
    assert "already" in again.json()["detail"]


@pytest.mark.parametrize("name", ["Привод-1", "Achse 2+"])
def test_the_address_of_a_drive_is_quoted(api: TestClient, name: str) -> None:
    made = api.post("/api/v1/drives", json={"drive": {"id": name}})
    assert made.status_code == 201
    assert made.json() == {"id": name, "url": f"/drives/{quote(name, safe='')}"}
    assert made.headers["location"] == f"/api/v1/drives/{quote(name, safe='')}"
    assert api.get(made.headers["location"]).json()["drive"]["id"] == name
    again = api.put(made.headers["location"], json={"drive": {"id": name}})
    assert again.json() == made.json()


def test_what_is_null_is_not_declared() -> None:
    """TOML has no null: one that is kept could be neither shown in the settings nor exported."""
    given = {"drive": {"id": "x", "model": None}, "forecast": {"next_shutdown_hours": None}}
    limit = {"quantity": "preload_Nm", "below": 30.0, "at_torque_Nm": None}
    assert DriveFile.model_validate({**given, "limits": [limit]}).declared == {
        "drive": {"id": "x"},
        "forecast": {},
        "limits": [{"quantity": "preload_Nm", "below": 30.0}],
    }


def test_a_drive_that_cannot_be_is_refused_in_words(api: TestClient) -> None:
    wrong = {"drive": {"id": "x"}, "limits": [{"quantity": "lost_motion", "above": 2.0}]}
    answer = api.post("/api/v1/drives", json=wrong)
    assert answer.status_code == 422
    assert "Did you mean lost_motion_arcmin?" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("body", "header", "said"),
    [
        ('{"drive": ', True, "character 11: found text that is not valid JSON (Expecting value)"),
        ("{}", True, "body drive: found nothing; expected it to be given. Add it."),
        (
            '{"drive": {"id": "x"}}',
            False,
            "Send one, with the header Content-Type: application/json.",
        ),
    ],
    ids=["cut short", "empty", "no header"],
)
def test_a_body_that_is_no_drive_is_told_what_it_lacks(
    api: TestClient, body: str, header: bool, said: str
) -> None:
    headers = {"Content-Type": "application/json"} if header else {}
    answer = api.post("/api/v1/drives", content=body, headers=headers)
    assert answer.status_code == 422
    assert said in answer.json()["detail"]


def test_a_test_is_accepted_with_its_job(api: TestClient, loop_file: Path) -> None:
    answer = upload(api, loop_file, event="regreased", note="=cmd|x", test_id="t01")
    assert answer.status_code == 202
    made = answer.json()
    assert made["test_id"] == "t01"
    job = api.get(f"/api/v1/jobs/{made['job_id']}").json()
    assert job["state"] == "queued"
    assert job["progress"] == 0.0
    assert job["error"] is None
    again = upload(api, loop_file)
    assert again.status_code == 202
    assert again.json()["job_id"] == made["job_id"]
    assert again.json()["test_id"] == "t01"
    assert again.json()["new"] is False


def test_who_has_no_token_is_told_so_first(app_client: TestClient) -> None:
    """A request without a file was answered by words of the file, whoever sent it."""
    answer = app_client.post("/api/v1/drives/api-1/tests", data={"service_hours": "1"})
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"] == "Bearer"


def test_a_summary_before_the_first_analysis(api: TestClient) -> None:
    found = api.get("/api/v1/drives/api-1").json()
    assert found["schema"] == "hdprog.summary/1"
    assert found["drive"]["id"] == "api-1"
    assert found["tests"] == []
    assert found["forecast"] == []


def test_a_record_that_cannot_be_read_is_refused_as_check_does(
    api: TestClient, loop_file: Path, tmp_path: Path
) -> None:
    wrong = tmp_path / "loop.csv"
    wrong.write_text(loop_file.read_text().replace("torque_Nm", "torque", 1))
    answer = upload(api, wrong)
    assert answer.status_code == 422
    said = answer.json()
    assert said["problems"] == list(check_path(wrong).problems)
    assert said["detail"].startswith(said["problems"][0])
    assert '{"columns": {"torque": "HEADER:Nm"}}' in said["detail"]  # no program has --columns


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"service_hours": ""}, "no service hours"),
        ({"service_hours": "-1"}, "service_hours = '-1'"),
        ({"service_hours": "nan"}, "service_hours = 'nan'"),
        ({"service_hours": "1e400"}, "service_hours"),
        ({"event": "greased"}, "the event 'greased'"),
        ({"date": "3/9/2026"}, "date = '3/9/2026'"),
        ({"date": "9999-12-31"}, "a day to come"),
        ({"temperature_C": "-300"}, "temperature_C"),
        ({"temperature_C": "298.15"}, "from -100 to 200"),
        ({"test_id": "../t"}, "test_id"),
    ],
)
def test_facts_that_cannot_be(
    api: TestClient, loop_file: Path, fields: dict[str, str], words: str
) -> None:
    answer = upload(api, loop_file, **fields)
    assert answer.status_code == 422
    assert words in answer.json()["detail"]


def test_another_drives_record_is_doubted(api: TestClient, loop_file: Path, tmp_path: Path) -> None:
    known = tmp_path / "known.csv"
    known.write_text("# another file than that of other tests\n" + loop_file.read_text())
    assert upload(api, known).status_code == 202
    head, *rows = loop_file.read_text().splitlines()
    column = head.split(",").index("angle_rad")
    softer = tmp_path / "softer.csv"
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[column] = str(1.5 * float(row[column]))
    softer.write_text("\n".join([head, *(",".join(row) for row in cells)]))
    answer = upload(api, softer)
    assert answer.status_code == 202
    assert "Is this the right drive?" in answer.json()["warnings"][0]
    assert "-33 %" in answer.json()["warnings"][0]


def test_jobs_are_called_off_and_started_again(api: TestClient) -> None:
    number = api.get("/api/v1/drives").json()
    assert number["found"] >= 1
    job = api.put("/api/v1/drives/api-1", json=DRIVE)
    assert job.status_code == 200


@pytest.mark.parametrize(
    "path",
    [
        "/api/v1/drives",
        "/api/v1/drives/api-1",
        "/api/v1/jobs/" + "0" * 8 + "-0000" * 3 + "-" + "0" * 12,
    ],
)
@pytest.mark.parametrize(
    "header", [{}, {"authorization": "Bearer nonsense"}, {"authorization": "Basic eA=="}]
)
def test_without_a_token_nothing(app_client: TestClient, path: str, header: dict[str, str]) -> None:
    answer = app_client.get(path, headers=header)
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"] == "Bearer"


def test_a_viewers_token_only_reads(program: ClientOf, loop_file: Path, api: TestClient) -> None:
    viewer = program("viewer")
    assert viewer.get("/api/v1/drives").status_code == 200
    assert viewer.post("/api/v1/drives", json=DRIVE).status_code == 403
    assert upload(viewer, loop_file).status_code == 403


def test_what_there_is_not(api: TestClient, loop_file: Path) -> None:
    assert api.get("/api/v1/drives/nosuch").status_code == 404
    with loop_file.open("rb") as file:
        answer = api.post(
            "/api/v1/drives/nosuch/tests", files={"file": file}, data={"service_hours": "1"}
        )
    assert answer.status_code == 404
    assert "no drive 'nosuch'" in answer.json()["detail"]


def test_pages_say_that_no_worker_is_running(
    api: TestClient, app_client: TestClient, person: ClientOf, loop_file: Path
) -> None:
    made = upload(api, loop_file).json()  # type: ignore[attr-defined]
    page = f"/jobs/{made['job_id']}"
    viewer = person("viewer")
    assert "No worker is running" in viewer.get(page).text
    assert "No worker is running" in viewer.get("/").text
    with service_in(app_client).store.writing() as session:
        workers.mark(session, "rig-1")
    assert app_client.get("/healthz").json()["workers"] == 1
    assert "No worker is running" not in viewer.get(page).text
    assert "No worker is running" not in viewer.get("/").text
    with service_in(app_client).store.writing() as session:
        workers.forget(session, "rig-1")


def test_what_is_said_otherwise_of_a_known_record_is_not_let_fall_in_silence(
    api: TestClient, loop_file: Path
) -> None:
    second = loop_file.with_name("t02.csv")
    first = upload(api, second, test_id="known", event="regreased").json()
    assert first["warnings"] == upload(api, second).json()["warnings"]
    again = upload(api, second, service_hours="13", test_id="other", event="regreased").json()
    assert again["test_id"] == first["test_id"]
    [words] = [one for one in again["warnings"] if one not in first["warnings"]]
    assert "test known of the drive already: its service_hours, test_id stayed" in words


def test_a_field_that_is_not_known_is_told(api: TestClient, loop_file: Path) -> None:
    """A misspelt one was passed over in silence, and the test stood there without its event."""
    known = {"event": "regreased", "temperature_C": "20", "test_id": "misspelt"}
    answer = upload(api, loop_file.with_name("t03.csv"), note="", **known, events="replaced")
    warnings = answer.json()["warnings"]  # type: ignore[attr-defined]
    [words] = (one for one in warnings if "no field of that name" in one)
    assert words.startswith("field 'events': ")
    assert "service_hours, event, test_id, date, temperature_C" in words


@pytest.mark.parametrize("files", [2, 0])
def test_a_request_brings_one_record(api: TestClient, loop_file: Path, files: int) -> None:
    record = loop_file.read_bytes()
    sent = [("file", ("a.csv", f"# {n} of {files}\n".encode() + record)) for n in range(files)]
    before = api.get("/api/v1/drives/api-1").json()["waiting"]
    answer = api.post("/api/v1/drives/api-1/tests", files=sent or None, data={"service_hours": "1"})
    assert answer.status_code == 422
    assert "file: found" in answer.json()["detail"]
    assert "None" not in answer.json()["detail"]
    assert api.get("/api/v1/drives/api-1").json()["waiting"] == before


def test_a_record_without_a_name_is_refused_in_words(api: TestClient, loop_file: Path) -> None:
    sent = {"file": ("", loop_file.read_bytes())}
    answer = api.post("/api/v1/drives/api-1/tests", files=sent, data={"service_hours": "1"})
    assert answer.status_code == 422
    assert "torque_Nm" not in answer.json()["detail"]
    assert "a file" in answer.json()["detail"]


def test_names_beyond_all_use_are_refused_in_words(api: TestClient, loop_file: Path) -> None:
    answer = upload(api, loop_file, name="x" * 20_000)
    assert answer.status_code == 400
    assert "names of usual length" in answer.json()["detail"]


@pytest.mark.parametrize("hours", ["1e12", "1_000", "٣", "0x10", "nan"])
def test_service_hours_are_numbers_within_a_range_that_is_said(
    api: TestClient, loop_file: Path, hours: str
) -> None:
    answer = upload(api, loop_file, service_hours=hours)
    assert answer.status_code == 422
    assert "a number from 0 to 10000000" in answer.json()["detail"]


def test_a_number_that_no_line_of_the_trail_has_is_refused(person: ClientOf) -> None:
    assert person("admin").get("/audit?before=99999999999999999999").status_code == 422


@pytest.mark.parametrize("path", ["/api/v1/jobs/nope", "/api/v1/drives/" + "x" * 200])
def test_an_address_that_nothing_can_have_is_not_found(api: TestClient, path: str) -> None:
    answer = api.get(path)
    assert answer.status_code == 404
    assert "found nothing called" in answer.json()["detail"]
