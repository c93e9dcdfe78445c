"""Which state of the code a result comes from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from importlib.resources.abc import Traversable
from pathlib import Path

import hdprog
from hdprog.shipped import shipped


def sources(*packages: str, without: Iterable[str] = ()) -> list[Path]:
    """Files of some of hdprog's packages, in order, those left out whose name is given."""
    root, left_out = Path(hdprog.__file__).parent, set(without)
    files = [file for name in packages for file in sorted((root / name).rglob("*.py"))]
    return [file for file in files if file.name not in left_out]


def prior_file(name: str) -> Traversable:
    """A shipped prior's file."""
    return shipped("priors") / f"{name}.toml"


def digest(files: Iterable[Path | Traversable]) -> str:
    """Ten digits that change with the content of any of the files, or with their order."""
    whole = hashlib.sha256()
    for file in files:
        whole.update(file.read_bytes())
    return whole.hexdigest()[:10]
