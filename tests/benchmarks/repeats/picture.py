"""Intervals of repeats side by side, and how often they agree, in one picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hdprog.reporting.style import FIT, GRID, INK, LIMIT, MUTED, house_style
from tests.benchmarks.repeats import DRIVE, LEVELS, MODELS, NOISES, WHITE, WIDENED, Fit
from tests.benchmarks.repeats.agreement import LEVEL
from tests.benchmarks.repeats.records import LARGE, SMALL, SPRING
from tests.benchmarks.repeats.summary import DIRECT, SIMULATED, chosen, label

_SHOWN = (
    ("hysteresis_width_arcmin", 0.75),
    ("hysteresis_loss_J", 0.75),
    ("lost_motion_arcmin", 1.10),
    ("secant_stiffness_Nm_per_rad", 0.60),
    ("K1_Nm_per_rad", 0.60),
)
_KINDS = (SPRING, LARGE, SMALL)
_COLOURS = {WIDENED: FIT, WHITE: LIMIT}
_WIDTHS = {WIDENED: 4.2, WHITE: 1.8}
_SHIFT = {WIDENED: -0.17, WHITE: 0.17}


def write_picture(fits: Sequence[Fit], result: Mapping[str, Any], path: Path) -> None:
    """Draw 90 % intervals of every repeat, and the shares that agree or hold the truth."""
    with house_style():
        figure = Figure(figsize=(18.0, 20.0), dpi=90)
        grid = figure.add_gridspec(
            len(_SHOWN), 2, left=0.055, right=0.99, top=0.925, bottom=0.29, hspace=0.16, wspace=0.06
        )
        for row, (quantity, reach) in enumerate(_SHOWN):
            for column, model in enumerate(MODELS):
                axes = figure.add_subplot(grid[row, column])
                _intervals(axes, fits, model, quantity, reach, last=row == len(_SHOWN) - 1)
                if row == 0:
                    axes.set_title(f"Fitted: {model}", fontsize=12)
                if column == 0:
                    axes.set_ylabel(label(quantity))
        lower = figure.add_gridspec(1, 3, left=0.17, right=0.99, top=0.185, bottom=0.03, wspace=0.1)
        _shares(figure, lower, result)
        figure.text(
            0.012, 0.988, "Repeated cycles, each fitted by itself: do their intervals agree?",
            fontsize=16, fontweight="bold", va="top",
        )  # fmt: skip
        figure.text(
            0.012,
            0.970,
            f"{LEVEL:.0%} intervals with their median, relative to what is read off the record of "
            "the state (stiffness: to the mean of its widened medians). Repeats of a state stand "
            "side by side between the grey lines.\nArrow: median outside the panel.",
            fontsize=10.5,
            va="top",
        )
        figure.legend(
            handles=_legend(), loc="upper right", bbox_to_anchor=(0.99, 0.992), ncols=3, fontsize=10
        )
        figure.text(
            0.012, 0.232, "How often", fontsize=16, fontweight="bold", va="top"
        )  # fmt: skip
        figure.text(
            0.012,
            0.216,
            "Dots: share, with its 95 % range by resampling whole states. Black line: what right "
            "intervals reach. An error of the model that repeats share does not part them: "
            "agreement (left) can be had with intervals that miss the reading (middle).",
            fontsize=10.5,
            va="top",
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part")
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)


def _legend() -> list[Line2D]:
    shown = [
        Line2D([], [], color=_COLOURS[noise], lw=_WIDTHS[noise], marker="o", ms=4, label=words)
        for noise, words in ((WIDENED, "noise as found (widened)"), (WHITE, "forced to white"))
    ]
    read = Line2D([], [], color=INK, ls="", marker="_", ms=13, mew=1.8, label="read off the record")
    return [*shown, read]


def _intervals(
    axes: Axes, fits: Sequence[Fit], model: str, quantity: str, reach: float, *, last: bool
) -> None:
    place, ticks, names = 0.0, [], []
    axes.axhline(0, color=INK, lw=0.8, zorder=1)
    for kind in _KINDS:
        both = {noise: chosen(fits, kind, model, noise) for noise in NOISES}
        too_small = kind == SMALL and quantity == "lost_motion_arcmin"  # to be read off
        for name, repeats in both[WIDENED].items():
            start = place
            centre = _centre(repeats, quantity)
            for cycle, one in enumerate(repeats):
                for noise in () if too_small else NOISES:
                    fit = one if noise == WIDENED else both[WHITE][name][cycle]
                    _interval(axes, place + _SHIFT[noise], fit, quantity, centre, reach)
                if quantity in one.direct and not too_small:
                    read = one.direct[quantity] / centre - 1
                    axes.plot([place - 0.36, place + 0.36], [read] * 2, color=INK, lw=1.8, zorder=5)
                place += 1.0
            axes.axvline(place - 0.5, color=GRID if place else MUTED, lw=1.6, zorder=0)
            ticks.append(0.5 * (start + place - 1))
            names.append(_state(name))
        if both[WIDENED]:
            axes.axvline(place - 0.5, color=MUTED, lw=1.2, zorder=0)
    axes.set(xlim=(-0.5, max(place, 1.0) - 0.5), ylim=(-reach, reach))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:+.0%}")
    axes.grid(axis="x", visible=False)
    axes.set_xticks(ticks, names if last else [""] * len(names), fontsize=8, rotation=90)
    axes.tick_params(axis="x", length=0)


def _state(name: str) -> str:
    kind, state = name.split(": ")
    return f"{state.replace('_', ' ')}, {kind.split()[0]}"


def _natural(quantity: str, values: Any) -> Any:
    """Stiffnesses are kept in logs."""
    return np.exp(values) if quantity.endswith("Nm_per_rad") else values


def _centre(repeats: Sequence[Fit], quantity: str) -> float:
    if quantity in DIRECT:
        read = [one.direct[quantity] for one in repeats if quantity in one.direct]
        if read:
            return float(np.mean(read))
    middle = len(LEVELS) // 2
    return float(
        np.mean([_natural(quantity, np.array(one.quantiles[quantity][middle])) for one in repeats])
    )


def _interval(axes: Axes, at: float, fit: Fit, quantity: str, centre: float, reach: float) -> None:
    quantiles = np.array(fit.quantiles[quantity])
    tail = (1 - LEVEL) / 2
    low, middle, high = np.interp((tail, 0.5, 1 - tail), LEVELS, quantiles)
    low, middle, high = (_natural(quantity, value) / centre - 1 for value in (low, middle, high))
    colour = _COLOURS[fit.noise]
    axes.vlines(at, low, high, color=colour, lw=_WIDTHS[fit.noise], alpha=0.75, zorder=3)
    if abs(middle) <= reach:
        axes.plot(
            at, middle, ls="", marker="o", ms=3.6, color=colour, mec="white", mew=0.5, zorder=4
        )
    else:
        edge = np.sign(middle) * 0.95 * reach
        marker = "^" if middle > 0 else "v"
        axes.plot(at, edge, ls="", marker=marker, ms=5, color=colour, zorder=4)


def _shares(figure: Figure, grid: Any, result: Mapping[str, Any]) -> None:
    rows = [
        (kind, model)
        for kind in (*_KINDS, *SIMULATED)
        for model in MODELS
        if f"{kind}, {model}, {WIDENED}" in result["repeats"]
    ]
    names = [
        kind if kind in SIMULATED else f"{kind}, {'drive alone' if model == DRIVE else 'explained'}"
        for kind, model in rows
    ]
    titles = (
        "Repeats agree (seven figures)",
        "Interval holds what is read off (width, loss, lost motion)",
        "Interval holds the truth (seven figures)",
    )
    for column, title in enumerate(titles):
        axes = figure.add_subplot(grid[0, column])
        axes.axvline(LEVEL, color=INK, lw=0.9)
        for place, (kind, model) in enumerate(rows):
            for noise in NOISES:
                one = _share(result, column, kind, model, noise)
                if one is None:
                    continue
                at = place + 0.6 * _SHIFT[noise]
                if "interval_95" in one:
                    axes.hlines(
                        at, *one["interval_95"], color=_COLOURS[noise], lw=_WIDTHS[noise] / 2
                    )
                axes.plot(one["share"], at, ls="", marker="o", ms=6, color=_COLOURS[noise])
        axes.set_yticks(range(len(rows)), names if column == 0 else [""] * len(rows))
        axes.set(xlim=(-0.02, 1.02), ylim=(len(rows) - 0.4, -0.6))
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        axes.set_title(title)


def _share(
    result: Mapping[str, Any], column: int, kind: str, model: str, noise: str
) -> Mapping[str, Any] | None:
    if column == 2:
        found = result["truth"].get(f"{kind}, {noise}")
        return None if found is None else found["coverage_90_figures"]
    one = result["repeats"].get(f"{kind}, {model}, {noise}")
    if one is None:
        return None
    if column == 0:
        return dict(one["figures"]["agree"])
    read = [value for value in one["direct"].values() if value is not None]
    if not read:
        return None
    return {"share": float(np.mean([value["share"] for value in read]))}
