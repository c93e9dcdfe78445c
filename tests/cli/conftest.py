"""A runner for the command line, and stand-ins for the slow workflow behind it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from hdprog.cli import app
from hdprog.config import ReportSettings

Invoke = Callable[..., Result]


@dataclass
class Outcome:
    """A finished fit or run whose numbers are agreed on beforehand."""

    converged: bool = True
    sentence: str = "Inspect before 1 310 h."
    written: list[tuple[Path, str]] = field(default_factory=list)
    units: ReportSettings = field(default_factory=ReportSettings)
    doubts: tuple[str, ...] = ()

    def write(self, out: Path, command: str) -> None:
        out.mkdir(parents=True, exist_ok=True)
        (out / "report.html").write_text("<p>report</p>", encoding="utf-8")
        (out / "summary.json").write_text(json.dumps(self.summary()), encoding="utf-8")
        self.written.append((out, command))

    def reported(self, change: Callable[[ReportSettings], ReportSettings]) -> Outcome:
        self.units = change(ReportSettings())
        return self

    def document(self) -> dict[str, object]:
        return self.summary()

    def summary(self) -> dict[str, Any]:
        return {"schema": "hdprog.summary/1", "drive": {"id": "cell3-axis2"}}


@dataclass
class Workflow:
    """What `hdprog.workflow` was asked, and what it answers."""

    outcome: Outcome = field(default_factory=Outcome)
    error: BaseException | None = None
    calls: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = field(default_factory=list)

    def answer(self, name: str) -> Callable[..., Outcome]:
        def called(*arguments: Any, **options: Any) -> Outcome:
            self.calls.append((name, arguments, options))
            if self.error is not None:
                raise self.error
            return self.outcome

        return called


def put_module(monkeypatch: pytest.MonkeyPatch, name: str, **content: Any) -> None:
    """Put a module of these names in the place of `name`, imported or not."""
    module = ModuleType(name)
    for key, value in content.items():
        setattr(module, key, value)
    monkeypatch.setitem(sys.modules, name, module)
    parent, _, child = name.rpartition(".")
    __import__(parent)
    monkeypatch.setattr(sys.modules[parent], child, module, raising=False)


@pytest.fixture
def invoke(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Invoke:
    """Run `hdprog` with these arguments in an empty working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HDPROG_DEBUG", raising=False)

    def run(*arguments: str) -> Result:
        return CliRunner().invoke(app, list(arguments), prog_name="hdprog")

    return run


@pytest.fixture
def workflow(monkeypatch: pytest.MonkeyPatch) -> Workflow:
    """Put a workflow in place that answers at once."""
    stand_in = Workflow()
    put_module(
        monkeypatch, "hdprog.workflow", run=stand_in.answer("run"), fit=stand_in.answer("fit")
    )
    return stand_in
