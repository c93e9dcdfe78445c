"""Drive folders into the store, their records read as uploads are."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from hdprog.data.drive_folder import read_drive_folder
from hdprog.errors import BadInputError
from hdprog.service.queue import Queue
from hdprog.service.readout import read_record
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.folder import import_drive, require_importable
from hdprog.store.store import Store

_Looked = dict[Path, tuple[dict[str, Any], str]]


def take_in_folder(store: Store, queue: Queue, folder: Path) -> tuple[str, int]:
    """Take one drive folder into the store; see `take_in_folders`."""
    return next(take_in_folders(store, queue, [folder]))


def take_in_folders(
    store: Store, queue: Queue, folders: Sequence[Path]
) -> Iterator[tuple[str, int]]:
    """Take drive folders into the store one after the other, and ask for their analyses.

    All are looked at before the first is taken in: where one cannot be used, none is.

    Yields
    ------
    name, tests
        A drive's id and the number of its tests, once it is taken in.

    Raises
    ------
    BadInputError
        for anything in the folders that cannot be used
    """
    with store.reading() as session:
        names = [require_importable(session, folder) for folder in folders]
    for number, name in enumerate(names):
        first = names.index(name)
        if first != number:
            raise BadInputError(
                f"the drive {name} a second time, after {folders[first]}",
                str(folders[number]),
                "folders of different drives",
                "Leave one of the two out, or correct the id in drive.toml.",
            )
    # Reading takes its time; the store is held for writing only afterwards.
    looked = [_look(folder) for folder in folders]
    for folder, found in zip(folders, looked, strict=True):
        yield _take_in(store, queue, folder, found)


def _take_in(store: Store, queue: Queue, folder: Path, looked: _Looked) -> tuple[str, int]:
    with store.writing() as session:
        drive, tests = import_drive(session, store.files, COMMAND_LINE, folder, looked)
        queue.enqueue(session, jobs.add_job(session, COMMAND_LINE, drive, tests[-1]))
        return drive.name, len(tests)


def _look(folder: Path) -> _Looked:
    content = tomllib.loads((folder / "drive.toml").read_text("utf-8-sig"))
    looked = {}
    for test in read_drive_folder(folder).tests:
        found = read_record(test.path, test.path.name, content)
        if found.problems:
            words = " ".join(found.problems)
            raise BadInputError(
                "a record that cannot be used", str(test.path), "one that can", words
            )
        looked[test.path] = dict(found.quality), found.picture
    return looked
