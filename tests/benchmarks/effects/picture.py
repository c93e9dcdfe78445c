"""The confusion matrix as a picture: what was in the loop, and what it was called."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from hdprog.reporting.style import GRID, INK, LIMIT, MUTED, house_style
from tests.benchmarks.effects import NOTHING, UNKNOWN
from tests.benchmarks.effects.loops import LISTED, SIZES, UNLISTED
from tests.benchmarks.effects.summary import COLUMNS
from tests.independent.effects import EFFECTS

ROWS = (*LISTED, *UNLISTED)
_COLOURS = "Blues"  # one hue, light to dark: as readable in grey
_DARK = 0.55  # share above which a cell's figure is white
_LABELS = 0.045  # of the figure's width, for the rows of the clean loops
_KEY = """Framed in orange: the right name.
Above the grey line: effects that a list knows.
Below it: effects on no list, rightly called unknown.
Hatched: no loop of that sort was fitted.
Right of each row: number of loops fitted."""


def write_picture(result: dict[str, Any], path: Path) -> None:
    """Draw the confusion matrix of a summary, a panel a size, and one of clean loops."""
    with house_style():
        figure = Figure(figsize=(17.5, 17.0), dpi=100)
        axes = figure.subplots(2, 3, sharey=True).ravel()
        for place, size in enumerate(SIZES):
            counts = result["confusion"].get(f"{size:g}", {}).get("named", {})
            title = f"What the model cannot absorb: {size:g} × noise"
            _panel(axes[place], title, [(name, counts.get(name, {})) for name in ROWS])
        figure.subplots_adjust(0.115, 0.115, 0.98, 0.93, wspace=0.09, hspace=0.3)
        # The rows of the clean loops are others: their panel takes the last one's place.
        box = axes[-1].get_position()
        axes[-1].remove()
        lower = figure.add_axes((box.x0 + _LABELS, box.y1 - 0.1, box.width - _LABELS, 0.1))
        finds = result["false_finds"]
        rows = [(key, _clean(finds[name])) for key, name in _CLEAN.items()]
        _panel(lower, "Clean loops, nothing to be found", rows, right=NOTHING)
        lower.set_anchor("N")
        figure.text(box.x0 + 0.01, box.y1 - 0.17, _KEY, fontsize=10.5, va="top", linespacing=1.5)
        figure.suptitle(
            "What was in the loop (rows) and what it was called first (columns), % of the loops",
            x=0.012,
            ha="left",
            fontsize=15,
            fontweight="bold",
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part")
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)


_CLEAN = {"white noise": "clean", "correlated noise": "correlated", "wide steps": "stepped"}


def _clean(found: dict[str, Any]) -> dict[str, int]:
    names: dict[str, int] = dict(found["main_names"])
    nothing = found["fitted"] - sum(names.values())
    return {**names, NOTHING: nothing} if found["fitted"] else {}


def _panel(
    axes: Axes, title: str, rows: list[tuple[str, dict[str, int]]], right: str | None = None
) -> None:
    """A heat map: a row a true effect with its number of loops, a column a name given."""
    shares = np.full((len(rows), len(COLUMNS)), np.nan)
    for row, (name, counts) in enumerate(rows):
        total = sum(counts.values())
        if total:
            shares[row] = [counts.get(column, 0) / total for column in COLUMNS]
        axes.text(len(COLUMNS) - 0.3, row, str(total), va="center", fontsize=8, color=MUTED)
        where = COLUMNS.index(right or EFFECTS[name].identifier)
        axes.add_patch(
            Rectangle((where - 0.5, row - 0.5), 1, 1, fill=False, ec=LIMIT, lw=1.6, zorder=3)
        )
        if not total:
            axes.axhspan(row - 0.5, row + 0.5, fc="white", hatch="///", ec=GRID, zorder=2)
    edges = [np.arange(count + 1) - 0.5 for count in shares.shape]
    axes.pcolormesh(
        edges[1], edges[0], shares, cmap=_COLOURS, vmin=0, vmax=1, ec=GRID, lw=0.5, zorder=1.5
    )
    axes.set_aspect("equal")
    for row, column in np.argwhere(shares > 0):
        share = shares[row, column]
        axes.text(
            column,
            row,
            f"{100 * share:.0f}",
            ha="center",
            va="center",
            fontsize=8,
            zorder=4,
            color="white" if share > _DARK else INK,
        )
    axes.set_title(title, fontsize=11)
    axes.text(len(COLUMNS) - 0.3, -0.9, "loops", fontsize=8, color=MUTED)
    axes.set_xticks(range(len(COLUMNS)), [name.replace("_", " ") for name in COLUMNS])
    axes.tick_params(axis="x", rotation=90, labelsize=8.5, length=0)
    axes.set_yticks(range(len(rows)), [name.replace("_", " ") for name, _ in rows])
    axes.tick_params(axis="y", labelsize=8.5, length=0)
    axes.set_xlim(-0.5, len(COLUMNS) - 0.5)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.grid(False)
    axes.spines[:].set_visible(False)
    axes.axvline(COLUMNS.index(UNKNOWN) - 0.5, color=MUTED, linewidth=0.8, zorder=2)
    if len(rows) > len(LISTED):
        axes.axhline(len(LISTED) - 0.5, color=MUTED, linewidth=0.8, zorder=2)
