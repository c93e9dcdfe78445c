"""What is printed where the encoding of standard output lacks some signs."""

from __future__ import annotations

import io
import json
import sys

import pytest

from hdprog.cli.common import print_json
from hdprog.cli.plain_output import write_plainly_where_needed

SAID = (
    "Inspect before 1\u202f450\u202fh: \u221226\u202f\u2192\u202f7.1 \u00b5rad, "
    "2 \u00d7 10\u207b\u2075 in\u00b7lbf"
)


@pytest.mark.parametrize(
    ("encoding", "written"),
    [
        ("utf-8", SAID),
        ("cp1252", "Inspect before 1 450 h: -26 -> 7.1 \u00b5rad, 2 \u00d7 10-5 in\u00b7lbf"),
        ("ascii", "Inspect before 1 450 h: -26 -> 7.1 urad, 2 x 10-5 in-lbf"),
    ],
)
def test_words_are_written_as_far_as_the_encoding_goes(
    encoding: str, written: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding, write_through=True)
    monkeypatch.setattr(sys, "stdout", stream)
    write_plainly_where_needed()
    print(SAID)
    assert stream.buffer.getvalue().decode(encoding).rstrip() == written


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "ascii"])
def test_json_is_the_same_in_every_encoding(encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding, write_through=True)
    monkeypatch.setattr(sys, "stdout", stream)
    write_plainly_where_needed()
    print_json({"text": f"\u201c{SAID}\u201d"})
    assert json.loads(stream.buffer.getvalue().decode(encoding)) == {"text": f"\u201c{SAID}\u201d"}
