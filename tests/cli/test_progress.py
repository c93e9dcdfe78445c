"""Progress shows on a terminal only, and only when asked for."""

from __future__ import annotations

import io
import sys

import pytest

from hdprog.cli.progress import progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("terminal", "quiet"), [(False, False), (False, True), (True, True)])
def test_no_progress_without_a_terminal_or_when_quiet(
    monkeypatch: pytest.MonkeyPatch, terminal: bool, quiet: bool
) -> None:
    stream = Terminal() if terminal else io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with progress(quiet=quiet) as report:
        assert report is None
    assert stream.getvalue() == ""


def test_progress_names_the_stage_on_standard_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("NO_COLOR", "1")
    with progress(quiet=False) as report:
        assert report is not None
        report("fit t01", 1, 4)
        report("fit t01", 4, 4)
    assert "fit t01" in stream.getvalue()
    assert "4/4" in stream.getvalue()
    assert "\x1b[3" not in stream.getvalue()  # no colour
    assert capsys.readouterr().out == ""
