"""Time and work of all samplers, and the likelihood beside a fused loop, in one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hdprog.reporting.style import FIT, GRID, INK, LIMIT, MUTED, house_style
from tests.benchmarks.samplers.summary import OWN, PER_THOUSAND, TIMES_FUSED


def write_picture(result: dict[str, Any], path: Path) -> None:
    """Draw every measurement as a dot and the medians as bars."""
    many = len(result["posteriors"])
    with house_style():
        figure = Figure(figsize=(13.5, 5.6), dpi=100)
        widths = (1.25, 1.0, 0.75) if result["fused"] else (1.25, 1.0)
        grid = figure.add_gridspec(
            1,
            len(widths),
            width_ratios=widths,
            left=0.135,
            right=0.985,
            top=0.76,
            bottom=0.105,
            wspace=0.14,
        )
        _seconds(figure.add_subplot(grid[0]), result["samplers"])
        _work(figure.add_subplot(grid[1]), result["samplers"])
        if result["fused"]:
            _fused(figure.add_subplot(grid[2]), result["fused"]["times"])
        figure.text(
            0.012,
            0.975,
            f"Samplers on {many} posteriors of loops, nine coordinates each, on one core",
            fontsize=15,
            fontweight="bold",
            va="top",
        )
        figure.text(
            0.012,
            0.915,
            "Dots: posteriors; open: stopped at the bound before 1 000 effective draws. Bars: "
            "medians. Left: dark bar and dots without compilation, light bar with it;\nhdprog's "
            "with the preparation of the record. Work: the worst coordinate, warm-up included.",
            fontsize=10.5,
            va="top",
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part")
        figure.savefig(aside, format="png", metadata={"Software": None})
        aside.replace(path)


def _seconds(axes: Axes, samplers: dict[str, list[dict[str, Any]]]) -> None:
    least = min(one["processor"]["run"] for figures in samplers.values() for one in figures)
    left = least / 1.6
    for place, (name, figures) in enumerate(samplers.items()):
        key = "all" if name == OWN else "run"
        whole = float(np.median([one["processor"]["all"] for one in figures]))
        run = float(np.median([one["processor"][key] for one in figures]))
        colour = _colour(name)
        axes.barh(place, whole - left, 0.62, left=left, color=colour, alpha=0.25)
        axes.barh(place, run - left, 0.62, left=left, color=colour, alpha=0.55)
        axes.text(whole * 1.05, place - 0.36, f"{whole:.3g} s", fontsize=9, va="center")
        _dots(axes, place, [one["processor"][key] for one in figures], figures, colour)
    axes.set_xscale("log")
    axes.set_xlim(left, None)
    axes.set_title("Processor seconds until 1 000 effective draws")
    axes.set_xlabel("seconds")
    _names(axes, list(samplers))


def _work(axes: Axes, samplers: dict[str, list[dict[str, Any]]]) -> None:
    every = [one["per_thousand"] for figures in samplers.values() for one in figures]
    left = min(value for value in every if value > 0) / 1.6
    for place, (name, figures) in enumerate(samplers.items()):
        values = [one["per_thousand"] for one in figures if one["per_thousand"] > 0]
        shown = [one for one in figures if one["per_thousand"] > 0]
        if values:
            middle = float(np.median(values))
            axes.barh(place, middle - left, 0.62, left=left, color=_colour(name), alpha=0.55)
            _dots(axes, place, values, shown, _colour(name))
    axes.axvline(PER_THOUSAND, color=INK, lw=0.9, ls=":")
    axes.text(PER_THOUSAND, -0.62, f"aim {PER_THOUSAND:g}", fontsize=9, ha="center")
    axes.set_xscale("log")
    axes.set_xlim(left, None)
    axes.set_title("Effective draws per 1 000 evaluations", pad=12)
    axes.set_xlabel("effective draws (a gradient is one evaluation)")
    _names(axes, [""] * len(samplers))


def _fused(axes: Axes, times: list[dict[str, Any]]) -> None:
    lines = sorted({(one["averaged"], one["batch"]) for one in times})
    for averaged, batch in lines:
        of = [one for one in times if (one["averaged"], one["batch"]) == (averaged, batch)]
        axes.plot(
            [one["blocks"] for one in of],
            [one["ratio"] for one in of],
            color=LIMIT if averaged else FIT,
            ls="-" if batch == max(b for _, b in lines) else (0, (4, 2)),
            marker="o",
            ms=4,
            label=f"{'averages' if averaged else 'readings'}, batch {batch}",
        )
    axes.axhline(TIMES_FUSED, color=INK, lw=0.9, ls=":")
    axes.set_ylim(0, None)
    axes.set_title("Likelihood: hdprog / fused loop", pad=12)
    axes.set_xlabel("blocks")
    axes.legend(fontsize=8.5, loc="lower left")


def _dots(
    axes: Axes,
    place: int,
    values: list[float],
    figures: list[dict[str, Any]],
    colour: str,
) -> None:
    heights = place + np.linspace(-0.22, 0.22, len(values))
    faces = [colour if one["reached"] else "white" for one in figures]
    axes.scatter(values, heights, s=20, c=faces, edgecolors=colour, linewidths=1.0, zorder=3)


def _names(axes: Axes, names: list[str]) -> None:
    axes.set_yticks(range(len(names)), [name.replace(", ", ",\n") for name in names])
    axes.set_ylim(len(names) - 0.45, -0.75)
    axes.grid(axis="y", color=GRID, lw=0)


def _colour(name: str) -> str:
    return FIT if name == OWN else MUTED
