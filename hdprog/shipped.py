"""The folders that travel with the program: priors and datasets."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal

from hdprog.errors import HdprogError


def shipped(kind: Literal["priors", "datasets"]) -> Traversable:
    """Find a folder that the project ships; the working directory plays no part.

    In an installed wheel the folder lies inside the package, in a checkout (and in an editable
    install of one) beside it, where people edit it.

    Parameters
    ----------
    kind : {"priors", "datasets"}
        Which folder.

    Returns
    -------
    Traversable
        The folder; `importlib.resources.as_file` gives a path to anything in it.

    Raises
    ------
    HdprogError
        When the installation lacks the folder.
    """
    installed = files("hdprog") / "_shipped" / kind
    if installed.is_dir():
        return installed
    checkout = Path(__file__).resolve().parent.parent
    if (checkout / "pyproject.toml").is_file() and (checkout / kind).is_dir():
        return checkout / kind
    raise HdprogError(
        f"This installation of hdprog has no folder {kind}/: looked for {installed} and "
        f"{checkout / kind}, expected one of the two. Install hdprog again from its wheel or its "
        "checkout."
    )
