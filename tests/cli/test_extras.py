"""Whoever lacks packages is told the command that adds them to an installation from a checkout."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from hdprog.cluster import dask_client
from hdprog.data.readers import read_loop
from hdprog.errors import BadInputError, UsageError
from hdprog.extras import install_words
from hdprog.reporting.pdf import require_pdf

ROOT = Path(__file__).parents[2]


def test_extras_are_installed_as_the_readme_does() -> None:
    """`pip install 'hdprog[web]'` finds no such package."""
    command = install_words("web").removeprefix(f"in the checkout, {sys.executable}")
    assert f".venv/bin/python{command}" in (ROOT / "README.md").read_text("utf-8")
    sources = [file.read_text("utf-8") for file in (ROOT / "hdprog").rglob("*.py")]
    assert not [text for text in sources if re.search(r"install '?hdprog\[", text)]


def test_what_is_lacking_is_told_with_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for package in ("weasyprint", "distributed", "openpyxl"):
        monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(UsageError, match=re.escape(install_words("pdf"))):
        require_pdf()
    dask = pytest.raises(UsageError, match=re.escape(install_words("dask")))
    with dask, dask_client("tcp://127.0.0.1:1"):
        pass
    (tmp_path / "a.xlsx").write_bytes(b"PK\x03\x04")
    with pytest.raises(BadInputError, match=re.escape(install_words("excel"))):
        read_loop(tmp_path / "a.xlsx")
