"""Many drives: every drive folder below a folder through the main job, then one list of them all.

Finished drives are kept: a run that was broken off, or that gets a new test, goes on with what has
changed. A drive that cannot be used is left out with its reason, and the others go on.
"""

from __future__ import annotations

import hashlib
import json
import os
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hdprog import __version__
from hdprog.atomic import atomic_directory, atomic_write_text, remove_unfinished
from hdprog.cluster import dask_client
from hdprog.config import Drive
from hdprog.data.drive_folder import read_drive_folder
from hdprog.drive_folders import drive_folders
from hdprog.errors import BadInputError, HdprogError, no_room
from hdprog.outcome import RUN_KEY, results_in
from hdprog.packed import packed, unpack, unpacked
from hdprog.parallel import process_executor
from hdprog.progress import Progress, untold

SCHEMA = "hdprog.fleet/1"
_MISTAKE = "a mistake in hdprog"
_DIED = "its process ended before it was done, perhaps for want of memory; run the fleet again"
_NO_ROOM = "no room for its results"
_OURS = (_MISTAKE, _DIED, _NO_ROOM)


@dataclass(frozen=True)
class Order:
    """What to run of one drive, and under which options.

    Attributes
    ----------
    name : of the drive folder below the fleet's
    folder, out : where it is, and where its results go
    key : digest of the input and the options; the same key gives the same results
    """

    name: str
    folder: Path
    out: Path
    key: str
    seed: int
    quick: bool
    explain: bool

    @property
    def finished(self) -> bool:
        """Whether its results are there already."""
        kept = self.out / RUN_KEY
        if not (self.out / "summary.json").is_file():  # somebody removed it
            return False
        return kept.is_file() and kept.read_text("utf-8").strip() == self.key


@dataclass(frozen=True)
class LeftOut:
    """A drive folder that could not be used, and why."""

    name: str
    reason: str


@dataclass(frozen=True)
class Fleet:
    """What a fleet run hands back.

    Attributes
    ----------
    out : where everything was written
    content : of fleet.json (schema hdprog.fleet/1)
    """

    out: Path
    content: dict[str, Any]

    @property
    def converged(self) -> bool:
        """Whether every fit and trend of every drive converged, the drive model alone, too."""
        drives = self.content["drives"]
        return all(one["converged"] and one["explanation_converged"] for one in drives)

    @property
    def broken(self) -> bool:
        """Whether a drive was left out by the program, a process or a disk, not by its files."""
        return any(one["reason"].startswith(_OURS) for one in self.content["left_out"])

    @property
    def sentence(self) -> str:
        """How many drives need what, in plain words."""
        from hdprog.reporting.fleet_index import headline

        return headline(self.content)


def run_fleet(
    path: str | Path,
    out: str | Path,
    *,
    seed: int = 0,
    quick: bool = False,
    explain: bool = True,
    workers: int | None = None,
    dask: str | None = None,
    command: str = "Python API",
    progress: Progress | None = None,
) -> Fleet:
    """Run every drive folder below a folder and list them, worst first.

    Parameters
    ----------
    path : folder with drive folders below it
    out : gets `drives/NAME/` for each, `fleet.json` and `index.html`
    seed, quick, explain : as in `hdprog.workflow.run`, the same for each drive
    workers : drives that are run at once here; one a core if None
    dask : address of a Dask scheduler that the drives are run on instead
    command : for the provenance
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        where Dask does not answer
    BadInputError
        without a drive folder, or where none can be used
    HdprogError
        where none was run to its end, by a fault of the program or its process
    """
    path, out = Path(path), Path(out)
    orders, left_out = _orders(path, out, seed, quick, explain)
    waiting = [order for order in orders if not order.finished]
    progress = progress or untold
    progress("drives", len(orders) - len(waiting), len(orders))
    with _nothing_half_written(waiting), _runner(dask, len(waiting), workers) as run:
        done = len(orders) - len(waiting)
        for found in run(waiting, command):
            done += 1
            if found is not None:
                left_out.append(found)
            progress("drives", done, len(orders))
    refused = {one.name for one in left_out}
    listed = [order for order in orders if order.name not in refused]
    _require_any(listed, path, left_out)
    content = _content(path, listed, left_out, seed=seed, quick=quick, command=command)
    from hdprog.reporting.fleet_index import build_fleet_index

    out.mkdir(parents=True, exist_ok=True)
    index = build_fleet_index(content)
    atomic_write_text(
        out / "fleet.json",
        json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n",
    )
    atomic_write_text(out / "index.html", index)
    return Fleet(out, content)


def _orders(
    path: Path, out: Path, seed: int, quick: bool, explain: bool
) -> tuple[list[Order], list[LeftOut]]:
    """One order a drive folder; folders that cannot be read are left out."""
    folders = drive_folders(path, out)
    if not folders:
        raise BadInputError(
            f"no folder {path}" if not path.is_dir() else "no drive.toml below it",
            str(path),
            "a folder with drive folders below it",
            "Give the folder that holds the drive folders.",
        )
    orders: list[Order] = []
    left_out: list[LeftOut] = []
    for folder in folders:
        name = folder.relative_to(path).as_posix() if folder != path else folder.resolve().name
        if any(order.name == name for order in orders):
            reason = "another drive folder has this name: rename one of them"
            left_out.append(LeftOut(folder.as_posix(), reason))
            continue
        try:
            key = _key(folder, seed, quick, explain)
        except (HdprogError, OSError) as error:
            left_out.append(LeftOut(name, _words(error)))
            continue
        place = out / "drives" / name
        if place.resolve() == folder.resolve():
            raise BadInputError(
                f"--out {out}, where the results of {name} would lie among its own records",
                folder.as_posix(),
                "a folder of their own for the results",
                "Give another folder with --out DIR.",
            )
        orders.append(Order(name, folder, place, key, seed, quick, explain))
    _require_any(orders, path, left_out)
    return orders, left_out


def _require_any(usable: Sequence[Order], path: Path, left_out: Sequence[LeftOut]) -> None:
    if usable:
        return
    # A sentence begins with a capital, a folder's name as it does.
    reasons = " ".join(f"Left out: {one.name}: {one.reason}" for one in left_out)
    if any(one.reason.startswith(_OURS) for one in left_out):
        raise HdprogError(
            f"{path}: no drive was run to its end, for no fault of its files. {reasons}"
        )
    raise BadInputError(
        "no drive that can be used",
        str(path),
        "at least one drive folder as `hdprog check` passes it",
        reasons,
    )


def _key(folder: Path, seed: int, quick: bool, explain: bool) -> str:
    """Digest of everything that the results of a drive hang on."""
    read = read_drive_folder(folder)
    digest = hashlib.sha256(json.dumps([__version__, seed, quick, explain]).encode())
    for name in ("drive.toml", "tests.csv"):
        digest.update((folder / name).read_bytes())
    for test in read.tests:
        digest.update(test.path.read_bytes())
    for text in _priors(read.drive):
        digest.update(text.encode())
    return digest.hexdigest()


def _priors(drive: Drive) -> tuple[str, str]:
    """The prior of the drive's loops and that of its wear, whatever files they are from."""
    from hdprog.inference.prior_file import prior_file_of, require_prior
    from hdprog.trend.wear_prior import read_wear_prior

    require_prior(drive)
    return prior_file_of(drive).model_dump_json(), read_wear_prior().model_dump_json()


@contextmanager
def _runner(
    dask: str | None, count: int, workers: int | None
) -> Iterator[Callable[[Sequence[Order], str], Iterator[LeftOut | None]]]:
    if dask is not None:
        with dask_client(dask) as client:
            executor = client.get_executor(pure=False)
            yield lambda orders, command: _spread_packed(executor, orders, command)
        return
    # One drive alone has the cores for its tests.
    with process_executor(workers if count > 1 else 1) as here:
        if here is None:
            yield lambda orders, command: (_run_one(order, command, workers) for order in orders)
        else:
            yield lambda orders, command: _spread(here, orders, command)


@contextmanager
def _nothing_half_written(orders: Sequence[Order]) -> Iterator[None]:
    """Clear up after workers that were ended by an interrupt: they had no time to do it."""
    try:
        yield
    except BaseException:
        for order in orders:
            remove_unfinished(order.out)
        raise


def _spread(executor: Executor, orders: Sequence[Order], command: str) -> Iterator[LeftOut | None]:
    tasks = {executor.submit(_run_one, order, command, 1): order for order in orders}
    for task in as_completed(tasks):
        try:
            yield task.result()
        except BrokenExecutor as error:
            yield LeftOut(tasks[task].name, f"{_DIED} ({error})")


def _spread_packed(
    executor: Executor, orders: Sequence[Order], command: str
) -> Iterator[LeftOut | None]:
    """Folders go out packed and results come back packed: the cluster sees none of our files."""
    tasks: dict[Future[Any], Order] = {}
    for order in orders:
        try:
            sent = pack_drive(order.folder)
        except (HdprogError, OSError) as error:
            yield LeftOut(order.name, _words(error))
            continue
        tasks[executor.submit(run_packed, sent, order, command)] = order
    for task in as_completed(tasks):
        order = tasks[task]
        try:
            found = task.result()
        except Exception as error:  # a worker that is lost, in whatever words the cluster has
            yield LeftOut(order.name, f"{_DIED} ({error})")
            continue
        if isinstance(found, LeftOut):
            yield found
            continue
        try:
            with _kept(order), atomic_directory(order.out, results_in(order.out)) as aside:
                unpack(found, aside)
                (aside / RUN_KEY).unlink(missing_ok=True)
        except OSError as error:
            yield LeftOut(order.name, _words(error))
            continue
        yield None


def pack_drive(folder: Path) -> bytes:
    """Pack what a run reads of a drive folder: not what else lies or is linked there.

    Raises
    ------
    BadInputError
        for a prior that a path leads to which only this machine has
    """
    read = read_drive_folder(folder)
    files = [folder / "drive.toml", folder / "tests.csv", *(test.path for test in read.tests)]
    own = Path(read.drive.prior or "")
    # An absolute path may lead to the same file on the cluster.
    if not own.is_absolute() and (folder / own).is_file():
        if os.path.normpath(own).startswith(os.pardir):
            raise BadInputError(
                f"the prior {own}, outside the drive folder",
                str(folder / "drive.toml"),
                "a prior in the folder, which is all that goes to a Dask cluster",
                "Copy it into the folder, or name it by a path that the cluster has, too.",
            )
        files.append(folder / own)
    return packed(folder, files)


def run_packed(folder: bytes, order: Order, command: str) -> bytes | LeftOut:
    """Run a packed drive folder where the cluster wills; gives the results, packed."""
    with unpacked(folder, order.name.rpartition("/")[2]) as (drive, out):
        there = replace(order, folder=drive, out=out)
        # Workers of Dask are daemons, which may have no processes of their own.
        return _run_one(there, command, 1) or packed(out)


def _run_one(order: Order, command: str, workers: int | None) -> LeftOut | None:
    """Run one drive and write its results, or give the reason why not."""
    from hdprog import workflow

    try:
        outcome = workflow.run(
            order.folder,
            seed=order.seed,
            quick=order.quick,
            explain=order.explain,
            workers=workers,
        )
        order.out.parent.mkdir(parents=True, exist_ok=True)
        with _kept(order):
            outcome.write(order.out, command, workers)
    except (HdprogError, OSError) as error:
        return LeftOut(order.name, _words(error))
    except Exception as error:  # whatever it is, the other drives go on
        traceback.print_exc()
        return LeftOut(order.name, f"{_MISTAKE}: {type(error).__name__}: {error}")
    return None


def _words(error: HdprogError | OSError) -> str:
    """Say why a drive is left out; what the machine refuses has a number for its words."""
    if not isinstance(error, OSError) or error.errno is None:
        return str(error)
    words = os.strerror(error.errno)
    if no_room(error):
        return f"{_NO_ROOM} ({words}). Free space or raise the limit, and run the fleet again."
    place = f"{error.filename}: " if error.filename else ""
    return f"{place}{words}. Correct that, and run the fleet again."


@contextmanager
def _kept(order: Order) -> Iterator[None]:
    """Write results for the block; their key goes before them and comes after the last of them.

    Whoever is killed between leaves files of two runs, which must pass for those of neither.
    """
    (order.out / RUN_KEY).unlink(missing_ok=True)
    yield
    atomic_write_text(order.out / RUN_KEY, order.key + "\n")


def _content(
    path: Path,
    orders: Sequence[Order],
    left_out: Sequence[LeftOut],
    *,
    seed: int,
    quick: bool,
    command: str,
) -> dict[str, Any]:
    """Content of fleet.json: the drives worst first, and what was left out."""
    from hdprog.reporting.fleet_index import fleet_drive, shared_ids

    drives = []
    for order in orders:
        summary = json.loads((order.out / "summary.json").read_text("utf-8"))
        explained = order.out / "explain.json"
        settled = not explained.is_file() or json.loads(explained.read_text("utf-8"))["converged"]
        drives.append(
            fleet_drive(order.name, f"drives/{order.name}", summary, explanation_converged=settled)
        )
    drives.sort(key=lambda drive: (drive["rank"], drive["rank_hours"], drive["folder"]))
    return {
        "schema": SCHEMA,
        "hdprog_version": __version__,
        "fleet": path.resolve().name,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command,
        "seed": seed,
        "quick": quick,
        "warnings": shared_ids(drives),
        "drives": drives,
        "left_out": [{"folder": one.name, "reason": one.reason} for one in left_out],
    }
