"""Coverage, sharpness and transforms in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hdprog.reporting.style import FIT, INK, INSPECT, LIMIT, MUTED, SHUTDOWN, house_style
from tests.benchmarks.prognostics.fleets import KINDS
from tests.benchmarks.prognostics.laws import LAWS
from tests.benchmarks.prognostics.scoring import COVERAGE_AIM, CRPS_AIM
from tests.benchmarks.prognostics.summary import HDPROG, METHODS, ORACLE, summary_of

_SIZE_LOOKS = {3: (FIT, "o"), 6: (LIMIT, "s"), 40: (SHUTDOWN, "^")}
_LAW_LOOKS = ("o", "s", "^", "v", "D", "P")
_LAW_COLOURS = (FIT, LIMIT, SHUTDOWN, INSPECT, INK, MUTED)
_AIM = "#dbe8f2"
Result = dict[str, Any]


def write_picture(results: Sequence[Result], path: Path) -> None:
    """Draw every method's coverage and sharpness, and hdprog's transforms beside the oracle's."""
    with house_style():
        figure = Figure(figsize=(16.0, 9.6), dpi=100)
        upper = figure.add_gridspec(
            1, 2, left=0.125, right=0.985, top=0.9, bottom=0.47, wspace=0.04
        )
        _coverage(figure.add_subplot(upper[0]), results)
        _sharpness(figure.add_subplot(upper[1]), results)
        lower = figure.add_gridspec(
            1, 2 * len(KINDS), left=0.045, right=0.985, top=0.315, bottom=0.07, wspace=0.28
        )
        pairs = [(method, kind.size) for method in (ORACLE, HDPROG) for kind in KINDS]
        for place, (method, size) in enumerate(pairs):
            _transforms(figure.add_subplot(lower[place]), results, method, size)
        _title(
            figure,
            0.98,
            "Remaining life on simulated fleets: hdprog, other packages and an oracle",
            "Left: share of 90 % intervals that hold the truth, with its 95 % range, by units that "
            "were tested before; shaded: the aim. Right: mean CRPS over the oracle's after 3 "
            "units, by law; dotted: the aim.",
        )
        _title(
            figure,
            0.405,
            "Probability integral transforms of the true failure",
            "Bars: share of forecasts in each tenth. Shaded: what a calibrated forecast stays in, "
            "95 % of studies. Leaning to the left: failures come sooner than forecast. A hill: "
            "intervals too wide.",
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part")
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)


def _title(figure: Figure, height: float, title: str, below: str) -> None:
    figure.text(0.012, height, title, fontsize=15, fontweight="bold", va="top")
    figure.text(0.012, height - 0.034, below, fontsize=10.5, va="top")


def _methods(axes: Axes, *, named: bool) -> None:
    places = range(len(METHODS))
    axes.set_yticks(places, list(METHODS) if named else [""] * len(METHODS))
    axes.set_ylim(len(METHODS) - 0.4, -0.6)


def _coverage(axes: Axes, results: Sequence[Result]) -> None:
    axes.axvspan(*COVERAGE_AIM, color=_AIM, lw=0)
    for number, (size, (colour, marker)) in enumerate(_SIZE_LOOKS.items()):
        some = [one for one in results if one["size"] == size]
        for place, method in enumerate(METHODS):
            found = summary_of(some, method)
            if found is None:
                continue
            height = place + 0.22 * (number - 1)
            axes.hlines(height, *found.range_90, color=colour, lw=1.4)
            axes.plot(
                found.held_90,
                height,
                ls="",
                marker=marker,
                ms=5.5,
                color=colour,
                label=f"{size} units" if place == 0 else None,
            )
    axes.set_xlim(0, 1.02)
    axes.set_xlabel("share of 90 % intervals that hold the truth")
    axes.legend(loc="lower left")
    _methods(axes, named=True)


def _sharpness(axes: Axes, results: Sequence[Result]) -> None:
    axes.axvline(CRPS_AIM, color=INK, lw=0.9, ls=":")
    for number, law in enumerate(LAWS):
        some = [one for one in results if one["size"] == 3 and one["law"] == law.name]
        for place, method in enumerate(METHODS):
            found = summary_of(some, method)
            if found is not None:
                axes.plot(
                    found.ratio,
                    place + 0.1 * (number - 2.5),
                    ls="",
                    marker=_LAW_LOOKS[number],
                    ms=5.5,
                    color=_LAW_COLOURS[number],
                    label=law.name if place == 0 else None,
                )
    axes.set_xscale("log")
    ticks = (1, 2, 5, 10, 20, 50)
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.set_xlabel("mean CRPS over the oracle's, 3 units")
    axes.legend(loc="upper right")
    _methods(axes, named=False)


def _transforms(axes: Axes, results: Sequence[Result], method: str, size: int) -> None:
    found = summary_of([one for one in results if one["size"] == size], method)
    axes.set_title(f"{method}, {size} units")
    if found is None:
        return
    counts = found.histogram.counts
    edges = np.linspace(0.0, 1.0, counts.size + 1)
    axes.axhspan(
        found.histogram.low / found.units, found.histogram.high / found.units, color=_AIM, lw=0
    )
    colour = MUTED if method == ORACLE else FIT
    axes.stairs(counts / found.units, edges, fill=True, color=colour, alpha=0.6)
    axes.set(xlim=(0, 1), ylim=(0, 0.42))
    axes.set_xticks((0, 0.5, 1), ("0", "0.5", "1"))
    axes.tick_params(labelleft=size == KINDS[0].size)
