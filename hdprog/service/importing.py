"""Drive folders into the store, their records read as uploads are."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from hdprog.data.drive_folder import read_drive_folder
from hdprog.errors import BadInputError
from hdprog.service.queue import Queue
from hdprog.service.readout import read_record
from hdprog.store import jobs
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.folder import import_drive
from hdprog.store.store import Store


def take_in_folder(store: Store, queue: Queue, folder: Path) -> tuple[str, int]:
    """Take a drive folder into the store and ask for its analysis.

    Returns
    -------
    name, tests
        The drive's id and the number of its tests.

    Raises
    ------
    BadInputError
        for anything in the folder that cannot be used; nothing was taken in then
    """
    read = read_drive_folder(folder)
    content = tomllib.loads((folder / "drive.toml").read_text("utf-8-sig"))
    # Reading takes its time; the store is held for writing only afterwards.
    looked = {test.path: _look(test.path, content) for test in read.tests}
    with store.writing() as session:
        drive, tests = import_drive(
            session, store.files, COMMAND_LINE, folder, lambda path, _content: looked[path]
        )
        queue.enqueue(session, jobs.add_job(session, COMMAND_LINE, drive, tests[-1]))
        return drive.name, len(tests)


def _look(path: Path, content: dict[str, Any]) -> tuple[dict[str, Any], str]:
    found = read_record(path, path.name, content)
    if found.problems:
        raise BadInputError(
            "a record that cannot be used", str(path), "one that can", " ".join(found.problems)
        )
    return dict(found.quality), found.picture
