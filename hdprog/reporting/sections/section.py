"""A part of a page that is made of paragraphs, pictures and tables."""

from __future__ import annotations

from dataclasses import dataclass

from hdprog.reporting.sections.table import Table
from hdprog.reporting.style import Picture


@dataclass(frozen=True)
class Section:
    """A part of the page; pictures with a heading of their own, or none."""

    id: str
    title: str
    paragraphs: tuple[str, ...] = ()
    pictures: tuple[tuple[str, Picture], ...] = ()
    tables: tuple[Table, ...] = ()
