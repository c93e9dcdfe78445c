"""What the commands of the upload service share: their options, and the extra that they need."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, ParamSpec, TypeVar

import typer

from hdprog.cli.common import nearest_folder
from hdprog.errors import UsageError
from hdprog.extras import install_words

_P = ParamSpec("_P")
_R = TypeVar("_R")
_PACKAGES = {
    "alembic",
    "argon2",
    "dbos",
    "fastapi",
    "filelock",
    "multipart",
    "platformdirs",
    "psycopg",
    "python_multipart",
    "sqlalchemy",
    "starlette",
    "tomli_w",
    "uvicorn",
}

Data = Annotated[
    Path | None,
    typer.Option(
        "--data",
        envvar="HDPROG_DATA",
        help="Folder of records, results and the database (default: the platform's place for "
        "data of a user).",
    ),
]
DatabaseUrl = Annotated[
    str | None,
    typer.Option(
        "--database",
        envvar="HDPROG_DATABASE",
        help="postgresql://USER:PASSWORD@HOST/NAME instead of the SQLite file in --data.",
    ),
]
DaskAddress = Annotated[
    str | None,
    typer.Option(
        "--dask",
        metavar="ADDRESS",
        help="Fit on the cluster of this Dask scheduler, tcp://HOST:8786.",
    ),
]
Role = Annotated[
    str, typer.Option("--role", help="viewer looks, engineer uploads, admin manages accounts.")
]


def needs_web(command: Callable[_P, _R]) -> Callable[_P, _R]:
    """Say what to install where a command lacks the packages of the extra `web`."""

    @wraps(command)
    def guarded(*arguments: _P.args, **options: _P.kwargs) -> _R:
        try:
            return command(*arguments, **options)
        except ModuleNotFoundError as error:
            if error.name is None or error.name.partition(".")[0] not in _PACKAGES:
                raise
            raise UsageError(
                f"found no package {error.name}; expected the packages of the upload service. "
                f"Install them: {install_words('web')}"
            ) from error

    return guarded


def data_folder(given: Path | None) -> Path:
    """Settle where the data are."""
    from hdprog.store.files import default_data_folder

    folder = default_data_folder() if given is None else given
    nearest_folder(folder, "--data", "Give another with --data DIR, or in HDPROG_DATA.")
    return folder


def store_folder(given: Path | None) -> Path:
    """Settle where the data are of a store that is there; a slip in its name begins no new one."""
    from hdprog.store.files import holds_store

    folder = data_folder(given)
    if not holds_store(folder):
        raise UsageError(
            f"--data: found no store in {folder}, expected the data folder of the service. Give it "
            "with --data DIR, or in HDPROG_DATA."
        )
    return folder
