"""A folder as bytes, to travel to another machine and back."""

from __future__ import annotations

import io
import os
import tarfile
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path


def packed(folder: Path, files: Iterable[Path] | None = None) -> bytes:
    """Give a folder as the bytes of an archive.

    Parameters
    ----------
    folder : to be packed
    files : those in it that count, all if None; of links what they lead to, which is not there
        where they are unpacked
    """
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w", dereference=files is not None) as tar:
        for path in sorted(folder.iterdir() if files is None else set(files)):
            tar.add(path, os.path.relpath(path, folder))
    return content.getvalue()


def unpack(content: bytes, folder: Path) -> None:
    """Put an archive's content into a folder."""
    with tarfile.open(fileobj=io.BytesIO(content), mode="r") as tar:
        tar.extractall(folder, filter="data")


@contextmanager
def unpacked(content: bytes, name: str) -> Iterator[tuple[Path, Path]]:
    """Unpack an archive for as long as the block runs.

    Parameters
    ----------
    content : of the archive
    name : of the folder that it goes into

    Yields
    ------
    that folder, and a place apart from it for results, which is not there yet
    """
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "sent" / name
        folder.mkdir(parents=True)
        unpack(content, folder)
        yield folder, Path(place) / "results"
