"""A table as the templates lay it out: every cell is text already."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Value:
    """A number and, on a line of its own, its interval."""

    text: str
    spread: str


Cell = str | Value


@dataclass(frozen=True)
class Row:
    """One row; `doubtful` marks numbers of a fit that did not converge."""

    head: str
    cells: tuple[Cell, ...]
    note: str = ""
    doubtful: bool = False


@dataclass(frozen=True)
class Group:
    """Rows under a heading of their own; an empty title has none."""

    title: str
    rows: tuple[Row, ...]
    doubtful: bool = False


@dataclass(frozen=True)
class Table:
    """Caption, column heads and groups of rows; the first head is that of the row heads."""

    caption: str
    columns: tuple[str, ...]
    groups: tuple[Group, ...]
    doubtful: bool = False

    @staticmethod
    def flat(
        caption: str, columns: tuple[str, ...], rows: list[Row], *, doubtful: bool = False
    ) -> Table:
        """Table without groups."""
        return Table(caption, columns, (Group("", tuple(rows)),), doubtful)
