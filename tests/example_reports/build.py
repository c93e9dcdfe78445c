"""Runs the command of an example and keeps its report."""

from __future__ import annotations

import html
import os
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from tests.example_reports.examples import Example

ROOT = Path(__file__).resolve().parents[2]
REPORTS = ROOT / "reports"
_RECORD = Path(__file__).with_name("few-readings.csv")
_DONE, _NOT_CONVERGED = 0, 4
_NUMBERS = re.compile(r'<p class="data">.*?</p>\n?', re.DOTALL)
_SUBTITLE = re.compile(r'(<p class="sub">.*?</p>)', re.DOTALL)


@dataclass(frozen=True)
class Built:
    """What the index says of an example."""

    example: Example
    status: str
    provisional: bool
    label: str
    sentence: str


def build(example: Example, data: Path | None) -> Built:
    """Run an example's command and write its report to reports/.

    Parameters
    ----------
    example : which
    data : folder of the measured records; needed for examples that name DATA
    """
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        (place / "datasets").symlink_to(ROOT / "datasets")
        if data is not None:
            (place / "DATA").symlink_to(data.resolve())
        (place / _RECORD.name).symlink_to(_RECORD)
        command = shlex.split(example.command)
        program = Path(sys.executable).with_name(command[0])
        done = subprocess.run(
            [str(program), *command[1:], "--quiet"],
            cwd=place,
            env={**os.environ, "NO_COLOR": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        # Measured records may go either way; the others show what they are there to show.
        wanted = {_DONE if example.converges else _NOT_CONVERGED}
        if example.source:
            wanted = {_DONE, _NOT_CONVERGED}
        if done.returncode not in wanted:
            sys.exit(f"{example.command}\nended with {done.returncode}:\n{done.stderr}")
        [folder] = place.glob("hdprog-*")
        report = (folder / "report.html").read_text("utf-8")
    text = report.replace(" --quiet", "")
    (REPORTS / f"{example.name}.html").write_text(
        _of_measured(text, example.source) if example.source else text, "utf-8"
    )
    built = kept(example)
    if built is None:
        sys.exit(f"{example.command}\nleft no report")
    return built


def _of_measured(report: str, source: str) -> str:
    """Report that names the source of its record, without the record's numbers as files."""
    named = _SUBTITLE.sub(
        lambda found: f'{found[1]}\n<p class="sub">{html.escape(source)}</p>', report, count=1
    )
    return _NUMBERS.sub("", named)


def kept(example: Example) -> Built | None:
    """What the index says of a report that is there already; None where there is none."""
    path = REPORTS / f"{example.name}.html"
    if not path.is_file():
        return None
    text = path.read_text("utf-8")
    found = re.search(
        r'<section class="verdict (?P<status>\w+)(?P<provisional> provisional)?".*?'
        r'<h2 id="verdict">(?P<label>.*?)</h2>\s*<p class="lead">(?P<lead>.*?)</p>'
        r"(?:\s*<p>(?P<rest>.*?)</p>)?",
        text,
        re.DOTALL,
    )
    if found is None:
        sys.exit(f"{path} has no verdict")
    sentences = re.split(r"(?<=[.!?]) (?=[A-Z])", found["rest"] or "")
    told = [one for one in sentences if example.tells and example.tells in one]
    return Built(
        example,
        found["status"],
        bool(found["provisional"]),
        html.unescape(found["label"]),
        html.unescape((told or [found["lead"]])[0]),
    )
