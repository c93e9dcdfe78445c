"""What a benchmark's results hang on: what it imports, directly or not, and nothing else."""

from __future__ import annotations

from pathlib import Path

from tests.benchmarks.code_state import digest, imported_by


def _names(files: list[Path]) -> set[str]:
    return {file.relative_to(Path(__file__).parents[2]).as_posix() for file in files}


def test_imports_are_followed_through_other_modules_and_into_functions() -> None:
    found = _names(imported_by("hdprog.inference.fit_loop"))
    assert "hdprog/inference/sampler.py" in found  # by another module
    assert "hdprog/config/__init__.py" in found  # a package by its own file


def test_what_is_not_imported_does_not_count() -> None:
    found = _names(imported_by("hdprog.inference.fit_loop", "hdprog.trend.fitting"))
    assert not any(name.startswith("hdprog/reporting") for name in found)
    assert "hdprog/__init__.py" not in found
    whole = imported_by("hdprog.trend.fitting")
    without = imported_by("hdprog.trend.fitting", but=["hdprog.trend.kalman_filter"])
    assert _names(whole) - _names(without) >= {"hdprog/trend/kalman_filter.py"}


def test_a_digest_changes_with_one_byte_and_with_the_order(tmp_path: Path) -> None:
    one, other = tmp_path / "one.py", tmp_path / "other.py"
    one.write_text("a = 1\n")
    other.write_text("b = 1\n")
    before = digest([one, other])
    assert digest([other, one]) != before
    one.write_text("a = 2\n")
    assert digest([one, other]) != before
