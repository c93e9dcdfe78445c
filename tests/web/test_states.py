"""What pages say of a drive whose newest job failed or was called off."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

from hdprog.reporting.summary import summary_json
from hdprog.results import DriveResult
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import find_drive
from hdprog.web.service import Service
from tests.reporting.drives import not_converged, wearing
from tests.store.samples import add_sample, jobs_of
from tests.web.conftest import ClientOf, service_in
from tests.web.server import text_of
from tests.web.test_forecast_dates import analysed


def test_the_fleet_tells_whose_last_job_failed(
    program: ClientOf, person: ClientOf, loop_file: Path
) -> None:
    api, viewer = program("engineer"), person("viewer")
    names = ("waiting-drive", "failed-drive", "known-drive")
    for name in names:
        assert api.post("/api/v1/drives", json={"drive": {"id": name}}).status_code == 201
        sent = {"file": ("a.csv", loop_file.read_bytes())}
        said = {"service_hours": "1"}
        assert api.post(f"/api/v1/drives/{name}/tests", files=sent, data=said).status_code == 202
    with service_in(api).store.writing() as session:
        for name in names[1:]:
            drive = find_drive(session, name)
            assert drive is not None
            [job] = jobs_of(session, drive)
            jobs.fail(session, job, jobs.start(session, job), "test: found nothing of use.")
            if name == "known-drive":
                drive.sentence = "Good until 900 h."

    def row(name: str) -> str:
        page = viewer.get("/", params={"q": name}).text
        return text_of(page[page.index("<ol") : page.index("</ol>")])

    assert "Its tests wait to be analysed." in row("waiting-drive")
    assert "did not end well" not in row("waiting-drive")
    assert "Its last job did not end well. See why" in row("failed-drive")
    assert "wait" not in row("failed-drive")
    assert "Good until 900 h. Its last job did not end well: this is what was" in row("known-drive")
    for name, said in zip(names, ("waits", "not analysed", "not analysed"), strict=True):
        page = text_of(viewer.get(f"/drives/{name}").text)
        assert f"1 h – – – – {said}" in page


def test_a_job_that_was_called_off_is_no_failure(
    program: ClientOf, person: ClientOf, loop_file: Path
) -> None:
    """Its page had said for good that the last job did not end well."""
    api, viewer, record = program("engineer"), person("viewer"), loop_file.read_bytes()
    made = api.post("/api/v1/drives", json={"drive": {"id": "called-off"}})
    assert made.status_code == 201
    for number in range(3):
        answer = api.post(
            "/api/v1/drives/called-off/tests",
            files={"file": ("a.csv", b"#%d\n" % number + record)},
            data={"service_hours": str(number)},
        )
        assert answer.status_code == 202
    store = service_in(api).store
    with store.writing() as session:
        drive = find_drive(session, "called-off")
        assert drive is not None
        newest, second, first = jobs_of(session, drive)
        attempt = jobs.start(session, first)
        assert jobs.cancel(session, COMMAND_LINE, newest)
        assert jobs.finish(session, first, attempt, None)
    in_turn = viewer.get("/drives/called-off").text
    assert "The first analysis waits for its turn." in in_turn
    assert "Waiting for its turn." in text_of(in_turn)
    fleet = text_of(viewer.get("/", params={"q": "called-off"}).text)
    assert "Its tests wait to be analysed." in fleet
    with store.writing() as session:
        again = jobs.find_job(session, second.id)
        assert again is not None
        assert jobs.cancel(session, COMMAND_LINE, again)
    page = viewer.get("/drives/called-off").text
    for seen in (in_turn, page, viewer.get("/", params={"q": "called-off"}).text):
        assert "did not end well" not in seen
    assert f'No analysis is under way. <a href="/jobs/{newest.id}">Its last job</a>' in page
    fleet = text_of(viewer.get("/", params={"q": "called-off"}).text)
    assert "No analysis is under way: its page tells why." in fleet
    assert "wait to be analysed" not in fleet
    with store.writing() as session:
        later = jobs.find_job(session, newest.id)
        assert later is not None
        assert jobs.reopen(session, COMMAND_LINE, later)
        jobs.fail(session, later, jobs.start(session, later), "test: found nothing of use.")
    assert "did not end well" in viewer.get("/drives/called-off").text


def test_what_is_under_way_is_told_before_what_waits(person: ClientOf) -> None:
    """Under an older job a drive with a newer one was said to wait for its turn."""
    viewer = person("viewer")
    store = service_in(viewer).store
    with store.writing() as session:
        drive = add_sample(session, "in-a-row")
        first = jobs.add_job(session, COMMAND_LINE, drive, None)
        attempt = jobs.start(session, first)
        for _ in range(20):
            jobs.add_job(session, COMMAND_LINE, drive, None)
        assert jobs.advance(session, first, attempt, "fits of the tests", 0.4)
    page = text_of(viewer.get("/drives/in-a-row").text)
    assert "Under way: fits of the tests." in page
    assert "for its turn" not in page


def test_a_result_that_was_overtaken_is_said_to_be_of_before(
    program: ClientOf, person: ClientOf
) -> None:
    """Hours of an older test stood beside a newer one's; called off, nothing told them apart."""
    api, viewer = program("viewer"), person("viewer")
    service = service_in(api)
    name = analysed(service, wearing())
    with service.store.writing() as session:
        drive = find_drive(session, name)
        assert drive is not None
        assert drive.analysis_id is not None
        [first] = jobs_of(session, drive)
        assert jobs.finish(session, first, jobs.start(session, first), drive.analysis_id)
        folder = service.store.files.analysis(drive.analysis_id)
        folder.mkdir()
        (folder / "summary.json").write_text("{}", "utf-8")

    def said() -> tuple[bool, ...]:
        fleet = text_of(viewer.get("/", params={"q": name}).text)
        page = text_of(viewer.get(f"/drives/{name}").text)
        lines = api.get("/api/v1/drives", params={"size": 500}).json()["drives"]
        return (
            "found before the newest test or change" in fleet,
            "counted from" in fleet,
            "before the newest test or change, which is not analysed yet." in page,
            "No analysis is under way: the last job" in page,
            api.get(f"/api/v1/drives/{name}").json()["outdated"],
            next(line["outdated"] for line in lines if line["id"] == name),
        )

    assert said() == (False,) * 6
    with service.store.writing() as session:
        later = jobs.add_job(session, COMMAND_LINE, drive, None)
    assert said() == (True, True, True, False, True, True)
    with service.store.writing() as session:
        again = jobs.find_job(session, later.id)
        assert again is not None
        assert jobs.cancel(session, COMMAND_LINE, again)
    assert said() == (True,) * 6
    with service.store.writing() as session:
        again = jobs.find_job(session, later.id)
        assert again is not None
        assert jobs.reopen(session, COMMAND_LINE, again)
        assert jobs.finish(session, again, jobs.start(session, again), drive.analysis_id)
    assert said() == (False,) * 6


def test_a_job_page_that_loads_itself_again_drops_what_was_said(person: ClientOf) -> None:
    """Above "Done" a page that had brought itself up to date said that the job waits."""
    engineer = person("engineer")
    with service_in(engineer).store.writing() as session:
        drive = add_sample(session, "said-once")
        job = jobs.add_job(session, COMMAND_LINE, drive, None)
    page = engineer.get(f"/jobs/{job.id}?said=again").text
    assert "The job waits for its turn again." in page
    [address] = re.findall(r'http-equiv="refresh" content="3; url=([^"]+)"', page)
    with service_in(engineer).store.writing() as session:
        waiting = jobs.find_job(session, job.id)
        assert waiting is not None
        assert jobs.finish(session, waiting, jobs.start(session, waiting), None)
    assert "waits for its turn" not in engineer.get(address).text


def test_a_drives_page_tells_what_the_fleet_counts_as_its_warnings(person: ClientOf) -> None:
    """The fleet said "2 warnings", and one that no test gave stood in the full report alone."""
    viewer = person("viewer")
    service = service_in(viewer)
    result = replace(wearing(), warnings=("The prior is centred on the first record.",))
    name = analysed(service, result)
    keep_summary(service, name, result)
    assert "2 warnings" in text_of(viewer.get("/", params={"q": name}).text)
    assert (
        "<li>The prior is centred on the first record.</li>" in viewer.get(f"/drives/{name}").text
    )


def test_who_is_to_run_again_with_another_seed_is_told_how(person: ClientOf) -> None:
    """No page takes a seed."""
    viewer = person("viewer")
    service, result = service_in(viewer), not_converged()
    name = analysed(service, result)
    keep_summary(service, name, result)
    page = text_of(viewer.get(f"/drives/{name}").text)
    assert page.count("run again with another seed") == 1
    assert "hdprog run FOLDER --seed 1" in page


def test_what_did_not_converge_is_said_wherever_its_numbers_are(
    program: ClientOf, person: ClientOf
) -> None:
    """The list, its JSON and the forecast's table had the numbers, and a finished job was green."""
    api, viewer = program("viewer"), person("viewer")
    service = service_in(viewer)
    for result, doubtful in ((not_converged(), True), (wearing(), False)):
        name = analysed(service, result)
        with service.store.writing() as session:
            drive = find_drive(session, name)
            assert drive is not None
            [job] = jobs_of(session, drive)
            assert jobs.finish(session, job, jobs.start(session, job), drive.analysis_id)
            sentence, number = drive.sentence, job.id
        row = text_of(viewer.get("/", params={"q": name}).text)
        assert ("Not converged: this is provisional." in row) == doubtful
        lines = api.get("/api/v1/drives", params={"size": 500}).json()["drives"]
        [told] = [line["sentence"] for line in lines if line["id"] == name]
        assert told == (f"{sentence} Not converged: this is provisional." if doubtful else sentence)
        page = text_of(viewer.get(f"/drives/{name}").text)
        assert ("Forecast not converged: provisional numbers" in page) == doubtful
        if doubtful:  # before the first of "the numbers below"
            assert page.index("Not converged: the fit") < page.index(text_of(sentence))
        assert page.count(text_of(sentence)) == 1
        page = viewer.get(f"/jobs/{number}").text
        assert ("Not converged: the numbers of this analysis" in text_of(page)) == doubtful
        assert ('class="verdict good"' in page) != doubtful


def keep_summary(service: Service, name: str, result: DriveResult) -> None:
    with service.store.reading() as session:
        drive = find_drive(session, name)
        assert drive is not None
        assert drive.analysis_id is not None
        folder = service.store.files.analysis(drive.analysis_id)
    folder.mkdir()
    (folder / "summary.json").write_text(json.dumps(summary_json(result)), "utf-8")
