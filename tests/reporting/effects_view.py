"""Reads the section of effects: its tables by their heads, its texts as one."""

from __future__ import annotations

from hdprog.explanation import DriveExplanation, Explanation
from hdprog.reporting.sections.effects import Section, effects
from hdprog.reporting.sections.table import Table, Value
from hdprog.reporting.style import house_style
from tests.reporting.page import spaced


def section(explanation: Explanation | DriveExplanation) -> Section:
    with house_style():
        found = effects(explanation)
    assert found is not None
    return found


def rows(table: Table) -> dict[str, tuple[str, ...]]:
    """Cells of a table by the head of their row, with plain spaces."""
    return {
        spaced(row.head): tuple(
            spaced(f"{cell.text} ({cell.spread})" if isinstance(cell, Value) else cell)
            for cell in row.cells
        )
        for group in table.groups
        for row in group.rows
    }


def tables(explanation: Explanation | DriveExplanation) -> dict[str, dict[str, tuple[str, ...]]]:
    """Rows of every table of the section by the first words of its caption."""
    found = section(explanation)
    return {
        spaced(" ".join(table.caption.split()[:4])): rows(table)
        for part in found.parts
        for table in part.tables
    }


def said(explanation: Explanation | DriveExplanation) -> str:
    found = section(explanation)
    texts = [found.lead, found.left, *(text for part in found.parts for text in part.paragraphs)]
    return spaced(" ".join(texts))
