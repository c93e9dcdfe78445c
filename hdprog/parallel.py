"""Executors: serial, or one process a core, with numerics prepared for that in each."""

from __future__ import annotations

import ctypes
import importlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

_single_thread: object = None
_MIB = 2**20
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # of glibc's malloc.h
_UNUSED_BY_SAMPLER = ("scipy.stats", "h5py")
Result = TypeVar("Result")


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def prepare_numerics() -> None:
    """Hold linear algebra to one thread and let freed memory be used again.

    Matrices are small and the processes fill the cores. Arrays of a fit are some hundred kB each,
    made and freed thousands of times a second; given back to the system every time, as glibc does
    of its own accord, they cost more in pages that are mapped anew than the arithmetic in them.
    """
    from threadpoolctl import threadpool_limits

    global _single_thread
    _single_thread = threadpool_limits(limits=1)
    if not sys.platform.startswith("linux"):
        return
    with suppress(OSError, AttributeError):  # other C libraries have no such setting
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_MMAP_THRESHOLD, 16 * _MIB)
        mallopt(_TRIM_THRESHOLD, 64 * _MIB)


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
    executor = _Workers(count, method)
    try:
        yield executor
    except BaseException:
        # Interrupted or failed: what the workers still do is of no use to anybody.
        for process in list((executor._processes or {}).values()):
            process.terminate()
        raise
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


@contextmanager
def while_waiting(executor: Executor | None, function: Callable[[], None]) -> Iterator[None]:
    """Have a thread of this process do something once its workers have work, if it has some."""
    if not isinstance(executor, _Workers):
        yield
        return
    executor.meanwhile.append(threading.Thread(target=function, daemon=True))
    yield
    # Not in a finally: who interrupts does not wait for what no longer serves anybody.
    for thread in executor.begun:
        thread.join()


class _Workers(ProcessPoolExecutor):
    """Worker processes; threads of this one begin with their work.

    Not before: a worker that is forked while a thread imports would wait for ever for the import
    to end. With the first call all of them are there.
    """

    def __init__(self, count: int, method: str) -> None:
        super().__init__(count, multiprocessing.get_context(method), _prepare_worker)
        self.meanwhile: list[threading.Thread] = []
        self.begun: list[threading.Thread] = []

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        future = super().submit(fn, *args, **kwargs)
        while self.meanwhile:
            self.begun.append(self.meanwhile.pop())
            self.begun[-1].start()
        return future


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
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    prepare_numerics()
    _import_sampler()


def _import_sampler() -> None:
    """Import emcee without what it needs for a move and a store that hdprog does not use.

    These take nearly all of its time. Nothing else runs yet in this process, and no code but
    hdprog's will, so nobody misses them; whatever else wants the same libraries gets them later.
    """
    withheld = [name for name in _UNUSED_BY_SAMPLER if name not in sys.modules]
    for name in withheld:
        sys.modules[name] = None  # type: ignore[assignment]  # its import fails, as emcee allows
    try:
        importlib.import_module("emcee")
    finally:
        for name in withheld:
            del sys.modules[name]


def _end_with_parent() -> None:
    """End this worker once its parent has gone, which may have been killed: nobody else would."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
