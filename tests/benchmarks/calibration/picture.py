"""Ranks, coverage and planted faults in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hdprog.reporting.style import FIT, GRID, INK, LIMIT, MUTED, house_style
from tests.benchmarks.calibration import Outcome
from tests.benchmarks.calibration.ecdf_band import uniformity
from tests.benchmarks.calibration.faults import NARROW
from tests.benchmarks.calibration.ranks import HIGHEST, QUANTITIES
from tests.benchmarks.calibration.summary import CONTROL, POWER_LOOPS, RATE, ranks_of

_COLUMNS = 7
_NEEDED = 0.95


def write_picture(outcomes: Sequence[Outcome], result: dict[str, Any], path: Path) -> None:
    """Draw the deviation of every quantity's ranks, the coverage, and what was caught."""
    fitted = [one for one in outcomes if one.status == "fitted"]
    rows = -(-len(QUANTITIES) // _COLUMNS)
    with house_style():
        figure = Figure(figsize=(17.0, 15.5), dpi=100)
        grid = figure.add_gridspec(
            rows, _COLUMNS, left=0.045, right=0.99, top=0.915, bottom=0.5, hspace=0.42, wspace=0.12
        )
        panels = [figure.add_subplot(grid[divmod(at, _COLUMNS)]) for at in range(len(QUANTITIES))]
        _ranks(panels, fitted, result)
        lower = figure.add_gridspec(
            1, 2, left=0.135, right=0.69, top=0.41, bottom=0.055, wspace=0.06
        )
        for place, level in enumerate(result["coverage"]):
            axes = figure.add_subplot(lower[place])
            _coverage(axes, result["coverage"][level], float(level), named=place == 0)
        _faults(figure.add_axes((0.815, 0.055, 0.145, 0.355)), result["faults"])
        _title(
            figure,
            0.985,
            f"Ranks of the truth among posterior draws, {result['fitted']} loops: ECDF minus "
            "uniform",
            "Blue line: the posterior as it is. Dark band: what uniform ranks of one quantity stay "
            f"in, {1 - RATE:.0%} of studies; with the light one: of all {len(QUANTITIES)} together."
            f" Dashed orange: the same loops with a planted fault, {NARROW}.",
        )
        _title(
            figure,
            0.462,
            "Coverage of central intervals, and planted faults",
            "Dots: share of all loops whose interval holds the truth, with its 95 % range; ticks: "
            f"each kind of loop. Bars: how often {POWER_LOOPS} loops notice a fault, by bootstrap.",
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part")
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)


def _title(figure: Figure, height: float, title: str, below: str) -> None:
    figure.text(0.012, height, title, fontsize=15, fontweight="bold", va="top")
    figure.text(0.012, height - 0.022, below, fontsize=10.5, va="top")


def _ranks(panels: Sequence[Axes], fitted: Sequence[Outcome], result: dict[str, Any]) -> None:
    test = uniformity(len(fitted), HIGHEST)
    right, narrow = ranks_of(fitted), ranks_of(fitted, NARROW)
    bands = [test.band(rate) for rate in (RATE / len(QUANTITIES), RATE)]
    shares = np.concatenate([[0.0], test.shares, [1.0]])

    def deviation(ecdf: np.ndarray) -> np.ndarray:
        return np.concatenate([[0.0], ecdf - test.shares, [0.0]])

    curves = [
        [deviation(test.counts(ranks[:, at]) / len(fitted)) for ranks in (right, narrow)]
        for at in range(len(QUANTITIES))
    ]
    reach = 1.1 * max(np.abs(curves).max(), np.abs(deviation(bands[0][1])).max())
    for at, axes in enumerate(panels):
        for (least, largest), colour in zip(bands, ("#dbe8f2", "#b7d0e4"), strict=True):
            axes.fill_between(shares, deviation(least), deviation(largest), color=colour, lw=0)
        axes.plot(shares, curves[at][1], color=LIMIT, lw=1.1, ls=(0, (4, 2)))
        axes.plot(shares, curves[at][0], color=FIT, lw=1.5)
        tested = result["uniform"]["all"][QUANTITIES[at]]
        axes.set_title(_label(QUANTITIES[at]), fontsize=9.5)
        axes.text(
            0.98, 0.04, f"p {tested['p']:.2g}", transform=axes.transAxes, ha="right", fontsize=9
        )
        axes.set(xlim=(0, 1), ylim=(-reach, reach))
        axes.set_xticks((0, 0.5, 1), ("0", "0.5", "1"))
        axes.tick_params(labelleft=at % _COLUMNS == 0, labelbottom=at >= len(panels) - _COLUMNS)
        if at % _COLUMNS == 0:
            axes.set_ylabel("ECDF − uniform")
        if at >= len(panels) - _COLUMNS:
            axes.set_xlabel("rank / number of draws")


def _label(quantity: str) -> str:
    name, _, at = quantity.partition("@")
    for unit in ("_arcmin", "_J", "_Nm_per_rad", "_Nm"):
        name = name.removesuffix(unit)
    name = name if len(name) < 4 else name.replace("_", " ")
    return name + (f" at {at.removesuffix('Nm')} Nm" if at else "")


def _coverage(axes: Axes, by: dict[str, Any], level: float, *, named: bool) -> None:
    places = np.arange(len(QUANTITIES))
    axes.axvline(level, color=INK, lw=0.9, zorder=1)
    for kind, found in by.items():
        shares = np.array([found[name]["share"] for name in QUANTITIES])
        if kind != "all":
            axes.plot(shares, places, ls="", marker="|", ms=7, color=MUTED, mew=0.9, zorder=2)
            continue
        low, high = np.array([found[name]["interval_95"] for name in QUANTITIES]).T
        axes.hlines(places, low, high, color=FIT, lw=2.2, zorder=3)
        axes.plot(shares, places, ls="", marker="o", ms=4.5, color=FIT, zorder=4)
    labels = [_label(name) for name in QUANTITIES] if named else [""] * len(QUANTITIES)
    axes.set_yticks(places, labels)
    axes.set_ylim(len(QUANTITIES) - 0.4, -0.6)
    axes.set_title(f"Central {level:.0%} intervals")
    axes.set_xlabel("share of loops that hold the truth")


def _faults(axes: Axes, faults: dict[str, Any]) -> None:
    names = list(faults)
    for place, name in enumerate(names):
        share = faults[name]["power"]
        axes.barh(place, share, 0.6, color=MUTED if name == CONTROL else LIMIT)
        axes.text(1.03, place, f"{share:.1%}", fontsize=9, va="center")
    axes.axvline(_NEEDED, color=INK, lw=0.9, ls=":")
    axes.set_yticks(
        range(len(names)),
        [f"{'no fault' if n == CONTROL else n}\n({faults[n]['loops']} loops)" for n in names],
        fontsize=8.5,
    )
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xlim(0, 1)
    axes.grid(axis="y", color=GRID, lw=0)
    axes.set_title("Faults noticed")
    axes.set_xlabel("share of studies that notice it")
