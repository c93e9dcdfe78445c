"""Reports are HTML5 by the standard's own way of reading it, which names every error."""

from __future__ import annotations

from pathlib import Path

import pytest
from tinyhtml5.parser import HTMLParser

from tests.example_reports.build import REPORTS
from tests.reporting.situations import SITUATIONS, report_of

EXAMPLES = sorted(REPORTS.glob("*.html"))


def errors(page: str) -> list[tuple[object, ...]]:
    parser = HTMLParser()
    parser.parse(page)
    return list(parser.errors)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_valid(path: Path) -> None:
    assert errors(path.read_text("utf-8")) == []


@pytest.mark.parametrize("name", SITUATIONS)
def test_every_situation_makes_a_valid_report(name: str) -> None:
    assert errors(report_of(name)) == []


def test_an_unclosed_tag_is_an_error() -> None:
    assert errors("<!DOCTYPE html><html><body><p><div></p></body></html>")
