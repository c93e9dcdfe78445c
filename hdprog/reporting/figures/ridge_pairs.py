"""The ridge: stiffness of cup and teeth, which one loop tells together better than apart."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS, ticks_inside
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import grouped, interval
from hdprog.reporting.style import FIT, INK, Picture, new_figure, picture
from hdprog.reporting.words import (
    listed,
    parameter_factor,
    parameter_name,
    parameter_unit,
)
from hdprog.results import ParameterDraws, TestResult

RIDGE = ("K_F", "a", "b", "T_T")
_STRONG = 0.7  # rank correlation from which two parameters are said to be known together
_LEFT, _BOTTOM, _SIZE, _GAP = 0.115, 0.085, 0.205, 0.016


def ridge_pairs(test: TestResult, draws: ParameterDraws) -> Picture:
    """Every pair out of K_F, a, b and T_T: draws of the posterior, single spreads on the diagonal.

    Parameters
    ----------
    test : whose parameters are shown
    draws : of its posterior
    """
    values = {name: parameter_factor(name) * draws.posterior[name] for name in RIDGE}
    figure = new_figure(7.6, 6.2)
    last = len(RIDGE) - 1
    for row, below in enumerate(RIDGE):
        for column, across in enumerate(RIDGE[: row + 1]):
            place = (
                _LEFT + column * (_SIZE + _GAP),
                _BOTTOM + (last - row) * (_SIZE + _GAP),
                _SIZE,
                _SIZE,
            )
            axes = figure.add_axes(place)
            if row == column:
                _spread(axes, values[across], _quantiles(test, across), across)
            else:
                _cloud(axes, values[across], values[below])
            _label(axes, across, below, row, column)
    strongest = _strongest(values)
    return picture(
        figure,
        alt=_alt(test, strongest),
        shows=(
            "Each dot is one set of parameters that explains the loop; r is the rank correlation"
            " of the pair. On the diagonal the spread of each parameter by itself, with its median"
            " and 90 % interval above."
        ),
        good="round clouds: each parameter is told by itself.",
        bad="a thin band: the loop tells a combination of the two, and one may be traded for the"
        " other. Their single intervals are then wide without the loop being badly known.",
        action=(
            "nothing."
            if abs(strongest[2]) < _STRONG
            else f"judge {listed(map(parameter_name, strongest[:2]))} together, by the stiffness"
            " figures, which carry the correlation; a test to a larger torque tells them apart"
            " better."
        ),
        data=_data(test, values),
        doubtful=not test.converged,
    )


def _quantiles(test: TestResult, name: str) -> tuple[float, float, float]:
    """Ends and middle of all draws, of which the picture holds some."""
    quantiles = test.parameters[name].quantiles
    factor = parameter_factor(name)
    return factor * quantiles[0.05], factor * quantiles[0.50], factor * quantiles[0.95]


def _spread(
    axes: Axes, values: FloatArray, quantiles: tuple[float, float, float], name: str
) -> None:
    low, high = _range(values)
    axes.hist(values, bins=24, range=(low, high), color=FIT, alpha=0.45, density=True)
    top = 1.6 * axes.get_ylim()[1]
    axes.set_ylim(0.0, top)
    axes.set_xlim(low, high)
    five, middle, most = quantiles
    axes.plot([five, most], [0.7 * top] * 2, color=INK, linewidth=1.8, solid_capstyle="butt")
    axes.plot([middle], [0.7 * top], "o", color=INK, markersize=4)
    low_text, middle_text, high_text = interval(five, middle, most)
    axes.text(
        0.03,
        0.96,
        f"{parameter_name(name)} {middle_text}\n({low_text} to {high_text})",
        transform=axes.transAxes,
        ha="left",
        va="top",
        fontsize=7.2,
        linespacing=1.15,
        parse_math=False,
    )
    axes.set_yticks([])
    axes.grid(visible=False)


def _cloud(axes: Axes, across: FloatArray, below: FloatArray) -> None:
    axes.plot(
        across,
        below,
        "o",
        color=FIT,
        markersize=2.2,
        alpha=0.35,
        markeredgewidth=0,
        rasterized=True,
    )
    axes.set_xlim(*_range(across))
    axes.set_ylim(*_range(below))
    axes.text(
        0.96,
        0.95,
        f"r = {grouped(_rank_correlation(across, below), 2)}",
        transform=axes.transAxes,
        ha="right",
        va="top",
        fontsize=8,
        color=INK,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6},
    )


def _label(axes: Axes, across: str, below: str, row: int, column: int) -> None:
    axes.tick_params(labelsize=7.6)
    axes.xaxis.set_major_formatter(THOUSANDS)
    ticks_inside(axes)
    if row == len(RIDGE) - 1:
        axes.set_xlabel(_named(across), fontsize=8.5)
    else:
        axes.tick_params(labelbottom=False)
    if row != column:
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.yaxis.set_major_formatter(THOUSANDS)
    if column == 0 and row > 0:
        axes.set_ylabel(_named(below), fontsize=8.5)
        axes.yaxis.set_label_coords(-0.36, 0.5)
    else:
        axes.tick_params(labelleft=False)


def _named(name: str) -> str:
    unit = parameter_unit(name)
    return f"{parameter_name(name)} [{unit}]" if unit else parameter_name(name)


def _range(values: FloatArray) -> tuple[float, float]:
    low, high = np.quantile(values, [0.004, 0.996])
    margin = 0.08 * (high - low) or 1.0
    return float(low - margin), float(high + margin)


def _rank_correlation(first: FloatArray, second: FloatArray) -> float:
    """Spearman's correlation, which no change of scale moves."""
    one, other = (np.argsort(np.argsort(values)).astype(float) for values in (first, second))
    return float(np.corrcoef(one, other)[0, 1])


def _strongest(values: dict[str, FloatArray]) -> tuple[str, str, float]:
    """Pair with the strongest rank correlation."""
    pairs = [
        (one, other, _rank_correlation(values[one], values[other]))
        for index, one in enumerate(RIDGE)
        for other in RIDGE[index + 1 :]
    ]
    return max(pairs, key=lambda pair: abs(pair[2]))


def _alt(test: TestResult, strongest: tuple[str, str, float]) -> str:
    one, other, r = strongest
    names = f"{parameter_name(one)} and {parameter_name(other)}"
    if abs(r) < _STRONG:
        return (
            f"Test {test.test_id}: no two of K_F, a, b and T_T are tied to each other; the"
            f" strongest pair is {names} (rank correlation {r:.2f})."
        )
    way = "rise together" if r > 0 else "are traded for each other"
    return (
        f"Test {test.test_id}: {names} {way} (rank correlation {r:.2f}): the loop tells their"
        " combination better than each by itself."
    )


def _data(test: TestResult, values: dict[str, FloatArray]) -> PictureData:
    head = tuple(_named(name) for name in RIDGE)
    return PictureData.along(f"{test.test_id}-ridge", head, *(values[name] for name in RIDGE))
