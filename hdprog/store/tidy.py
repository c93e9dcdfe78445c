"""What a process that was killed has left half done, removed when the service starts."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from sqlalchemy import select

from hdprog.store.store import Store
from hdprog.store.tables import AnalysisRow, DriveRow

_OLD_SECONDS = 86_400.0  # younger ones may belong to somebody who is at work


def tidy_up(store: Store) -> int:
    """Remove what is a day old of uploads that broke off and of analyses that were not recorded.

    Returns
    -------
    int
        Number of files and folders that were removed.
    """
    with store.reading() as session:
        known = set(session.scalars(select(AnalysisRow.id)))
        newest = set(session.scalars(select(DriveRow.analysis_id)))
    for number in known - newest:  # a worker that was killed may not have got to it
        store.files.drop_posteriors(number)
    left = list(store.files.incoming.iterdir())
    left += [path for path in store.files.analyses.iterdir() if path.name not in known]
    return sum(_removed(path) for path in left if _is_old(path))


def _is_old(path: Path) -> bool:
    try:
        return time.time() - path.stat().st_mtime > _OLD_SECONDS
    except FileNotFoundError:
        return False


def _removed(path: Path) -> bool:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
    return not path.exists()
