"""A copy of everything, taken while the service runs, in one archive."""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import tarfile
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from sqlalchemy import make_url

from hdprog.atomic import atomic_directory
from hdprog.errors import BadInputError, UsageError, no_room
from hdprog.store.database import sqlite_file
from hdprog.store.identity import MARK
from hdprog.store.store import Store

DUMP = "database.pgdump"
_SQLITE = "hdprog.db"
_KEPT = (MARK, "raw", "analyses")


def back_up(store: Store, archive: Path) -> int:
    """Write the database and all files into a new archive (.tar.gz), whole or not at all.

    Its owner alone may read it.

    The database is copied first: every file that it names is in place by then, and files are
    never changed. Draws go where a newer analysis has its own; an archive made meanwhile may lack
    those of the older one.

    Returns
    -------
    int
        Bytes of the archive.

    Raises
    ------
    UsageError
        where something of that name is there, or PostgreSQL's pg_dump is not
    BadInputError
        where there is no room for it
    """
    if archive.exists():
        raise UsageError(
            f"ARCHIVE: found a file at {archive}, expected a name that is free, so that no earlier "
            "backup is lost. Give another name, such as one with the date."
        )
    with _room_for(f"the copy of {store.files.root}", str(archive), "another ARCHIVE"):
        return _write(store, archive)


def _write(store: Store, archive: Path) -> int:
    archive.parent.mkdir(parents=True, exist_ok=True)
    aside = archive.with_name(f".{archive.name}.part")
    with tempfile.TemporaryDirectory(dir=store.files.incoming) as folder:
        copy = _copy_database(store, Path(folder))
        try:
            aside.unlink(missing_ok=True)  # left by a backup that was killed
            # For its owner alone, as the data folder is: it holds the hashes of passwords.
            handle = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with (
                open(handle, "wb") as file,
                tarfile.open(fileobj=file, mode="w:gz", compresslevel=1) as tar,
            ):
                tar.add(copy, copy.name)
                for name in _KEPT:
                    _add(tar, store.files.root / name, name)
            aside.replace(archive)
        finally:
            aside.unlink(missing_ok=True)
    return archive.stat().st_size


def restore(archive: Path, data: Path, url: str | None) -> None:
    """Put a backup into an empty data folder, and into an empty database where it was PostgreSQL.

    Whole or not at all: where it fails, the same command, put right, finds the folder as it was.

    Raises
    ------
    UsageError
        where the data folder holds something, or the database is not of the backup's kind
    BadInputError
        for an archive that is no backup, or where there is no room for what it holds
    """
    if data.exists() and any(data.iterdir()):
        raise UsageError(
            f"--data: found files in {data}, expected an empty folder, so that nothing is lost. "
            "Give another folder."
        )
    with atomic_directory(data) as aside:
        aside.chmod(0o700)
        _extract(archive, aside, data)
        _require_right_database(archive, aside, data, url)
        dump = aside / DUMP
        if url is not None and dump.exists():
            # All or nothing there too: what is half put back would not be an empty database.
            options = ("--no-owner", "--exit-on-error", "--single-transaction")
            _run("pg_restore", url, *options, str(dump), target="--dbname")
            dump.unlink()


@contextmanager
def _room_for(what: str, where: str, otherwise: str) -> Iterator[None]:
    """Say in words that a disk or a quota is full."""
    try:
        yield
    except (OSError, sqlite3.OperationalError) as error:
        words = no_room(error)
        if words is None:
            raise
        raise BadInputError(
            f"no room for {what} ({words})",
            where,
            "room for all records and results of the backup",
            f"Free space or raise the limit, or give {otherwise}.",
        ) from error


def _extract(archive: Path, folder: Path, data: Path) -> None:
    try:
        with (
            _room_for(f"what {archive} holds", str(data), "another folder with --data"),
            tarfile.open(archive, "r:gz") as tar,
        ):
            tar.extractall(folder, filter="data")
    except (tarfile.TarError, OSError, EOFError, zlib.error) as error:
        raise _no_backup(archive, f"no readable archive ({error})") from error


def _require_right_database(archive: Path, folder: Path, data: Path, url: str | None) -> None:
    """Refuse an archive without a database, and an address of the other kind of database."""
    file = None if url is None else sqlite_file(url)
    if (folder / DUMP).exists():
        if url is None or file is not None:
            found = "none" if url is None else "one of SQLite"
            raise UsageError(
                f"--database: found {found} for a backup of PostgreSQL ({archive}), expected the "
                "address of an empty database. Add --database postgresql://…"
            )
    elif not (folder / _SQLITE).exists():
        raise _no_backup(archive, "an archive without a database")
    elif url is not None and file != data.absolute() / _SQLITE:
        raise UsageError(
            f"--database: found an address for a backup that holds its database ({archive}), "
            "expected none. Leave --database and HDPROG_DATABASE out."
        )


def _no_backup(archive: Path, found: str) -> BadInputError:
    return BadInputError(
        found, str(archive), "a backup that `hdprog store backup` made", "Give another file."
    )


def _copy_database(store: Store, folder: Path) -> Path:
    file = sqlite_file(store.database.url)
    if file is None:
        copy = folder / DUMP
        _run("pg_dump", store.database.url, "--format=custom", f"--file={copy}", target="--dbname")
        return copy
    copy = folder / _SQLITE
    with closing(sqlite3.connect(file)) as source, closing(sqlite3.connect(copy)) as target:
        source.backup(target)
    return copy


def _run(program: str, url: str, *options: str, target: str) -> None:
    """Run one of PostgreSQL's own programs; the password goes by the environment."""
    if shutil.which(program) is None:
        raise UsageError(
            f"{program}: found none on this machine, expected PostgreSQL's own program for "
            "backups. Install the package postgresql-client."
        )
    parsed = make_url(url).set(drivername="postgresql")
    environment = dict(os.environ)
    if parsed.password is not None:
        environment["PGPASSWORD"] = str(parsed.password)
    plain = parsed.set(password=None).render_as_string()
    done = subprocess.run(
        [program, f"{target}={plain}", *options],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise UsageError(f"{program}: found that it failed: {done.stderr.strip()}")


def _add(tar: tarfile.TarFile, path: Path, name: str) -> None:
    """Add a file or a folder, without what is being written and what goes while it is read."""
    if path.name.endswith(".part"):
        return
    try:
        tar.add(path, name, recursive=False)
        inside = sorted(path.iterdir()) if path.is_dir() else []
    except FileNotFoundError:
        return
    for child in inside:
        _add(tar, child, f"{name}/{child.name}")
