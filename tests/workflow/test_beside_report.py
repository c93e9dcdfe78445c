"""From Python, too, no report is lost to results of another kind."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

from hdprog.errors import BadInputError
from hdprog.outcome import Outcome, write_beside_report


@pytest.mark.parametrize(
    ("single", "lies", "refused"),
    [
        (True, "posteriors", "expected a new folder, or one with earlier results of `hdprog fit`"),
        (False, "compare.json", "found the compare.json of `hdprog compare`"),
    ],
)
def test_fits_are_not_written_over_another_report(
    tmp_path: Path, single: bool, lies: str, refused: str
) -> None:
    (tmp_path / lies).touch()
    outcome = Outcome(cast("Any", None), (), single)
    with pytest.raises(BadInputError, match=refused):
        outcome.write(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == [lies]


def test_a_comparison_renews_its_own_report_alone(tmp_path: Path) -> None:
    for report in ("first", "second"):
        write_beside_report(tmp_path, "compare.json", {}, report)
    with pytest.raises(BadInputError, match=r"Give another folder\.$"):
        write_beside_report(tmp_path, "backtest.json", {}, "third")
    assert (tmp_path / "report.html").read_text("utf-8") == "second"
