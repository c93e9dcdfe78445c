"""What is read of finished runs: those of an older version say nothing of a steady pace."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from hdprog.data.finished_runs import FinishedRuns, read_finished_runs
from hdprog.errors import BadInputError

KEPT = {"precision": [[4.0, 0.0], [0.0, 1.0]], "information": [2.0, 0.5]}


def reading(
    folder: Path,
    steady: dict[str, Any] | None,
    *,
    drive: str = "other",
    converged: bool = True,
    year: int = 2026,
    records: Sequence[str] = (),
) -> FinishedRuns:
    says = {"wear_prior": "one", "deviates": ["wear_rate", "volatility"], **KEPT}
    if steady is not None:
        says["steady"] = steady
    content = {
        "schema": "hdprog.summary/1",
        "drive": {"id": drive},
        "provenance": {
            "created": f"{year}-01-01T00:00:00+00:00",
            "files_sha256": {f"loops/{sha}.csv": sha for sha in records},
        },
        "trend": {"converged": converged, "says": says},
    }
    (folder / "summary.json").write_text(json.dumps(content), "utf-8")
    return read_finished_runs(folder, own_id="own", wear_prior="one")


def test_a_run_of_an_older_version_is_read_without_a_steady_pace(tmp_path: Path) -> None:
    run = reading(tmp_path, None).runs[0]
    assert run.steady is None
    assert run.said.precision.tolist() == KEPT["precision"]


def test_a_steady_pace_is_read(tmp_path: Path) -> None:
    steady = reading(tmp_path, {**KEPT, "log_odds": 1.5}).runs[0].steady
    assert steady is not None
    assert steady.log_odds == 1.5
    assert steady.said.information.tolist() == KEPT["information"]


def test_a_run_behind_a_link_is_read(tmp_path: Path) -> None:
    """As `hdprog fleet` finds drives; it was left out without a word."""
    elsewhere, fleet = tmp_path / "elsewhere", tmp_path / "fleet"
    elsewhere.mkdir()
    fleet.mkdir()
    (fleet / "linked").symlink_to(elsewhere)
    (elsewhere / "back").symlink_to(fleet)  # a ring
    reading(elsewhere, None)
    assert len(read_finished_runs(fleet, own_id="own", wear_prior="one").runs) == 1


@pytest.mark.parametrize(
    "wrong", [{**KEPT, "log_odds": float("nan")}, {"log_odds": 1.0}, {**KEPT, "information": [1.0]}]
)
def test_a_run_that_says_no_numbers_is_left_out(tmp_path: Path, wrong: dict[str, Any]) -> None:
    with pytest.raises(BadInputError, match="not a summary of a finished run"):
        reading(tmp_path, wrong)


def test_a_run_whose_trend_did_not_converge_is_left_out_with_words(tmp_path: Path) -> None:
    """It was left out without any: a fleet of fewer drives than the reader had put there."""
    for name in ("sound", "doubtful", "own"):
        (tmp_path / name).mkdir()
    with pytest.raises(BadInputError, match="its trend did not converge"):
        reading(tmp_path / "doubtful", None, drive="doubtful", converged=False)
    reading(tmp_path / "sound", None)
    with pytest.raises(BadInputError, match="no finished run"):
        reading(tmp_path / "own", None, drive="own", converged=False)
    found = read_finished_runs(tmp_path, own_id="own", wear_prior="one")
    assert [run.drive_id for run in found.runs] == ["other"]
    (left,) = found.left_out
    assert left.startswith(str(tmp_path / "doubtful"))
    assert "did not converge" in left


def test_two_drives_of_one_id_are_told(tmp_path: Path) -> None:
    """Of a copied folder whose id was kept only the newer counted, without a word."""
    for name in ("a", "b", "again", "mine"):
        (tmp_path / name).mkdir()
    reading(tmp_path / "a", None, year=2024, records=("r1", "r2"))
    reading(tmp_path / "again", None, year=2025, records=("r3",))
    reading(tmp_path / "b", None, records=("r3", "r4"))  # the newer run of that drive
    with pytest.raises(BadInputError, match="no finished run"):
        reading(tmp_path / "mine", None, drive="own", records=("r5",))

    def found(*own: str) -> FinishedRuns:
        return read_finished_runs(tmp_path, own_id="own", wear_prior="one", own_records=own)

    known = found("r5", "r6")
    assert [run.path.parent.name for run in known.runs] == ["b"]
    (doubt,) = known.doubts
    assert f'{tmp_path / "a" / "summary.json"} has the id "other", as has that of' in doubt
    assert "give each an id of its own in drive.toml" in doubt
    assert [left.partition(":")[0] for left in known.left_out] == [str(tmp_path / "a/summary.json")]
    mine, _ = found("r7").doubts
    assert 'mine/summary.json has the id "own", as has the drive that is run here' in mine
