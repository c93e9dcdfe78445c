"""Structure and words of the report in each situation, as they were last read by a person."""

from __future__ import annotations

import pytest

from tests.reporting.golden_text import golden_text, path_of
from tests.reporting.situations import SITUATIONS


@pytest.mark.parametrize("name", SITUATIONS)
def test_the_report_is_the_one_that_was_read(name: str) -> None:
    wanted = path_of(name).read_text("utf-8")
    assert golden_text(SITUATIONS[name]()) == wanted, (
        "if the change is meant: python -m tests.reporting.golden_text, and read the difference"
    )


def test_every_golden_file_belongs_to_a_situation() -> None:
    assert {path.stem for path in path_of("x").parent.glob("*.txt")} == set(SITUATIONS)
