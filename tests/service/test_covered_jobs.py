"""One analysis does for all that was asked for before it looked its drive up."""

from __future__ import annotations

from hdprog.service.analyse import Analysis
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.store import Store
from hdprog.store.tables import JobRow
from hdprog.store.uploads import TestFacts
from tests.store.samples import add_bytes, add_sample


def test_corrections_in_a_row_make_one_analysis(sqlite_store: Store) -> None:
    """Each of them had made one of its own, all of the same."""
    store = sqlite_store
    with store.writing() as session:
        drive = add_sample(session)
        add_bytes(session, store.files, drive, b"a", TestFacts(1.0))
        under_way, *corrections = [
            jobs.add_job(session, COMMAND_LINE, drive, None) for _ in range(4)
        ]
        attempt = jobs.start(session, under_way)
        assert jobs.cancel(session, COMMAND_LINE, corrections.pop())
    asked = Analysis(store, under_way.id, attempt)._asked()
    assert asked is not None
    waited = asked[-1]
    with store.writing() as session:
        later = jobs.add_job(session, COMMAND_LINE, drive, None)
        assert jobs.finish_covered(session, "the analysis", waited) == 2
    with store.reading() as session:
        states = {job.id: job.state for job in session.query(JobRow)}
    assert [states[one.id] for one in corrections] == ["done", "done"]
    assert states[later.id] == "queued"
