"""The folder of files beside the database: raw records by their SHA-256, results by their number.

Names are made here, of digests and numbers; nothing that a user typed becomes part of a path.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
from pathlib import Path
from typing import BinaryIO

from platformdirs import user_data_path

_DIGEST = re.compile(r"[0-9a-f]{64}")
_NUMBER = re.compile(r"[0-9a-f-]{36}")
_CHUNK = 1 << 20


def default_data_folder() -> Path:
    """Give the folder for data of this user on this platform, unless HDPROG_DATA names another."""
    named = os.environ.get("HDPROG_DATA")
    return Path(named) if named else user_data_path("hdprog", appauthor=False)


def holds_store(root: Path) -> bool:
    """Tell whether a folder is a store's data folder; nothing is made."""
    return (root / "raw").is_dir()


class Files:
    """The files of a store.

    Parameters
    ----------
    root : the data folder; it is made, for its owner alone, if it is not there
    """

    def __init__(self, root: Path) -> None:
        self.root = root.absolute()
        self.raw, self.analyses = self.root / "raw", self.root / "analyses"
        self.incoming, self.workers = self.root / "incoming", self.root / "workers"
        self.root.mkdir(parents=True, exist_ok=True, mode=0o700)
        for folder in (self.raw, self.analyses, self.incoming, self.workers):
            folder.mkdir(exist_ok=True)

    @property
    def database_url(self) -> str:
        """Address of the embedded database."""
        return f"sqlite:///{self.root / 'hdprog.db'}"

    def record(self, digest: str) -> Path:
        """Path of a raw record."""
        if not _DIGEST.fullmatch(digest):
            raise ValueError(f"no SHA-256: {digest!r}")
        return self.raw / digest[:2] / digest

    def picture(self, digest: str, drive: int) -> Path:
        """Path of the picture of a raw record, as it is read with the settings of a drive."""
        record = self.record(digest)
        return record.with_name(f"{record.name}-{drive:d}.svg")

    def find_picture(self, digest: str, drive: int) -> Path | None:
        """Find the picture of a raw record of a drive; None where there is none."""
        record = self.record(digest)
        # Earlier versions kept one picture of a record for all drives.
        for path in (self.picture(digest, drive), record.with_name(f"{record.name}.svg")):
            if path.is_file():
                return path
        return None

    def analysis(self, number: str) -> Path:
        """Folder of an analysis."""
        if not _NUMBER.fullmatch(number):
            raise ValueError(f"no number of an analysis: {number!r}")
        return self.analyses / number

    def receive(self, stream: BinaryIO) -> tuple[Path, str, int]:
        """Copy an upload aside.

        Returns
        -------
        path, digest, size
            A file among the incoming ones, to be kept or thrown away; its SHA-256; its bytes.
        """
        path = self.incoming / f"{secrets.token_hex(8)}.part"
        seen, size = hashlib.sha256(), 0
        with path.open("xb") as file:
            while chunk := stream.read(_CHUNK):
                seen.update(chunk)
                size += len(chunk)
                file.write(chunk)
            file.flush()
            os.fsync(file.fileno())
        return path, seen.hexdigest(), size

    def keep(self, incoming: Path, digest: str) -> None:
        """Put an incoming file among the raw records, where it stays as it came."""
        target = self.record(digest)
        target.parent.mkdir(exist_ok=True)
        if target.exists():
            incoming.unlink()
            return
        incoming.chmod(0o440)
        incoming.replace(target)
        _sync_folder(target.parent)

    def drop_posteriors(self, number: str) -> None:
        """Remove the draws of an analysis that a newer one has replaced."""
        shutil.rmtree(self.analysis(number) / "posteriors", ignore_errors=True)


def _sync_folder(folder: Path) -> None:
    """Make a rename in a folder outlive a power cut, where the platform can."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def free_bytes(folder: Path) -> int:
    """Bytes that are free on the disk of a folder."""
    return shutil.disk_usage(folder).free
