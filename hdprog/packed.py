"""A folder as bytes, to travel to another machine and back."""

from __future__ import annotations

import io
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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
