"""Files that are there whole or not at all: written aside, then renamed into place."""

from __future__ import annotations

import glob
import os
import re
import secrets
import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from hdprog.errors import no_room

_ENDING = len("01234567.part")
_YOUNG = 60.0  # s: one that was made just now may not be held yet


def _aside(folder: Path, name: str) -> Path:
    # Cut: beside a name near the longest that a file system takes, a longer one cannot be made.
    return folder / f".{name[:40]}.{secrets.token_hex(4)}.part"


def is_aside(name: str) -> bool:
    """Tell whether a name is that of something unfinished, written aside by what was killed."""
    return re.fullmatch(r"\..*\.[0-9a-f]{8}\.part", name) is not None


def can_write_into(folder: Path) -> bool:
    """Tell whether a folder can be made in a folder, by making one that goes again.

    Permissions do not say it: /proc and file systems that are mounted to be read have them, too.

    Raises
    ------
    OSError
        for a full disk, which has its own words
    """
    aside = _aside(folder, "hdprog")
    try:
        aside.mkdir()
    except OSError as error:
        if no_room(error):
            raise
        return False
    aside.rmdir()
    return True


def atomic_write_bytes(path: Path, content: bytes) -> None:
    """Write a file so that a reader sees the old content or the new, never a part of it.

    Parameters
    ----------
    path : Path
        The file; its folder is made if it is not there.
    content : bytes
        All that the file shall hold.

    Raises
    ------
    OSError
        When the folder cannot be written; nothing is left behind.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = _aside(path.parent, path.name)
    _sweep(aside)
    held = None
    try:
        with aside.open("xb") as stream:
            held = _hold(aside)
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)
        if held is not None:
            os.close(held)


def atomic_write_text(path: Path, content: str) -> None:
    """Write text as UTF-8 with line feeds, as `atomic_write_bytes` does."""
    atomic_write_bytes(path, content.encode("utf-8"))


def _hold(aside: Path) -> int | None:
    """Lock a file or folder that is written aside, by an open file; None where another one does.

    The lock goes with the process, however that ends.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    try:
        opened = os.open(aside, os.O_RDONLY)
    except OSError:
        return None
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # held, or on a file system without locks
        os.close(opened)
        return None
    return opened


def remove_unfinished(path: Path) -> None:
    """Remove what processes that were ended just now had begun to write aside for a folder."""
    for aside in (_aside(path.parent, path.name), _aside(path, "hdprog")):
        _sweep(aside, older=0.0)


def _sweep(aside: Path, older: float = _YOUNG) -> None:
    """Remove what killed processes left beside, written for the same place as `aside`."""
    for left in aside.parent.glob(f"{glob.escape(aside.name[:-_ENDING])}*.part"):
        try:
            if is_aside(left.name) and time.time() - left.stat().st_mtime > older:
                held = _hold(left)
                if held is not None:
                    _remove(left)
                    os.close(held)
        except OSError:  # it went meanwhile
            continue


def _remove(left: Path) -> None:
    if left.is_dir():
        shutil.rmtree(left, ignore_errors=True)
    else:
        with suppress(OSError):
            left.unlink()


@contextmanager
def atomic_directory(path: Path, renewed: Sequence[str] = ()) -> Iterator[Path]:
    """Fill a folder aside and move it into place when the block ends without an error.

    A folder that is not there yet appears in one step. Into a folder that is, the files move one
    by one, each whole; other files in it stay as they are.

    Parameters
    ----------
    path : Path
        The folder to end up in.
    renewed : sequence of str
        Patterns of files that the block makes anew: those of before that it does not make go.

    Yields
    ------
    Path
        An empty folder on the same file system to write into.

    Raises
    ------
    NotADirectoryError
        When `path` is a file.
    OSError
        When the place cannot be written; nothing is left behind.
    """
    if path.exists() and not path.is_dir():
        raise NotADirectoryError(20, "a file lies where the folder should be", str(path))
    if path.is_dir():  # inside, since `path` may be where another file system is mounted
        aside = _aside(path, "hdprog")
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = _aside(path.parent, path.name)
    _sweep(aside)
    aside.mkdir()
    held = _hold(aside)
    try:
        yield aside
        if not path.exists():
            aside.replace(path)
            return
        made = {source.relative_to(aside) for source in aside.rglob("*")}
        before = [file for pattern in renewed for file in path.glob(pattern)]
        for source in sorted(aside.rglob("*")):
            target = path / source.relative_to(aside)
            if source.is_dir():
                target.mkdir(exist_ok=True)
            else:
                source.replace(target)
        for file in before:
            if file.relative_to(path) not in made:
                file.unlink(missing_ok=True)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
        if held is not None:
            os.close(held)
