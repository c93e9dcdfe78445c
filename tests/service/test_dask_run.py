"""A drive handed to a Dask cluster comes back as if it had been run here."""

from __future__ import annotations

import errno
from concurrent.futures import CancelledError, Future
from pathlib import Path
from types import SimpleNamespace

import pytest
from distributed import KilledWorker

from hdprog.errors import BadInputError, HdprogError, UsageError
from hdprog.service import dask_run
from hdprog.service.drive_run import Order, Say


def stand_in(order: Order, say: Say) -> None:
    """Say what was in the folder, in the place of a fit."""
    if (order.folder / "wrong").exists():
        raise BadInputError("a wrong file", "folder", "none", "Remove it.")
    order.out.mkdir()
    found = sorted(path.relative_to(order.folder).as_posix() for path in order.folder.rglob("*"))
    (order.out / "summary.json").write_text(" ".join(found))
    (order.out / "tests").mkdir()
    (order.out / "tests" / "t01.html").write_text("report")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "drive"
    (made / "loops").mkdir(parents=True)
    (made / "drive.toml").write_text("[drive]")
    (made / "loops" / "t01.csv").write_text("1,2")
    return made


def test_out_and_back(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr(dask_run, "run_here", stand_in)
    said: list[str] = []
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        order = Order(folder, tmp_path / "out", True, 1, "tests")
        dask_run.run_on_dask(cluster.scheduler_address, order, lambda stage, _: said.append(stage))
        assert (order.out / "summary.json").read_text() == "drive.toml loops loops/t01.csv"
        assert (order.out / "tests" / "t01.html").read_text() == "report"
        assert said[0] == "handed to the Dask cluster"
        (folder / "wrong").touch()
        wrong = Order(folder, tmp_path / "none", True, 1, "tests")
        with pytest.raises(BadInputError, match="a wrong file"):
            dask_run.run_on_dask(cluster.scheduler_address, wrong, lambda _stage, _done: None)
        assert not wrong.out.exists()


def test_a_time_out_of_the_work_itself_ends_the_job(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file over a network that timed out passed for a wait that goes on: without end."""
    from distributed import LocalCluster

    def timed_out(_order: Order, _say: Say) -> None:
        raise OSError(errno.ETIMEDOUT, "of a network folder")

    looks = 0

    def say(_stage: str, _done: float) -> None:
        nonlocal looks
        looks += 1
        assert looks < 100, "the job was waited for, though it had ended"

    monkeypatch.setattr(dask_run, "run_here", timed_out)
    monkeypatch.setattr(dask_run, "_LOOK_SECONDS", 0.2)
    order = Order(folder, tmp_path / "out", True, 1, "tests")
    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        pytest.raises(TimeoutError, match="of a network folder"),
    ):
        dask_run.run_on_dask(cluster.scheduler_address, order, say)


@pytest.mark.parametrize(
    "error", [CancelledError("f-1"), KilledWorker("f-1", SimpleNamespace(address="tcp://a:1"), 3)]
)
def test_a_job_that_the_cluster_loses_is_no_mistake_of_the_program(error: Exception) -> None:
    """It was told as one, to be reported, where a worker had run out of memory."""
    task: Future[bytes] = Future()
    task.set_exception(error)
    with pytest.raises(HdprogError, match=r"^The Dask cluster lost this job \(.*f-1") as told:
        dask_run._results(task)
    assert "Start the job again" in str(told.value)


def test_a_scheduler_that_does_not_answer(folder: Path, tmp_path: Path) -> None:
    order = Order(folder, tmp_path / "out", True, 1, "tests")
    with pytest.raises(UsageError, match="found no scheduler"):
        dask_run.run_on_dask("nonsense://x", order, lambda _stage, _done: None)
