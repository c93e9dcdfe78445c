"""A job whose results find no room on the disk."""

from __future__ import annotations

import errno

import pytest

from hdprog.service import analyse
from hdprog.service.drive_run import Order
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.store import Store
from hdprog.store.tables import JobRow
from hdprog.store.uploads import TestFacts
from tests.store.samples import add_bytes, add_sample


def test_a_full_disk_is_told_and_leaves_no_half_of_an_analysis(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The job told a mistake of the program, and what was written took room from the next one."""
    with store.writing() as session:
        drive = add_sample(session, "full")
        add_bytes(session, store.files, drive, b"record", TestFacts(0.0), name="a.csv")
        job = jobs.add_job(session, COMMAND_LINE, drive, None)
        number, attempt = job.id, jobs.start(session, job)

    def write_till_full(order: Order, _say: object) -> None:
        order.out.mkdir(parents=True)
        (order.out / "summary.json").write_text("{}", "utf-8")
        raise OSError(errno.ENOSPC, "No space left on device")

    order = {
        "data": str(store.files.root),
        "url": store.database.url,
        "job": number,
        "attempt": attempt,
        "processes": 1,
        "dask": None,
    }
    monkeypatch.setattr(analyse, "take_order", lambda: order)
    monkeypatch.setattr(analyse, "run_here", write_till_full)
    assert analyse.main() == 0
    with store.reading() as session:
        kept = session.get_one(JobRow, number)
        assert kept.state == "failed"
        assert kept.error is not None
        assert kept.error.startswith("No space left on device: found no room")
        assert "mistake" not in kept.error
    assert list((store.files.root / "analyses").rglob("summary.json")) == []
