"""All loops of a drive on one pair of axes, coloured by service hours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import MaxNLocator

from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.figures.loop_panel import PanelScales
from hdprog.reporting.geometry import angle_zero, few, straightened
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.reader_units import loop_angle, loop_torque
from hdprog.reporting.rounding import hours, significant
from hdprog.reporting.style import MUTED, Picture, new_figure, picture
from hdprog.results import TestResult, since_replaced

_MOST_LABELS = 12
_MOST_POINTS = 240  # of each loop
_MOST_ROWS = 80  # of each loop, in the file of its numbers
_SAME_TORQUE = 0.02  # of the torque over the loop: the angles of loops that differ by more do, too


def loops_overlay(tests: Sequence[TestResult], scales: PanelScales) -> Picture:
    """Fitted loops of all tests, each shifted to the same zero.

    Parameters
    ----------
    tests : in the order of service time, at least two
    scales : as in the panels of the single tests
    """
    figure = new_figure(7.6, 4.3)
    loop = figure.add_axes((0.09, 0.11, 0.38, 0.87))
    bent = figure.add_axes((0.505, 0.11, 0.30, 0.87))
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.88, len(tests)))
    seen, force = loop_angle(), loop_torque()
    every = -(-len(tests) // _MOST_LABELS)
    last = len(tests) - 1
    for index, (test, colour) in enumerate(zip(tests, colours, strict=True)):
        label = _label(test) if index % every == 0 or index == last else None
        line: dict[str, Any] = {"color": colour, "linewidth": 2.0 if index == last else 1.2}
        fit = test.fit
        drawn = few(fit.torque.size, _MOST_POINTS)
        torque, angle = fit.torque[drawn], fit.fitted[drawn]
        at = force.factor * torque
        loop.plot(seen.factor * (angle - angle_zero(fit)), at, **line)
        bent.plot(straightened(fit, angle, torque), at, label=label, **line)
    for axes in (loop, bent):
        axes.set_ylim(*scales.torque)
        axes.axhline(0, color=MUTED, linewidth=0.7)
        axes.axvline(0, color=MUTED, linewidth=0.7)
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.xaxis.set_major_formatter(THOUSANDS)
        axes.yaxis.set_major_formatter(THOUSANDS)
    loop.set_xlim(*scales.angle)
    bent.set_xlim(*scales.straightened_fits)
    bent.tick_params(labelleft=False)
    loop.set_xlabel(f"torsion angle [{seen.unit}]")
    bent.set_xlabel(f"less its straight line [{seen.unit}]")
    loop.set_ylabel(f"torque [{force.unit}]")
    bent.legend(
        loc="upper left",
        bbox_to_anchor=(1.0, 1.02),
        title="test, hours",
        alignment="left",
        handlelength=1.4,
    )
    return picture(
        figure,
        alt=_alt(tests),
        shows="Left: the fitted loop of every test, shifted to the same zero. Right: each less the"
        " straight line between its ends, which shows width and bend. Dark is early, light late.",
        good="the loops lie on each other.",
        bad="loops that lean over more from test to test are losing stiffness; a wider loop has"
        " more friction, a narrower one less preload.",
        action="a single loop that stands out from its neighbours is worth a look at its mounting"
        " before it is believed.",
        data=_data(tests),
        doubtful=not all(test.converged for test in tests),
    )


def _data(tests: Sequence[TestResult]) -> PictureData:
    """Fitted loops one after the other."""
    seen, force = loop_angle(), loop_torque()
    rows = [
        (
            test.test_id,
            test.service_hours,
            force.factor * float(test.fit.torque[index]),
            seen.factor * float(test.fit.fitted[index] - angle_zero(test.fit)),
        )
        for test in tests
        for index in few(test.fit.torque.size, _MOST_ROWS)
    ]
    head = ("test", "service hours", f"torque [{force.unit}]", f"fitted angle [{seen.unit}]")
    return PictureData.of("all-loops", head, rows)


def _label(test: TestResult) -> str:
    when = "" if test.service_hours is None else f"  {hours(test.service_hours)}"
    name = test.test_id if len(test.test_id) <= 10 else test.test_id[:9] + "…"
    # A legend leaves out names that begin with an underscore, unless a space stands before it.
    begin = " " if name.startswith("_") else ""
    return f"{begin}{name}{when}".replace("$", r"\$")


def _alt(tests: Sequence[TestResult]) -> str:
    own = since_replaced(tests)
    since = "" if len(own) == len(tests) else " since the drive was replaced"
    first, last = (_full_angle(own[i]) for i in (0, -1))
    unit = loop_angle().unit
    if len(own) == 1:
        return (
            f"The last test, the first{since}, has a torsion angle of {significant(last)} {unit} "
            "over the whole loop."
        )
    text = (
        f"From the first test{since} to the last the torsion angle over the whole loop went from "
        f"{significant(first)} to {significant(last)} {unit}"
    )
    torque = [loop_torque().factor * float(np.ptp(own[i].fit.torque)) for i in (0, -1)]
    if abs(torque[1] - torque[0]) <= _SAME_TORQUE * torque[0]:
        return f"{text}."
    return (
        f"{text}, and the torque over it from {significant(torque[0])} to "
        f"{significant(torque[1])} {loop_torque().unit}: the angles do not compare."
    )


def _full_angle(test: TestResult) -> float:
    """Torsion angle from end to end of a loop in the reader's unit."""
    return float(loop_angle().factor * np.ptp(test.fit.fitted))
