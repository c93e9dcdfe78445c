"""A folder as bytes, to travel to another machine and back."""

from __future__ import annotations

import io
import tarfile
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
