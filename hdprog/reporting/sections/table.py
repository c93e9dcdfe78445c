"""A table as the templates lay it out: every cell is text already."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hdprog.reporting.rounding import interval


@dataclass(frozen=True)
class Value:
    """A number and, on a line of its own, its interval."""

    text: str
    spread: str

    @staticmethod
    def of(levels: Mapping[float, float], factor: float = 1.0) -> Value:
        """Median and 90 % interval of quantiles, in a unit that the factor takes them to."""
        low, middle, high = interval(*(factor * levels[at] for at in (0.05, 0.50, 0.95)))
        return Value(middle, f"{low} to {high}")


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
