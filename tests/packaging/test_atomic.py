"""A file is there whole or as it was before."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hdprog.atomic import atomic_directory, atomic_write_bytes, atomic_write_text
from hdprog.cli.common import output_folder
from hdprog.drive_folders import drive_folders
from hdprog.errors import UsageError


def names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def test_text_is_written_as_utf8_without_leftovers(tmp_path: Path) -> None:
    atomic_write_text(tmp_path / "new" / "a.txt", "µrad\n")
    assert (tmp_path / "new" / "a.txt").read_bytes() == "µrad\n".encode()
    assert names(tmp_path) == ["new", "new/a.txt"]


def test_failed_write_leaves_the_old_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "a.bin"
    atomic_write_bytes(target, b"old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        atomic_write_bytes(target, b"new")
    assert target.read_bytes() == b"old"
    assert names(tmp_path) == ["a.bin"]


def test_new_folder_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "out"
    with atomic_directory(target) as aside:
        (aside / "posteriors").mkdir()
        (aside / "posteriors" / "t01.nc").write_bytes(b"1")
        (aside / "summary.json").write_text("{}", encoding="utf-8")
        assert not target.exists()
    assert names(target) == ["posteriors", "posteriors/t01.nc", "summary.json"]
    assert names(target.parent) == ["out", *(f"out/{name}" for name in names(target))]


def test_existing_folder_keeps_its_other_files(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "posteriors").mkdir()
    (tmp_path / "summary.json").write_text("old", encoding="utf-8")
    with atomic_directory(tmp_path) as aside:
        (aside / "posteriors").mkdir()
        (aside / "posteriors" / "t01.nc").write_bytes(b"1")
        (aside / "summary.json").write_text("new", encoding="utf-8")
        assert (tmp_path / "summary.json").read_text(encoding="utf-8") == "old"
    assert (tmp_path / "summary.json").read_text(encoding="utf-8") == "new"
    assert names(tmp_path) == ["mine.txt", "posteriors", "posteriors/t01.nc", "summary.json"]


def test_results_of_before_that_are_not_made_anew_go(tmp_path: Path) -> None:
    for name in ("old.nc", "kept.nc", "own.txt"):
        (tmp_path / name).write_text("before")
    with atomic_directory(tmp_path, renewed=("*.nc",)) as aside:
        (aside / "kept.nc").write_text("now")
        assert (tmp_path / "old.nc").exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept.nc", "own.txt"]
    assert (tmp_path / "kept.nc").read_text() == "now"


def test_the_longest_name_of_a_folder_or_file_can_be_written(tmp_path: Path) -> None:
    long = "ü" * 120 + "x" * 15  # 255 bytes
    with atomic_directory(tmp_path / long) as aside:
        atomic_write_text(aside / long, "whole")
    assert (tmp_path / long / long).read_text("utf-8") == "whole"


@pytest.mark.parametrize("existing", [False, True])
@pytest.mark.parametrize("interruption", [KeyboardInterrupt, ValueError])
def test_interrupted_block_leaves_all_as_it_was(
    tmp_path: Path, existing: bool, interruption: type[BaseException]
) -> None:
    target = tmp_path / "out"
    if existing:
        atomic_write_text(target / "summary.json", "old")
    before = names(tmp_path)

    def interrupted() -> None:
        with atomic_directory(target) as aside:
            (aside / "summary.json").write_text("half", encoding="utf-8")
            raise interruption

    with pytest.raises(interruption):
        interrupted()
    assert names(tmp_path) == before
    if existing:
        assert (target / "summary.json").read_text(encoding="utf-8") == "old"


def test_a_file_in_the_way_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine", encoding="utf-8")
    with pytest.raises(NotADirectoryError), atomic_directory(tmp_path / "out"):
        pass
    assert (tmp_path / "out").read_text(encoding="utf-8") == "mine"


def test_what_a_killed_command_left_aside_is_no_drive(tmp_path: Path) -> None:
    """A fleet took it for one."""
    with atomic_directory(tmp_path / "axis") as aside:
        (aside / "drive.toml").write_text("", "utf-8")
        assert drive_folders(tmp_path) == []
    assert drive_folders(tmp_path) == [tmp_path / "axis"]


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="this system has no /proc")
def test_a_place_that_takes_no_folder_is_refused_before_the_work(tmp_path: Path) -> None:
    """Its permissions let the superuser write; what failed was named by its temporary name."""
    assert output_folder(tmp_path / "there", "drive") == tmp_path / "there"
    assert names(tmp_path) == []
    with pytest.raises(UsageError, match="found the folder /proc, in which nothing can be written"):
        output_folder(Path("/proc/hd"), "drive")


@pytest.mark.skipif(os.name != "posix", reason="this system has no such locks")
@pytest.mark.parametrize("there", [False, True])
def test_what_a_killed_writer_left_goes_with_the_next_one(tmp_path: Path, there: bool) -> None:
    out = tmp_path / "out"
    if there:
        out.mkdir()
    place = out if there else tmp_path
    left = place / f".{'hdprog' if there else 'out'}.0123abcd.part"
    left.mkdir()
    (left / "summary.json").write_text("{")
    other = place / ".other.0123abcd.part"
    other.mkdir()
    with atomic_directory(out) as first:
        for folder in (left, other, first):
            os.utime(folder, (0.0, 0.0))
        with atomic_directory(out) as second:
            assert first.is_dir()  # its writer lives
            assert not left.exists()
            (second / "a").write_text("2")
    assert (out / "a").read_text() == "2"
    assert other.is_dir()


@pytest.mark.skipif(os.name != "posix", reason="this system has no such locks")
def test_what_a_killed_writer_left_of_a_file_goes_with_the_next_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "a.json"
    left, other, young = (
        tmp_path / f".{name}.part"
        for name in ("a.json.0123abcd", "b.json.0123abcd", "a.json.4567abcd")
    )
    for path in (left, other, young):
        path.write_text("{")
    for path in (left, other):
        os.utime(path, (0.0, 0.0))
    synced = os.fsync

    def second_writer(handle: int) -> None:
        """Write the same file while a first writer lives, however long it has been at it."""
        monkeypatch.setattr("os.fsync", synced)
        (first,) = (path for path in tmp_path.glob(".a.json.*") if path != young)
        os.utime(first, (0.0, 0.0))
        atomic_write_text(out, "second")
        assert first.exists()
        synced(handle)

    monkeypatch.setattr("os.fsync", second_writer)
    atomic_write_text(out, "first")
    assert out.read_text() == "first"
    assert sorted(tmp_path.iterdir()) == sorted((out, other, young))
