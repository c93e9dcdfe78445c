"""What a killed process left is removed, what counts is not."""

from __future__ import annotations

import os
import uuid
from pathlib import Path

from hdprog.store.store import Store
from hdprog.store.tables import AnalysisRow
from hdprog.store.tidy import tidy_up
from tests.store.samples import add_sample


def aged(path: Path, *, folder: bool = False) -> Path:
    if folder:
        path.mkdir()
    else:
        path.touch()
    os.utime(path, (0, 0))
    return path


def test_only_what_is_old_and_unknown_goes(store: Store) -> None:
    files, number = store.files, str(uuid.uuid4())
    with store.writing() as session:
        drive = add_sample(session)
        session.add(
            AnalysisRow(
                id=number,
                drive_id=drive.id,
                hdprog_version="0",
                quick=False,
                converged=True,
                status="good",
                verdict="",
            )
        )
    gone = [
        aged(files.incoming / "x.part"),
        aged(files.incoming / "tmpdir", folder=True),
        aged(files.analysis(str(uuid.uuid4())), folder=True),
    ]
    stays = [aged(files.analysis(number), folder=True), files.incoming / "young.part"]
    stays[1].touch()
    replaced = files.analysis(number) / "posteriors"
    replaced.mkdir()
    assert tidy_up(store) == len(gone)
    assert not any(path.exists() for path in [*gone, replaced])
    assert all(path.exists() for path in stays)
