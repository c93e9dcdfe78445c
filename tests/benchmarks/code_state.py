"""Which state of the code a result comes from."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.resources.abc import Traversable
from pathlib import Path

import grimp

from hdprog.shipped import shipped

_ROOT = Path(__file__).parents[2]


@cache
def _imports() -> grimp.ImportGraph:
    # The cache of grimp would be a folder beside whatever folder the benchmark is run in.
    return grimp.build_graph("hdprog", "tests", cache_dir=None)


def imported_by(*modules: str, but: Iterable[str] = ()) -> list[Path]:
    """Files of these modules and of all they import, directly or not, in order of their names.

    An import within a function counts. What ``but`` names is left out with what it alone imports,
    and so is the package's own first file, which names every public function.
    """
    ends_at, found, waiting = {"hdprog", __name__, *but}, set[str](), list(modules)
    while waiting:
        module = waiting.pop()
        if module not in found and module not in ends_at:
            found.add(module)
            waiting += _imports().find_modules_directly_imported_by(module)
    return [_file_of(module) for module in sorted(found)]


def _file_of(module: str) -> Path:
    place = _ROOT.joinpath(*module.split("."))
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def prior_file(name: str) -> Traversable:
    """A shipped prior's file."""
    return shipped("priors") / f"{name}.toml"


def digest(files: Iterable[Path | Traversable]) -> str:
    """Ten digits that change with the content of any of the files, or with their order."""
    whole = hashlib.sha256()
    for file in files:
        whole.update(file.read_bytes())
    return whole.hexdigest()[:10]
