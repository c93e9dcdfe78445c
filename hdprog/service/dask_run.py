"""A drive's fits on a Dask cluster: the folder goes out packed, the results come back packed.

Workers of the cluster need hdprog installed, and neither the store nor its folder.
"""

from __future__ import annotations

import io
import tarfile
import tempfile
from pathlib import Path

from hdprog.atomic import atomic_directory
from hdprog.errors import UsageError
from hdprog.service.drive_run import Order, Say, run_here

_LOOK_SECONDS = 1.0


def run_on_dask(address: str, order: Order, say: Say) -> None:
    """Have a cluster run what `run_here` runs.

    Raises
    ------
    UsageError
        where Dask is not installed or its scheduler does not answer
    HdprogError
        for a drive folder that cannot be used
    """
    try:
        from distributed import Client, TimeoutError
    except ModuleNotFoundError as error:
        raise UsageError(
            "--dask: found an address and no Dask, expected the package distributed. Install it: "
            "pip install 'hdprog[dask]'"
        ) from error
    try:
        client = Client(address, timeout="10s", set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise UsageError(
            f"--dask: found no scheduler at {address} ({error}), expected one that takes "
            "connections. Start `dask scheduler` there, or leave --dask out."
        ) from error
    with client:
        say("handed to the Dask cluster", 0.02)
        task = client.submit(
            run_packed, packed(order.folder), order.quick, order.command, pure=False
        )
        try:
            while True:
                try:
                    results = task.result(timeout=_LOOK_SECONDS)
                    break
                except TimeoutError:
                    say("under way on the Dask cluster", 0.5)
                    say("on the Dask cluster", 0.5)
        except BaseException:
            task.cancel()
            raise
    with atomic_directory(order.out) as aside:
        unpack(results, aside)


def run_packed(folder: bytes, quick: bool, command: str) -> bytes:
    """Run a packed drive folder where the cluster wills; gives the results, packed."""
    with tempfile.TemporaryDirectory() as place:
        drive, out = Path(place) / "drive", Path(place) / "out"
        drive.mkdir()
        unpack(folder, drive)
        # Workers of Dask are daemons, which may have no processes of their own.
        run_here(Order(drive, out, quick, 1, command), lambda _stage, _done: None)
        return packed(out)


def packed(folder: Path) -> bytes:
    """Give a folder as the bytes of an archive."""
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as tar:
        for path in sorted(folder.iterdir()):
            tar.add(path, path.name)
    return content.getvalue()


def unpack(content: bytes, folder: Path) -> None:
    """Put an archive's content into a folder."""
    with tarfile.open(fileobj=io.BytesIO(content), mode="r") as tar:
        tar.extractall(folder, filter="data")
