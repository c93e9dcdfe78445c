"""Records are told apart by their files' names, whatever dots are in them."""

from __future__ import annotations

import pytest

from hdprog.data.loop import Loop
from hdprog.data.record_name import record_name
from hdprog.workflow import _stem
from tests.data.samples import two_sided


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("t01.csv", "t01"),
        ("t01.csv.gz", "t01"),
        ("T01.CSV", "T01"),
        ("t01.xlsx", "t01"),
        ("12.03.2025_axis2.csv", "12.03.2025_axis2"),
        ("12.04.2025_axis5.csv", "12.04.2025_axis5"),
        ("cell3.axis1.tsv.gz", "cell3.axis1"),
        ("loop.7", "loop.7"),
        ("t01..csv", "t01"),
        (".csv", "csv"),
        ("..", "record"),
        ("record", "record"),
    ],
)
def test_endings_of_tables_are_no_part_of_a_name(file: str, name: str) -> None:
    assert record_name(file) == name


def test_a_fitted_record_goes_by_that_name() -> None:
    assert _stem(Loop(*two_sided(), source="12.03.2025_axis2.csv.gz")) == "12.03.2025_axis2"
