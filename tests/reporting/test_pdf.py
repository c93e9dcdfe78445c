"""The report as PDF: the same words on A4, nothing fetched, and clear words where it cannot be."""

from __future__ import annotations

import builtins
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hdprog.errors import UsageError
from hdprog.reporting.build import build_report
from hdprog.reporting.pdf import require_pdf, write_pdf
from tests.reporting.drives import wearing


def needs_pdf() -> None:
    try:
        require_pdf()
    except UsageError as error:
        pytest.skip(str(error))


def test_the_pdf_has_the_words_of_the_report(tmp_path: Path) -> None:
    needs_pdf()
    report = tmp_path / "report.html"
    result = wearing()
    effects = {"blocks": 460.0, "evaluations": 80_352.0, "pareto_k": 0.98}
    effects["weighted_draws_effective"] = 62.0
    told = [replace(one, diagnostics=one.diagnostics | effects) for one in result.tests]
    report.write_text(build_report(replace(result, tests=tuple(told))), "utf-8")
    path = write_pdf(report)
    assert path == tmp_path / "report.pdf"
    content = path.read_bytes()
    assert content.startswith(b"%PDF-")
    if shutil.which("pdftotext") is None:
        pytest.skip("pdftotext is not installed: the words of the PDF are not read")
    text = subprocess.run(
        ["pdftotext", "-layout", str(path), "-"], capture_output=True, text=True, check=True
    ).stdout
    words = re.sub(r"\s+", " ", text)
    for wanted in ("Remaining life", "Trend of each limited figure", "Provenance"):
        assert wanted in words
    assert "their weights" in words  # the last of many columns, which lay beside the paper
    sizes = subprocess.run(
        ["pdfinfo", str(path)], capture_output=True, text=True, check=True
    ).stdout
    assert "A4" in sizes


def test_a_report_that_asks_for_something_outside_is_no_report(tmp_path: Path) -> None:
    needs_pdf()
    report = tmp_path / "report.html"
    report.write_text('<p>words</p><img src="http://127.0.0.1:9/x.png" alt="x">', "utf-8")
    # Beyond what a handler of mistakes would catch.
    with pytest.raises(BaseException, match=r"127\.0\.0\.1"):
        write_pdf(report)
    assert not (tmp_path / "report.pdf").exists()


def test_without_the_package_it_is_said_before_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *others: Any, **more: Any) -> Any:
        if name == "weasyprint":
            raise ModuleNotFoundError("No module named 'weasyprint'")
        return real(name, *others, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(UsageError, match=r"-m pip install -c constraints.txt '\.\[pdf\]'"):
        require_pdf()
