"""A drive's fits on a Dask cluster: the folder goes out packed, the results come back packed.

Workers of the cluster need hdprog installed, and neither the store nor its folder.
"""

from __future__ import annotations

from typing import Any

from hdprog.atomic import atomic_directory
from hdprog.cluster import dask_client, lost
from hdprog.errors import HdprogError
from hdprog.packed import packed, unpack, unpacked
from hdprog.service.drive_run import Order, Say, run_here

_LOOK_SECONDS = 1.0


def run_on_dask(address: str, order: Order, say: Say) -> None:
    """Have a cluster run what `run_here` runs.

    Raises
    ------
    UsageError
        where Dask is not installed or its scheduler does not answer
    HdprogError
        for a drive folder that cannot be used, or a job that the cluster loses
    """
    with dask_client(address) as client:
        say("handed to the Dask cluster", 0.02)
        task = client.submit(
            run_packed, packed(order.folder), order.quick, order.command, pure=False
        )
        try:
            while True:
                try:
                    # It gives an error of the work: one that is raised here is of the wait.
                    task.exception(timeout=_LOOK_SECONDS)
                    break
                except TimeoutError:
                    say("on the Dask cluster", 0.5)
            results = _results(task)
        except BaseException:
            task.cancel()
            raise
    with atomic_directory(order.out) as aside:
        unpack(results, aside)


def _results(task: Any) -> bytes:
    """What came back; where nothing did, the cluster is at fault and not the program."""
    try:
        results: bytes = task.result()
    except lost() as error:
        raise HdprogError(
            f"The Dask cluster lost this job ({error}): a worker that ended, perhaps for want of "
            "memory, or the scheduler. The cluster's logs say more. Start the job again; the "
            "upload itself is safe."
        ) from error
    return results


def run_packed(folder: bytes, quick: bool, command: str) -> bytes:
    """Run a packed drive folder where the cluster wills; gives the results, packed."""
    with unpacked(folder, "drive") as (drive, out):
        # Workers of Dask are daemons, which may have no processes of their own.
        run_here(Order(drive, out, quick, 1, command), lambda _stage, _done: None)
        return packed(out)
