"""Where the truth fell in its forecasts: histograms of the probability integral transform."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hdprog.forecast.backtest_pool import FEW, bins_for
from hdprog.forecast.scores import TransformHistogram, transform_histogram
from hdprog.reporting.axes import PERCENT
from hdprog.reporting.picture_data import Cell, PictureData
from hdprog.reporting.style import FIT, INK, LIMIT, MUTED, Picture, new_figure, picture
from hdprog.reporting.words import agree, capital, counted, listed


def transforms(crossings: Sequence[float], next_tests: Sequence[float], distinct: int) -> Picture:
    """Histograms of crossings and of the very next tests' figures, with their bands.

    Parameters
    ----------
    crossings, next_tests : transforms
    distinct : crossings that were forecast, from however many tests
    """
    figure = new_figure(7.6, 3.1)
    titled = [
        (name, values)
        for name, values in (
            ("crossings of limits", crossings),
            ("figures at the next test", next_tests),
        )
        if values
    ]
    findings, rows = [], []
    for index, (name, values) in enumerate(titled):
        axes = figure.add_axes((0.085 + 0.49 * index, 0.19, 0.39, 0.66))
        found = transform_histogram(values, bins_for(len(values)))
        _draw(axes, found, len(values))
        axes.set_title(f"{capital(name)} ({len(values)})")
        only = f" ({distinct} only)" if values is crossings and distinct < FEW else ""
        findings.append(f"{name}{only}: {_finding(found, len(values))}")
        rows += _rows(name, found)
    return picture(
        figure,
        alt=f"{capital('; '.join(findings))}.",
        shows=(
            "Each forecast gives a probability of all that lies below what came; the bars count"
            " how often it fell into each part from 0 to 100 %. The band is where all bars of one"
            " histogram lie together in 95 of 100 cases if the forecasts are honest and"
            " independent (simultaneous, by Bonferroni); the broken line is their height if all"
            " were alike. Forecasts of one crossing from many tests are not independent: the left"
            " band is then too narrow."
        ),
        good="bars of about equal height, all within the band.",
        bad=(
            "high bars at both ends: intervals too narrow; in the middle: too wide; at the right"
            " end: what came, came later or higher than forecast; at the left end: the contrary."
        ),
        action="one bar outside is a hint, not a proof; score more drives before acting on it.",
        data=PictureData.of(
            "where-what-came-fell", ("what", "from", "to", "forecasts", "low", "high"), rows
        ),
    )


def _rows(name: str, found: TransformHistogram) -> list[tuple[Cell, ...]]:
    """Bars of a histogram and the ends of its band."""
    bins, low, high = found.counts.size, float(found.low), float(found.high)
    return [
        (name, at / bins, (at + 1) / bins, float(count), low, high)
        for at, count in enumerate(found.counts)
    ]


def _draw(axes: Axes, found: TransformHistogram, count: int) -> None:
    bins = found.counts.size
    left = [index / bins for index in range(bins)]
    inside = (found.counts >= found.low) & (found.counts <= found.high)
    axes.axhspan(found.low, found.high, color=MUTED, alpha=0.18, linewidth=0, label="95 % band")
    axes.axhline(count / bins, color=INK, linestyle=(0, (4, 2)), linewidth=1.0)
    axes.bar(
        left,
        found.counts,
        width=1 / bins,
        align="edge",
        color=[FIT if good else LIMIT for good in inside],
        alpha=0.6,
        edgecolor="white",
    )
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1.12 * max(found.high, int(found.counts.max())))
    axes.xaxis.set_major_formatter(PERCENT)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.set_xlabel("forecast probability below what came")
    axes.set_ylabel("forecasts")
    axes.legend(loc="upper right")


def _finding(found: TransformHistogram, count: int) -> str:
    of = f"of {counted(count, 'forecast')}"
    if found.inside:
        return f"{of} all bars lie in the band"
    bins = found.counts.size
    out = [
        f"from {100 * index / bins:.0f} to {100 * (index + 1) / bins:.0f} %"
        for index, here in enumerate(found.counts)
        if not found.low <= here <= found.high
    ]
    bars = f"{agree(len(out), 'the bar', 'the bars')} {listed(out)}"
    return f"{of} {bars} {agree(len(out), 'lies', 'lie')} outside the band"
