"""Marginals of the coordinates with the plainest modes: the reference against hdprog."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hdprog.reporting.style import FIT, INK, LIMIT, MUTED, house_style

_COLUMNS = 4
_PANELS = 12


def write_picture(results: Sequence[dict[str, Any]], path: Path) -> None:
    """Draw the marginals of the cases, those with the deepest valleys first.

    Parameters
    ----------
    results : of the cases
    path : of the PNG file
    """
    panels = [
        (one, at, histogram)
        for one in results
        for at, histogram in enumerate(one["histograms"])
        if at < max(1, len(one["separators"]))
    ]
    panels = sorted(panels, key=lambda panel: (panel[1] > 0, _depth(panel[0], panel[1])))[:_PANELS]
    rows = -(-len(panels) // _COLUMNS)
    with house_style():
        figure = Figure(figsize=(16.0, 1.6 + 3.3 * rows), dpi=100)
        top = 1 - 1.35 / (1.6 + 3.3 * rows)
        grid = figure.add_gridspec(
            rows, _COLUMNS, left=0.03, right=0.985, top=top, bottom=0.07, hspace=0.5, wspace=0.12
        )
        for place, (one, at, histogram) in enumerate(panels):
            _marginal(figure.add_subplot(grid[divmod(place, _COLUMNS)]), one, at, histogram)
        figure.text(
            0.012,
            0.985,
            "Does hdprog's sampler miss a mode? Marginals of hard loops",
            fontsize=15,
            fontweight="bold",
            va="top",
        )
        figure.text(
            0.012,
            0.985 - 0.37 / (1.6 + 3.3 * rows),
            "Grey area: reference, populations led from the prior. Black dots: nested sampling. "
            "Blue line: long run of hdprog. Thin orange lines: runs of the full plan, as a user "
            "gets them.\nDotted: the cut between modes, with the mass above it. In brackets: what "
            "hdprog says itself of its runs.",
            fontsize=10.5,
            va="top",
            linespacing=1.5,
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part")
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)


def _depth(one: dict[str, Any], at: int) -> float:
    """Of the valley that a panel shows; cases without one come last."""
    if at >= len(one["separators"]):
        return 2.0
    depth = one["separators"][at]["depth"]
    return 1.0 if depth is None else float(depth)


def _marginal(axes: Axes, one: dict[str, Any], at: int, histogram: dict[str, Any]) -> None:
    edges = np.array(histogram["edges"])
    middle = 0.5 * (edges[1:] + edges[:-1])
    axes.stairs(histogram["reference"], edges, fill=True, color="#d4d8de", zorder=1)
    for density in histogram["full"]:
        axes.stairs(density, edges, color=LIMIT, lw=0.6, alpha=0.75, baseline=None, zorder=2)
    axes.stairs(histogram["long"], edges, color=FIT, lw=1.6, baseline=None, zorder=3)
    axes.plot(middle, histogram["nested"], ls="", marker=".", ms=3.5, color=INK, zorder=4)
    full = one["runs"]["full"]
    said = sum(run["converged"] for run in full)
    long = one["runs"]["long"][0]
    axes.set_title(one["name"].replace("-", " "), fontsize=10)
    words = f"long run {'converged' if long['converged'] else 'not converged'}, "
    words += f"full plan {said} of {len(full)} converged"
    axes.set_xlabel(f"{histogram['coordinate']}\n[{words}]", fontsize=9)
    axes.set_yticks([])
    axes.set_ylim(0, 1.35 * max(histogram["reference"]))
    axes.set_xlim(edges[0], edges[-1])
    if at < len(one["separators"]):
        axes.axvline(one["separators"][at]["cut"], color=MUTED, lw=1.0, ls=":", zorder=5)
        masses = (
            f"above the cut\nreference {one['reference']['modes'][at]:.1%}"
            f"\nlong {long['modes'][at]:.1%}"
            f"\nfull {min(run['modes'][at] for run in full):.1%}"
            f" to {max(run['modes'][at] for run in full):.1%}"
        )
        left = np.argmax(histogram["reference"]) > len(middle) / 2
        axes.text(
            0.02 if left else 0.98,
            0.97,
            masses,
            transform=axes.transAxes,
            ha="left" if left else "right",
            va="top",
            fontsize=8.5,
        )
