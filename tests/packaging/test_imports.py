"""Importing hdprog and asking for help load nothing numeric."""

from __future__ import annotations

import subprocess
import sys

import pytest

import hdprog

HEAVY = ["numpy", "scipy", "pandas", "matplotlib", "arviz", "emcee", "pydantic", "jinja2", "rich"]
HEAVY += ["sqlalchemy", "alembic", "fastapi", "uvicorn", "dbos"]


def loaded_after(code: str) -> set[str]:
    """Name the top-level packages that `code` imports in a fresh interpreter."""
    ask = "import sys; print('\\n' + ' '.join({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{ask}"], capture_output=True, text=True, check=True
    )
    return set(done.stdout.splitlines()[-1].split())


def test_import_loads_nothing_heavy() -> None:
    loaded = loaded_after("import hdprog; hdprog.__version__")
    assert loaded.isdisjoint([*HEAVY, "typer"])


@pytest.mark.parametrize(
    "arguments",
    [["--help"], ["fit", "--help"], ["serve", "--help"], ["user", "--help"], ["--version"]],
)
def test_help_loads_nothing_heavy(arguments: list[str]) -> None:
    loaded = loaded_after(
        "from hdprog.cli import app\n"
        f"try: app({arguments!r}, prog_name='hdprog')\n"
        "except SystemExit: pass"
    )
    assert "typer" in loaded
    assert loaded.isdisjoint(set(HEAVY) - {"pydantic"})  # Typer itself reads types with Pydantic


def test_the_check_sees_what_is_loaded() -> None:
    assert {"hdprog", "numpy"} <= loaded_after("import hdprog; hdprog.predict")


@pytest.mark.parametrize("name", hdprog.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert name in dir(hdprog)
    assert getattr(hdprog, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="nosuch"):
        hdprog.nosuch  # noqa: B018
