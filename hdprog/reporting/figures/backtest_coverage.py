"""How often 50 and 90 % intervals held what came, with the range that so few allow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hdprog.forecast.backtest_pool import FEW, Coverage
from hdprog.reporting.axes import PERCENT
from hdprog.reporting.backtest_words import agrees, range_words, share_words
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.style import FIT, INK, LIMIT, Picture, new_figure, picture
from hdprog.reporting.words import capital, listed


@dataclass(frozen=True)
class CoverageRow:
    """How often intervals held.

    Attributes
    ----------
    name : what was forecast
    coverage : how often they held it
    judged : whether the forecasts are many and independent enough for a judgement
    """

    name: str
    coverage: Coverage
    judged: bool

    @property
    def colour(self) -> str:
        """Colour of the row: another one for a share that is judged wrong."""
        return LIMIT if self.judged and not agrees(self.coverage) else FIT


def coverage(rows: Sequence[CoverageRow]) -> Picture:
    """One row an interval: the share that held, its range and the share that should."""
    height = 0.36 * len(rows) + 0.95
    figure = new_figure(7.6, height)
    axes = figure.add_axes((0.31, 0.55 / height, 0.55, (height - 0.95) / height))
    for at, row in enumerate(rows):
        found, colour = row.coverage, row.colour
        low, high = found.range
        axes.plot([low, high], [at, at], color=colour, linewidth=2.2, alpha=0.7)
        axes.plot(found.share, at, "o", color=colour, markersize=6)
        axes.plot([found.expected] * 2, [at - 0.34, at + 0.34], color=INK, linewidth=2)
        axes.annotate(
            f"{found.held} of {found.count}",
            (1.0, at),
            xycoords=axes.get_yaxis_transform(),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
            fontsize=8.5,
        )
    axes.set_yticks(range(len(rows)), [_label(row) for row in rows])
    axes.set_ylim(len(rows) - 0.45, -0.55)
    axes.set_xlim(0, 1.01)
    axes.xaxis.set_major_formatter(PERCENT)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("share of intervals that held what came")
    axes.set_title(
        "point: counted; bar: 95 % range; upright stroke: should be",
        fontsize=8.5,
        fontweight="normal",
    )
    return picture(
        figure,
        alt=_alt(rows),
        shows=(
            "The point is the share of intervals that held what came, the bar the shares that the"
            " count does not rule out (Clopper-Pearson, 95 %), the upright stroke the share that"
            " should. For crossings that is what the forecasts themselves gave their intervals: a"
            " little more than the name says where an interval runs past what was seen. The bars"
            " take forecasts for independent. Only those of the very next test nearly are; several"
            " forecasts of one crossing, or of one test, say less than their bars. Orange is what"
            " is out of line; those of the next test are judged so, and crossings, where there are"
            f" {FEW} or more."
        ),
        good="every stroke lies on its bar, and the bars are short.",
        bad="a bar left of its stroke: intervals too narrow; right of it: too wide.",
        action="where bars are long, decide nothing by them; add drives or tests.",
        data=_data(rows),
    )


def _data(rows: Sequence[CoverageRow]) -> PictureData:
    columns = ("what", "interval", "held", "forecasts", "share", "low", "high", "should be")
    return PictureData.of(
        "coverage",
        columns,
        [
            (
                row.name,
                found.nominal,
                float(found.held),
                float(found.count),
                found.share,
                *found.range,
                found.expected,
            )
            for row in rows
            for found in [row.coverage]
        ],
    )


def _label(row: CoverageRow) -> str:
    return f"{capital(row.name)}, {share_words(row.coverage.nominal)}"


def _alt(rows: Sequence[CoverageRow]) -> str:
    wide = [row for row in rows if row.coverage.nominal == 0.9]
    parts = [f"{row.name} {range_words(row.coverage)}" for row in wide]
    wrong = [
        f"the {share_words(row.coverage.nominal)} intervals of {row.name}"
        for row in rows
        if row.colour == LIMIT
    ]
    judged = f"; out of line: {listed(wrong)}" if wrong else ""
    return f"The 90 % intervals held: {', '.join(parts)}{judged}."
