"""Uploaded records are read in processes that may be ruined without harm."""

from __future__ import annotations

import gzip
import os
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from hdprog.data.check import check_path
from hdprog.service import readers as module
from hdprog.service.readers import Readers
from tests.store.samples import WEARING

SAID = {"drive": {"id": "x", "rated_torque_Nm": 63.0}}
LOOP = WEARING / "loops" / "t01.csv"


@pytest.fixture(scope="module")
def readers() -> Iterator[Readers]:
    made = Readers(1)
    yield made
    made.stop()


def test_a_record_is_read_and_drawn(readers: Readers) -> None:
    found = readers.read(LOOP, "mine.csv", SAID)
    assert found.problems == ()
    assert found.quality["samples"] == 900
    assert found.quality["cycles"] == pytest.approx(3.0, abs=0.05)
    assert found.quality["lines"][0].startswith("mine.csv: usable: 900 samples")
    assert found.picture.startswith("<svg")


@pytest.mark.skipif(sys.platform == "win32", reason="no process groups")
def test_an_interrupt_from_the_keyboard_is_not_for_readers(readers: Readers) -> None:
    """It goes to the terminal's group: whoever ended a server with it saw their tracebacks."""
    process = readers._all[0]._running()
    assert os.getpgid(process.pid) == process.pid != os.getpgrp()


def test_what_is_wrong_is_said_as_check_says_it(readers: Readers, tmp_path: Path) -> None:
    text = LOOP.read_text().splitlines()
    text[20] = text[20].replace(text[20].split(",")[0], "n/a", 1)
    wrong = tmp_path / "kept-under-another-name"
    wrong.write_text("\n".join(text))
    named = tmp_path / "mine.csv"
    named.write_text("\n".join(text))
    assert readers.read(wrong, "mine.csv", SAID).problems == check_path(named).problems


def test_a_bomb_ruins_its_reader_only(
    readers: Readers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_SECONDS", 3.0)
    bomb = tmp_path / "bomb"
    with gzip.open(bomb, "wb", compresslevel=1) as file:
        file.write(b"torque_Nm,angle_rad\n")
        for _ in range(60):
            file.write(b"1.25,0.00001\n" * 400_000)
    found = readers.read(bomb, "bomb.csv.gz", SAID)
    assert len(found.problems) == 1
    assert "bomb.csv.gz: found" in found.problems[0]
    monkeypatch.undo()
    assert readers.read(LOOP, "mine.csv", SAID).problems == ()


def test_a_large_record_has_the_longer(
    readers: Readers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever --max-upload-mb allowed, more than a minute's reading was refused."""
    allowed: list[float] = []

    def ask(_reader: object, _order: object, seconds: float) -> None:
        allowed.append(seconds)

    monkeypatch.setattr(module._Reader, "ask", ask)
    large = tmp_path / "large"
    for megabytes in (1, 64, 300):
        with large.open("wb") as file:
            file.truncate(megabytes * 1_000_000)
        [problem] = readers.read(large, "large.csv", SAID).problems
    assert allowed == [60.0, 128.0, 600.0]
    assert "not read within 600 s" in problem


def test_a_bomb_in_a_workbook(
    readers: Readers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_SECONDS", 3.0)
    bomb = tmp_path / "bomb"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("[Content_Types].xml", "xl/workbook.xml", "xl/worksheets/sheet1.xml"):
            archive.writestr(name, b"<a>" + b" " * 50_000_000)
    found = readers.read(bomb, "bomb.xlsx", SAID)
    assert len(found.problems) == 1
    monkeypatch.undo()
    assert readers.read(LOOP, "mine.csv", SAID).problems == ()


@pytest.mark.parametrize(
    "content",
    [b"", b"\x00" * 2000, b"\x7fELF" + bytes(range(256)) * 20, b"PK\x03\x04junk", b"\x1f\x8bjunk"],
)
def test_what_is_no_record(readers: Readers, tmp_path: Path, content: bytes) -> None:
    wrong = tmp_path / "wrong"
    wrong.write_bytes(content)
    found = readers.read(wrong, "wrong.bin", SAID)
    assert len(found.problems) == 1
    assert str(tmp_path) not in found.problems[0]
    assert "wrong.bin" in found.problems[0]
