"""Pictures of the paper's figures, made again from its own numbers."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.rounding import significant
from hdprog.reporting.style import INK, Picture, new_figure, picture
from hdprog.reporting.words import parameter_meaning, parameter_name
from hdprog.reproduction.results import BranchPair, Curve, Finding, Reproduction, Sweep

# Okabe and Ito's colours, each with a line of its own.
_LOOKS = (("#0072B2", "-"), ("#D55E00", "--"), ("#009E73", "-."), ("#CC79A7", ":"))
_UNITS = {"T_i": "Nm", "T_T": "Nm", "mu": "", "K_W": "Nm/rad", "K_F": "Nm/rad"}


def loops_picture(loops: Sequence[BranchPair], findings: Sequence[Finding], shows: str) -> Picture:
    """Loops beside each other: torque over angle, and the width over torque."""
    figure = new_figure(7.6, 3.5)
    whole = figure.add_axes((0.09, 0.14, 0.4, 0.82))
    wide = figure.add_axes((0.59, 0.14, 0.4, 0.82))
    for number, loop in enumerate(loops):
        colour, line = _LOOKS[number % len(_LOOKS)]
        _draw(whole, wide, loop, colour, line)
    whole.legend(loc="upper left", handlelength=2.6)
    _label(whole, "torsion angle [arcmin]", "torque [Nm]")
    _label(wide, "torque [Nm]", "width of the loop [arcmin]")
    wide.set_ylim(bottom=0.0)
    return _told(figure, findings, shows)


def sweep_picture(sweeps: Sequence[Sweep], findings: Sequence[Finding], shows: str) -> Picture:
    """A column a parameter: the upper half of the loop above, the width over torque below."""
    count = len(sweeps)
    figure = new_figure(7.6, 5.0)
    across = 0.9 / count
    for column, sweep in enumerate(sweeps):
        left = 0.085 + column * (across + 0.01)
        place = across - 0.065
        whole = figure.add_axes((left, 0.54, place, 0.41))
        wide = figure.add_axes((left, 0.09, place, 0.34))
        for number, (value, loop) in enumerate(zip(sweep.values, sweep.loops, strict=True)):
            colour, line = _LOOKS[number % len(_LOOKS)]
            upper = loop.torque >= 0
            half = BranchPair(
                f"{significant(value)} {_UNITS[sweep.parameter]}".strip(),
                loop.torque[upper],
                loop.rising[upper],
                loop.falling[upper],
            )
            _draw(whole, wide, half, colour, line)
        whole.set_title(parameter_name(sweep.parameter))
        whole.legend(loc="lower right", handlelength=2.2, fontsize=8)
        _label(whole, "angle [arcmin]", "torque [Nm]" if column == 0 else "")
        _label(wide, "torque [Nm]", "width [arcmin]" if column == 0 else "")
        wide.set_ylim(bottom=0.0)
    named = "; ".join(
        f"{parameter_name(one.parameter)}: {parameter_meaning(one.parameter)}" for one in sweeps
    )
    return _told(figure, findings, f"{shows} {named}.")


def curves_picture(
    curves: Sequence[Curve], findings: Sequence[Finding], shows: str, unit: str, scale: float
) -> Picture:
    """Curves over torque, and their differences to the first of them."""
    figure = new_figure(7.6, 3.3)
    whole = figure.add_axes((0.09, 0.15, 0.4, 0.81))
    apart = figure.add_axes((0.6, 0.15, 0.39, 0.81))
    first = curves[0]
    for number, curve in enumerate(curves):
        colour, line = _LOOKS[number % len(_LOOKS)]
        whole.plot(curve.x, scale * curve.y, color=colour, linestyle=line, label=curve.label)
        if number:
            gap: FloatArray = scale * (curve.y - first.y)
            apart.plot(curve.x, gap, color=colour, linestyle=line)
    whole.legend(loc="best", handlelength=2.4)
    apart.axhline(0, color=_LOOKS[0][0], linewidth=1.0)
    _label(whole, "torque [Nm]", unit)
    _label(apart, "torque [Nm]", f"less {first.label} ({unit.partition('[')[2].rstrip(']')})")
    return _told(figure, findings, shows)


def of_figure(result: Reproduction, *figures: str) -> list[Finding]:
    """Findings that belong to figures of the paper."""
    return [one for one in result.findings if one.figure in figures]


def _draw(whole: Axes, wide: Axes, loop: BranchPair, colour: str, line: str) -> None:
    for branch, label in ((loop.rising, loop.label), (loop.falling, None)):
        whole.plot(
            ARCMIN_PER_RAD * branch,
            loop.torque,
            color=colour,
            linestyle=line,
            linewidth=1.2,
            label=label,
        )
    wide.plot(loop.torque, ARCMIN_PER_RAD * loop.width, color=colour, linestyle=line)


def _label(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, color=INK)
    axes.set_ylabel(y, color=INK)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.yaxis.set_major_formatter(THOUSANDS)


def _told(figure: Figure, findings: Sequence[Finding], shows: str) -> Picture:
    against = [one for one in findings if one.outcome == "disagrees"]
    open_ones = [one for one in findings if one.outcome == "cannot be checked"]
    if against:
        alt = "Not as the paper says: " + " ".join(one.claim for one in against)
        action = "read the numbers below before relying on the paper's figure."
    else:
        alt = (
            "As the paper says, as far as it can be checked."
            if open_ones
            else ("As the paper says.")
        )
        action = "nothing."
    return picture(
        figure,
        alt=alt,
        shows=shows,
        good="what came out, in the table below, agrees with the claim beside it.",
        bad="it does not; the claim then hangs on what the paper does not state, or is wrong.",
        action=action,
    )
