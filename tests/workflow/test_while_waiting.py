"""What this process does while its workers work."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import pytest

from hdprog.parallel import process_executor, while_waiting


def test_it_begins_with_the_first_work_when_all_workers_are_there() -> None:
    began = threading.Event()
    workers: list[int] = []
    with process_executor(2) as executor:
        assert executor is not None

        def look() -> None:
            workers.append(len(executor._processes))
            began.set()

        with while_waiting(executor, look):
            assert not began.is_set()
            assert executor.submit(os.getpid).result() != os.getpid()
            executor.submit(os.getpid)
        assert began.is_set()
    if sys.platform == "linux":
        assert workers == [2]


def test_it_is_over_when_the_block_is() -> None:
    done: list[int] = []
    with process_executor(2) as executor, while_waiting(executor, lambda: done.append(1)):
        assert executor is not None
        executor.submit(os.getpid)
    assert done == [1]


def test_an_interrupt_does_not_wait_for_it() -> None:
    goes_on, over = threading.Event(), threading.Event()

    def last() -> None:
        goes_on.wait(timeout=10)
        over.set()

    def interrupted() -> None:
        with process_executor(2) as executor, while_waiting(executor, last):
            assert executor is not None
            executor.submit(os.getpid).result()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not over.is_set()
    goes_on.set()


def test_without_work_or_without_workers_it_does_not_begin() -> None:
    done: list[int] = []
    for workers in (1, 2):
        with process_executor(workers) as executor, while_waiting(executor, lambda: done.append(1)):
            pass
    assert not done


def test_before_a_fit_nothing_is_imported_that_only_writing_needs() -> None:
    heavy = ["arviz", "matplotlib.pyplot", "scipy.signal", "scipy.stats", "h5netcdf"]
    code = f"import sys, hdprog.workflow; print([m for m in {heavy} if m in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"
