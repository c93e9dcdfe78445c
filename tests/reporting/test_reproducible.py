"""Two runs of the same command with the same seed differ by the date alone."""

from __future__ import annotations

import re
from pathlib import Path

from hdprog import workflow
from hdprog.config import read_drive
from hdprog.data.readers import read_loop

DATASET = Path(__file__).resolve().parents[2] / "datasets" / "wearing-csf-25-80"
CREATED = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00")
DAY = re.compile(r"report of \d{4}-\d\d-\d\d")


def written(folder: Path) -> str:
    drive = read_drive(DATASET)
    loop = read_loop(DATASET / "loops" / "t01.csv", drive=drive)
    workflow.fit(loop, drive, seed=3, quick=True).write(folder, "hdprog fit t01.csv --seed 3")
    return (folder / "report.html").read_text("utf-8")


def test_two_runs_differ_by_the_date_alone(tmp_path: Path) -> None:
    first, second = written(tmp_path / "first"), written(tmp_path / "second")
    assert len(CREATED.findall(first)) == 1
    undated = [DAY.sub("report of DAY", CREATED.sub("DATE", text)) for text in (first, second)]
    assert undated[0] == undated[1]
