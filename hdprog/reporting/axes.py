"""Marks that several pictures share: hour axes and labelled vertical lines that do not collide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from hdprog.reporting.rounding import THIN_SPACE
from hdprog.reporting.style import INK

THOUSANDS = FuncFormatter(
    lambda value, _: f"{value:,.10g}".replace(",", THIN_SPACE).replace("-", "\u2212")
)
"""Tick labels with thin spaces between thousands."""
PERCENT = FuncFormatter(lambda value, _: f"{100 * value:.0f}{THIN_SPACE}%")
"""Tick labels of probabilities."""

_LETTER_WIDTH = 0.0685  # inches a letter at 8.5 points, DejaVu Sans, on average
_ROW_HEIGHT = 0.17  # inches


@dataclass(frozen=True)
class Event:
    """A moment to mark on an hour axis.

    Attributes
    ----------
    hours : service hours
    label : a few words
    colour, line : colour and Matplotlib line style
    """

    hours: float
    label: str
    colour: str = INK
    line: str = "-"


@dataclass(frozen=True)
class _Label:
    event: Event
    left: float  # inches from the axes' left edge
    row: int

    @property
    def middle(self) -> float:
        return self.left + len(self.event.label) * _LETTER_WIDTH / 2


def hour_axis(axes: Axes, first: float, last: float) -> None:
    """Make x an axis of service hours from first to last."""
    axes.set_xlim(first, last)
    axes.set_xlabel("service hours")
    axes.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    axes.xaxis.set_major_formatter(THOUSANDS)


def mark_events(axes: Axes, events: Sequence[Event]) -> None:
    """Draw vertical lines and their labels above the axes, in rows so that none overlaps.

    The axes are made as high as the rows of labels leave room in the figure. Events outside the
    axis are left out. The axes' x limits must have been set.
    """
    figure = axes.get_figure()
    if figure is None:
        raise ValueError("the axes belong to no figure")
    wide, high = figure.get_figure(root=True).get_size_inches()
    place = axes.get_position()
    labels = _arrange(axes.get_xlim(), place.width * wide, events)
    rows = 1 + max((label.row for label in labels), default=0)
    height = high * (1.0 - place.y0) - 0.12 - rows * _ROW_HEIGHT
    axes.set_position((place.x0, place.y0, place.width, height / high))
    for label in labels:
        event, top = label.event, 1.0 + (0.04 + label.row * _ROW_HEIGHT) / height
        axes.plot(
            [event.hours, event.hours],
            [0.0, top],
            transform=axes.get_xaxis_transform(),
            color=event.colour,
            linestyle=event.line,
            linewidth=1.2,
            clip_on=False,
            zorder=2.5,
        )
        axes.text(
            label.middle / (place.width * wide),
            top,
            event.label,
            transform=axes.transAxes,
            ha="center",
            va="bottom",
            color=event.colour,
            fontsize=8.5,
            parse_math=False,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
            zorder=3,
        )


def _arrange(limits: tuple[float, float], width: float, events: Sequence[Event]) -> list[_Label]:
    """Give each event inside the limits a place on an axis of a width in inches."""
    first, last = limits
    ends: list[float] = []  # right end of the last label of each row
    labels = []
    for event in sorted(events, key=lambda e: e.hours):
        if not first <= event.hours <= last:
            continue
        at = (event.hours - first) / (last - first) * width
        length = len(event.label) * _LETTER_WIDTH
        left = min(max(at - length / 2, 0.0), max(width - length, 0.0))
        row = next((i for i, end in enumerate(ends) if end + 0.12 < left), len(ends))
        ends[row : row + 1] = [left + length]
        labels.append(_Label(event, left, row))
    return labels
