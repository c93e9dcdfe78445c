"""Executors: serial, or one process a core, with BLAS held to one thread in each."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

_single_thread: object = None
Result = TypeVar("Result")


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def hold_blas_to_one_thread() -> None:
    """Keep linear algebra on one thread: matrices are small and the processes fill the cores."""
    from threadpoolctl import threadpool_limits

    global _single_thread
    _single_thread = threadpool_limits(limits=1)


@contextmanager
def process_executor(workers: int | None = None) -> Iterator[Executor | None]:
    """Executor over worker processes, or None where one worker is all there is.

    Parameters
    ----------
    workers : number of processes; all cores if None
    """
    count = cores() if workers is None else workers
    if count <= 1:
        yield None
        return
    # Forked workers start at once; elsewhere each imports the numerics anew.
    method = "fork" if sys.platform == "linux" else "spawn"
    executor = ProcessPoolExecutor(
        count, mp_context=multiprocessing.get_context(method), initializer=_prepare_worker
    )
    try:
        yield executor
    except BaseException:
        # Interrupted or failed: what the workers still do is of no use to anybody.
        for process in list((executor._processes or {}).values()):
            process.terminate()
        raise
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


def spread_over(executor: Executor | None) -> Callable[..., Iterable[Any]]:
    """`map` over worker processes, or here where there is no executor."""
    return map if executor is None else executor.map


def begin(
    executor: Executor | None, function: Callable[..., Result], *arguments: Any
) -> Future[Result]:
    """Begin a call in a worker, or do it here and now where there is no executor."""
    if executor is not None:
        return executor.submit(function, *arguments)
    done: Future[Result] = Future()
    done.set_result(function(*arguments))
    return done


def _prepare_worker() -> None:
    """Leave an interrupt from the keyboard to the parent, which ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    hold_blas_to_one_thread()
