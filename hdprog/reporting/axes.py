"""Axes that pictures share: room for tick labels, hours, labelled lines that do not collide."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.ticker import FuncFormatter, MaxNLocator

from hdprog.reporting.rounding import MINUS, THIN_SPACE
from hdprog.reporting.style import INK


def _tick(value: float, _: object = None) -> str:
    text = f"{value:,.10g}"
    if "e" in text and abs(value) < 1.0:  # angles in rad: one axis in one way of writing
        text = f"{value:.12f}".rstrip("0").rstrip(".")
    return text.replace(",", THIN_SPACE).replace("-", MINUS)


THOUSANDS = FuncFormatter(_tick)
"""Tick labels with thin spaces between thousands."""
PERCENT = FuncFormatter(lambda value, _: f"{100 * value:.0f}{THIN_SPACE}%")
"""Tick labels of probabilities."""

_TICK = 7.0 / 72.0  # inches: a tick and the gap to its label, at their default lengths
_GAP = 0.11  # inches between tick labels and the label of the axis
_LABEL_HEIGHT = 0.16  # inches of a line of text, turned upright
_EDGE = 0.04  # inches left free at the edge of the figure
_USUAL_LEFT = 0.72  # inches; pictures with short labels line up below each other
_LETTER_WIDTH = 0.0685  # inches a letter at 8.5 points, DejaVu Sans, on average
_ROW_HEIGHT = 0.17  # inches
_MOST_ROWS = 4  # of labels above the axes
_APART = 0.12  # inches from one label to the next of a row
_BESIDE = 0.03  # inches from a label to the line of another event
_BETWEEN = 0.06  # inches between tick labels beside each other, at the least


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
    row: int | None  # above the axes; None without a label

    @property
    def middle(self) -> float:
        return self.left + len(self.event.label) * _LETTER_WIDTH / 2

    @property
    def right(self) -> float:
        return self.left + len(self.event.label) * _LETTER_WIDTH

    def covers(self, line: float) -> bool:
        """Whether an upright line at these inches would touch the label."""
        return self.left - _BESIDE < line < self.right + _BESIDE


def room_on_the_left(strips: Sequence[Axes]) -> float:
    """Part of the figure's width that the tick labels and the label of y axes take up.

    Limits, locators and formatters of the axes must have been set.
    """
    needed = _widest_label(strips) + _TICK + _GAP + _LABEL_HEIGHT + _EDGE
    return max(_USUAL_LEFT, needed) / _wide(strips[0])


def align_left(strips: Sequence[Axes]) -> None:
    """Move the left edges of axes that stand above each other to where their y labels have room.

    The right edges stay. The labels of the y axes are put on one line.
    """
    left = room_on_the_left(strips)
    for axes in strips:
        place = axes.get_position()
        axes.set_position((left, place.y0, place.x1 - left, place.height))
    put_y_labels(strips)


def put_y_labels(strips: Sequence[Axes]) -> None:
    """Put the labels of y axes whose left edges are in line beside the widest tick label."""
    away = _widest_label(strips) + _TICK + _GAP
    for axes in strips:
        figure = axes.get_figure(root=True)
        place = axes.get_position()
        at = place.x0 - away / _wide(axes)
        axes.yaxis.label.set_verticalalignment("bottom")
        axes.yaxis.set_label_coords(
            at, (place.y0 + place.y1) / 2, transform=None if figure is None else figure.transFigure
        )


def title_that_fits(axes: Axes, title: str, shorter: str) -> None:
    """Set the title of axes, or a shorter one where it would run over their right edge."""
    font = FontProperties(
        size=mpl.rcParams["axes.titlesize"], weight=mpl.rcParams["axes.titleweight"]
    )
    room = axes.get_position().width * _wide(axes)
    axes.set_title(title if _text_width(title, font) <= room else shorter)


def _text_width(text: str, font: FontProperties) -> float:
    """Width of a text in inches."""
    # As it is set, which takes a twentieth of the time of drawing its outlines.
    return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0]) / 72.0


def _wide(axes: Axes) -> float:
    """Width of the figure in inches."""
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("the axes belong to no figure")
    return float(figure.get_size_inches()[0])


def _widest_label(strips: Sequence[Axes]) -> float:
    """Width in inches of the longest tick label of y axes."""
    font = FontProperties(size=mpl.rcParams["ytick.labelsize"])
    texts: list[str] = []
    for axes in strips:
        low, high = sorted(axes.get_ylim())
        ticks = [float(tick) for tick in axes.get_yticks() if low <= tick <= high]
        texts += axes.yaxis.get_major_formatter().format_ticks(ticks)
    return max((_text_width(text, font) for text in texts), default=0.0)


def has_room(axes: Axes, text: str, first: float, last: float) -> bool:
    """Whether a text of 8.5 points fits between two places on x, whose limits must be set."""
    low, high = axes.get_xlim()
    place = axes.get_position().width * _wide(axes)
    return len(text) * _LETTER_WIDTH <= (last - first) / (high - low) * place


def ticks_inside(axes: Axes) -> None:
    """Put ticks on x whose labels stay inside the axes, for panels that stand side by side.

    The x limits must have been set; labels are those of `THOUSANDS` in the axes' own size.
    """
    low, high = axes.get_xlim()
    font = FontProperties(size=axes.xaxis.get_ticklabels()[0].get_fontsize())
    inches = (high - low) / (axes.get_position().width * _wide(axes))
    for count in (4, 3, 2, 1):
        ticks = MaxNLocator(count).tick_values(low, high)
        half = [_text_width(THOUSANDS(tick, 0), font) * inches / 2 for tick in ticks]
        kept = [(t, h) for t, h in zip(ticks, half, strict=True) if low <= t - h and t + h <= high]
        apart = [b - h - (a + g) for (a, g), (b, h) in itertools.pairwise(kept)]
        if kept and min(apart, default=inches) >= _BETWEEN * inches:
            axes.set_xticks([tick for tick, _ in kept])
            return


def hour_axis(axes: Axes, first: float, last: float) -> None:
    """Make x an axis of service hours from first to last."""
    axes.set_xlim(first, last)
    axes.set_xlabel("service hours")
    axes.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    axes.xaxis.set_major_formatter(THOUSANDS)


def mark_events(axes: Axes, events: Sequence[Event]) -> None:
    """Draw vertical lines and their labels above the axes, in rows so that none overlaps.

    The axes are made as high as the rows of labels leave room in the figure. Events outside the
    axis are left out, and where they are many, some have a line and no label. The axes' x limits
    must have been set.
    """
    figure = axes.get_figure()
    if figure is None:
        raise ValueError("the axes belong to no figure")
    wide, high = figure.get_figure(root=True).get_size_inches()
    place = axes.get_position()
    labels = _arrange(axes.get_xlim(), place.width * wide, events)
    rows = 1 + max((label.row or 0 for label in labels), default=0)
    height = high * (1.0 - place.y0) - 0.12 - rows * _ROW_HEIGHT
    axes.set_position((place.x0, place.y0, place.width, height / high))
    for label in labels:
        event, row = label.event, label.row or 0
        top = 1.0 + (0.04 + row * _ROW_HEIGHT) / height
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
        if label.row is None:
            continue
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
    """Give each event inside the limits a place on an axis of a width in inches.

    Labels take room in the order of the events; one that finds none in `_MOST_ROWS` has no row.
    """
    first, last = limits
    inside = [event for event in events if first <= event.hours <= last]
    lines = [(event.hours - first) / (last - first) * width for event in inside]
    labels: list[_Label] = []
    for number, event in enumerate(inside):
        places = _places(event, lines[number], width)
        free = [one for one in places if _is_free(one, labels)]
        clear = [one for one in free if _is_clear(one, lines[number], labels, lines)]
        # Where lines crowd, a label hides a piece of them rather than being left out.
        labels.append((clear or free or [_Label(event, 0.0, None)])[0])
    return labels


def _places(event: Event, line: float, width: float) -> list[_Label]:
    """Places of an event's label in the order of their worth: low, then about its line."""
    length = len(event.label) * _LETTER_WIDTH
    wanted = (line - length / 2, line + _BESIDE, line - _BESIDE - length)
    # What would be beside the line and has no room there is no place.
    lefts = [min(max(wanted[0], 0.0), max(width - length, 0.0))]
    lefts += [left for left in wanted[1:] if 0.0 <= left <= width - length]
    return [_Label(event, left, row) for row in range(_MOST_ROWS) for left in lefts]


def _is_free(place: _Label, others: Sequence[_Label]) -> bool:
    """Whether a place overlaps no label of its row."""
    return all(
        place.left > other.right + _APART or place.right + _APART < other.left
        for other in others
        if other.row == place.row
    )


def _is_clear(place: _Label, line: float, others: Sequence[_Label], lines: Sequence[float]) -> bool:
    """Whether a place covers no line that rises past it, and its own line meets no label.

    Lines whose labels have no place yet may rise past any.
    """
    row = place.row or 0
    heights = [0 if other.row is None else other.row for other in others]
    own, to_come = len(others), range(len(others) + 1, len(lines))
    rising = [lines[i] for i, height in enumerate(heights) if height > row]
    rising += [lines[i] for i in to_come]
    below = [other for other in others if other.row is not None and other.row < row]
    covered = any(place.covers(at) for at in rising if at != lines[own])
    return not covered and not any(other.covers(line) for other in below)
