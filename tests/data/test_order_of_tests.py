"""Dates that contradict the service hours are told of."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from hdprog.data.check import check_path
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.data.order_of_tests import order_doubts
from hdprog.data.tests_table import DriveTest
from tests.data.samples import table, write


def made(name: str, hours: float, day: str | None, event: str | None = None) -> DriveTest:
    date = None if day is None else datetime.date.fromisoformat(day)
    return DriveTest(name, Path(f"{name}.csv"), hours, date, event=event)


IN_ORDER = [("a", 0, "2025-01-01"), ("b", 500, "2025-02-01"), ("c", 900, "2025-03-01")]


@pytest.mark.parametrize(
    ("rows", "doubtful"),
    [
        (IN_ORDER, {}),
        ([("a", 0, None), ("b", 500, "2025-02-01"), ("c", 900, None)], {}),
        ([("a", 0, "2025-02-01"), ("b", 500, "2025-02-01")], {}),
        ([("a", 500, "2025-02-02"), ("b", 500, "2025-02-01")], {}),
        ([("a", 0, "2025-01-01"), ("b", 500, "2025-03-01"), ("c", 900, "2025-02-01")], {"c": "b"}),
        # One wrong date is told of once, not at every test after it.
        ([("a", 0, "2035-01-01"), *IN_ORDER[1:]], {"b": "a"}),
        ([*IN_ORDER[:2], ("c", 900, "2005-03-01")], {"c": "b"}),
        # A new drive begins anew; an old one that is put back does not explain what came before.
        ([("n", 10, "2025-04-01", "replaced"), *IN_ORDER[1:]], {}),
        ([("n", 10, "2025-04-01", "replaced"), ("o", 700, "2025-05-01"), IN_ORDER[2]], {}),
        ([("n", 10, "2025-04-01"), ("b", 500, "2025-02-01", "replaced")], {"b": "n"}),
        ([("n", 10, "2025-04-01", "regreased"), ("b", 500, "2025-02-01")], {"b": "n"}),
    ],
)
def test_contradictions_are_found(rows: list[tuple], doubtful: dict[str, str]) -> None:  # type: ignore[type-arg]
    found = order_doubts([made(*row) for row in rows])
    assert list(found) == list(doubtful)
    for name, other in doubtful.items():
        assert f"test {name} (" in found[name]
        assert f"test {other} (" in found[name]


def test_check_and_run_tell_both_tests(tmp_path: Path) -> None:
    write(tmp_path / "drive.toml", '[drive]\nid = "x"\n')
    write(tmp_path / "a.csv", table())
    write(tmp_path / "b.csv", table() + "\n")
    rows = "t01,a.csv,900,2025-01-10\nt02,b.csv,500,2025-02-10\n"
    write(tmp_path / "tests.csv", "test_id,file,service_hours,date\n" + rows)
    report = check_path(tmp_path)
    assert report.ok
    [warning] = [text for text in report.warnings if "By its date" in text]
    assert warning.startswith(
        "t01: By its date, test t01 (2025-01-10, 900 h) comes before test t02 (2025-02-10, 500 h)"
    )
    folder = read_drive_folder(tmp_path)
    doubts = [read_test_loop(folder, test).warnings for test in folder.tests]
    assert doubts == [(), (warning.removeprefix("t01: "),)]
