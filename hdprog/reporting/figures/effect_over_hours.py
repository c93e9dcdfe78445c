"""How large an effect is over service hours: whether it grows as the drive wears."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from hdprog.explanation import FoundEffect
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS, align_left, hour_axis
from hdprog.reporting.effect_words import effect_name
from hdprog.reporting.error_words import micro
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import hours
from hdprog.reporting.style import FIT, MEASURED, MUTED, Picture, new_figure, picture
from hdprog.reporting.words import capital, counted, with_unit

_ACTION = {
    "wear": "count it with the wear: watch it in the next tests.",
    "rig": "look for it in the rig and its mounting, not in the drive.",
    "unclear": "follow the advice above; a further test shows whether it grows.",
}


def effect_over_hours(effect: FoundEffect, amplitude: FloatArray) -> Picture:
    """Angle that an effect moves in every test, with its interval.

    Parameters
    ----------
    effect : with its origin
    amplitude : (tests, 4) service hours and 5 %, 50 %, 95 % of the angle that it moves (root mean
        square over the record, in rad); zeros where a test does not carry it, NaN where it
        cannot show it
    """
    at, low, middle, high = amplitude.T * np.array([[1.0]] + 3 * [[MICRORADIAN]])
    carried, hidden = high > 0, np.isnan(high)
    figure = new_figure(7.6, 2.9)
    axes = figure.add_axes((0.095, 0.27, 0.885, 0.69))
    span = float(np.ptp(at)) or 1.0
    hour_axis(axes, float(at.min()) - 0.04 * span, float(at.max()) + 0.04 * span)
    axes.set_ylim(0.0, 1.12 * float(np.nanmax(high)) or 1.0)
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_formatter(THOUSANDS)
    axes.set_ylabel("angle moved [µrad]")
    align_left([axes])
    axes.plot(at[~hidden], middle[~hidden], color=MUTED, linewidth=0.9, linestyle=":")
    axes.errorbar(
        at[carried],
        middle[carried],
        yerr=np.array([middle - low, high - middle])[:, carried],
        fmt="o",
        color=FIT,
        markersize=5.5,
        capsize=3,
        linewidth=1.4,
        label="in this test: median, 5 to 95 %",
    )
    for these, mark, label in (
        (~carried & ~hidden, "o", "not found in this test"),
        (hidden, "x", "this test cannot show it"),
    ):
        if these.any():
            axes.plot(
                at[these],
                np.zeros(int(these.sum())),
                mark,
                color=MEASURED,
                markerfacecolor="white",
                markersize=5.5,
                clip_on=False,
                zorder=3,
                label=label,
            )
    axes.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.19), ncols=3, columnspacing=1.6)
    return picture(
        figure,
        alt=_alt(effect, at, middle, carried, int(hidden.sum())),
        shows="How far the effect moves the angle in each test (root mean square over the record),"
        " over service hours.",
        good="points that stay level: a steady trait of the rig, which does not wear the drive.",
        bad="points that rise from test to test: the drive itself is changing.",
        action=_ACTION.get(effect.origin or "unclear", _ACTION["unclear"]),
        data=PictureData.of(
            f"{effect.id}-over-hours",
            ("service hours", *(f"angle moved, {level} % [µrad]" for level in (5, 50, 95))),
            zip(*(column.tolist() for column in (at, low, middle, high)), strict=True),
        ),
    )


def _alt(
    effect: FoundEffect, at: FloatArray, middle: FloatArray, carried: FloatArray, hidden: int
) -> str:
    name = capital(effect_name(effect.id))
    found = np.flatnonzero(carried)
    if found.size == 0:
        return f"{name} is found in no single test; only all of them together show it."
    count = f"{found.size} of {counted(carried.size, 'test')}"
    if hidden:
        count += f" ({hidden} cannot show it)"
    first, last = (
        f"{with_unit(micro(middle[i] / MICRORADIAN), 'µrad')} at {hours(float(at[i]))}"
        for i in (found[0], found[-1])
    )
    if found.size == 1:
        return f"{name} is found in {count}: it moves the angle by {first}."
    return f"{name} is found in {count}: it moves the angle by {first} and by {last}."
