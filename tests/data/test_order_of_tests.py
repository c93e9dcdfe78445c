"""Dates that contradict the service hours are told of."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from hdprog.data.check import check_path
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.data.order_of_tests import order_doubts
from hdprog.data.tests_table import DriveTest, read_tests
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
        # Hours do not begin anew with a new drive.
        ([("n", 10, "2025-04-01", "replaced"), ("o", 700, "2025-05-01"), IN_ORDER[2]], {"c": "o"}),
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


@pytest.mark.parametrize(
    ("count", "more"),
    [
        (2, None),
        (3, "disagree at one more test in the same way."),
        (10, "disagree at 8 more tests in the same way."),
    ],
)
def test_dates_in_reverse_are_told_once(count: int, more: str | None) -> None:
    """Ten tests had nine long warnings."""
    tests = [made(f"t{n}", 100.0 * n, f"2025-01-{30 - n:02}") for n in range(count)]
    ((name, said),) = order_doubts(tests).items()
    assert name == "t1"
    assert said.startswith("By its date, test t1 (2025-01-29, 100 h) comes before test t0 (")
    assert "same way" not in said if more is None else said.endswith(more)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ("a,0, b,610, c,11800, d,1830", "test d (1830 h) stands below test c (11800 h)"),
        ("a,0, b,610, c,200, d,1830", "test c (200 h) stands below test b (610 h)"),
        ("d,1830, c,1200, b,610, a,0", ""),  # the newest first
        ("b,610, d,1830, a,0, e,2000, c,1200", ""),  # in no order
        ("a,0, b,610, c,610, d,1830", ""),
        ("b,610, a,0", ""),
    ],
)
def test_hours_that_fall_once_from_row_to_row_are_told(
    tmp_path: Path, rows: str, told: str
) -> None:
    """A digit too many passed without a word where there were no dates."""
    (tests, _) = read_tests(written(tmp_path, rows))
    found = list(order_doubts(tests).values())
    assert len(found) == bool(told)
    assert all(told in text for text in found)


def written(folder: Path, rows: str) -> Path:
    """Folder with a tests.csv of rows "test_id,service_hours,date,event", and a file for all."""
    write(folder / "a.csv", table())
    lines = ["test_id,service_hours,date,event,file"]
    for row in rows.split(", "):
        name, hours, *rest = row.split(",")
        day, event = [*rest, "", ""][:2]
        lines.append(f"{name},{hours},{day},{event},a.csv")
    write(folder / "tests.csv", "\n".join(lines) + "\n")
    return folder


@pytest.mark.parametrize(
    ("rows", "refused"),
    [
        ("a,0,2025-01-01, b,500,2025-02-01, n,10,2025-03-01,replaced", "500 of test b"),
        ("a,0,2025-01-01, b,500,2025-02-01, n,510,2025-03-01,replaced", None),
        # Newest first in the file; without dates the rows' order tells, if they are in order.
        ("n,10,2025-03-01,replaced, b,500,2025-02-01, a,0,2025-01-01", "500 of test b"),
        ("a,0, b,500, n,0,,replaced, o,300", "500 of test b"),
        ("n,900,,replaced, b,500, a,0", None),
        ("b,500, n,0,,replaced", None),
        # Both tests of the day on which the drive was replaced; the rows tell which came first.
        ("a,0,2025-01-01, b,500,2025-02-01, n,10,2025-02-01,replaced", "500 of test b"),
        ("o,20,2025-02-01, n,10,2025-02-01,replaced, b,5,2025-01-02, a,0,2025-01-01", None),
        ("o,20,2025-02-01, n,10,2025-02-01,replaced", None),
        ("o,90,, n,10,2025-03-01,replaced, b,500,2025-02-01", "500 of test b"),
        # The new drive's tests alone have dates.
        ("a,0, b,500, n,0,2025-03-01,replaced, o,300,2025-04-01", "500 of test b"),
        ("a,0, b,500, n,510,2025-03-01,replaced, o,300,2025-04-01", None),
    ],
)
def test_a_new_drives_hours_go_on_from_the_old(
    tmp_path: Path, rows: str, refused: str | None
) -> None:
    _, problems = read_tests(written(tmp_path, rows))
    words = [str(problem) for problem in problems]
    assert len(words) == (refused is not None)
    if refused is not None:
        assert f"less than the {refused} before it" in words[0]
        assert "Add the old drive's last hours" in words[0]


@pytest.mark.parametrize(
    ("rows", "order"),
    [
        ("o,700,2025-04-01, n,500,2025-03-01,replaced, b,500,2025-02-01, a,0", "a b n o"),
        ("a,0, b,500,2025-02-01, n,500,2025-03-01,replaced", "a b n"),
        ("a,0, b,500,2025-02-01, n,500,2025-02-01,regreased", "a b n"),
        ("a,0, b,500, n,500,2025-02-01,regreased, c,500,2025-01-01", "a b n c"),
    ],
)
def test_tests_at_the_same_hours_are_in_the_order_of_their_dates(
    tmp_path: Path, rows: str, order: str
) -> None:
    """In a table with the newest on top the old drive's last test was taken for the new one's."""
    tests, problems = read_tests(written(tmp_path, rows))
    assert problems == ()
    assert [test.test_id for test in tests] == order.split()


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
