"""What a test told of each parameter: its posterior over the prior that it started from."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator, NullLocator

from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.picture_data import Cell, PictureData
from hdprog.reporting.rounding import percent
from hdprog.reporting.style import FIT, INK, MUTED, Picture, new_figure, picture
from hdprog.reporting.words import (
    agree,
    contraction_words,
    listed,
    parameter_factor,
    parameter_name,
    parameter_unit,
)
from hdprog.results import ParameterDraws, TestResult

_COLUMNS, _ROWS = 4, 2
_BINS = 44
_OUTER = (0.01, 0.99)  # quantiles of the prior that a panel holds
_SMOOTH = np.array([0.25, 0.5, 0.25])
_INFORMED = 0.5


def prior_posterior(test: TestResult, draws: ParameterDraws) -> Picture:
    """A panel for each parameter: posterior filled, prior dashed, each scaled to its own height.

    Parameters
    ----------
    test : whose parameters are shown
    draws : of its posterior and prior
    """
    figure = new_figure(7.6, 3.9)
    for index, name in enumerate(draws.posterior):
        row, column = divmod(index, _COLUMNS)
        place = (0.035 + 0.245 * column, 0.615 - 0.485 * row, 0.215, 0.275)
        _panel(figure.add_axes(place), name, test, draws)
    weak = [name for name, one in test.parameters.items() if not one.contraction >= _INFORMED]
    return picture(
        figure,
        alt=_alt(test, weak),
        shows=(
            "Each parameter on its own axis: dashed grey what was assumed before the test (prior),"
            " blue what is known after it (posterior), each drawn to the same height; the dot and"
            " line are its median and 90 % interval. The axes hold 98 % of the prior."
        ),
        good="a narrow blue hill inside the dashed one: the record tells the parameter, and the"
        " prior allowed for it.",
        bad="blue and dashed lie on each other: the record is silent and the number is the"
        " prior's. Blue at the edge of the panel: prior and record disagree.",
        action=(
            "nothing."
            if not weak
            else "do not read wear from a parameter that the record does not tell; the figures of"
            " merit are safer."
        ),
        data=_data(test, draws),
        doubtful=not test.converged,
    )


def _panel(axes: Axes, name: str, test: TestResult, draws: ParameterDraws) -> None:
    factor = parameter_factor(name)
    prior, posterior = factor * draws.prior[name], factor * draws.posterior[name]
    spread = np.quantile(prior, _OUTER)
    low = min(float(spread[0]), float(np.quantile(posterior, 0.01)))
    high = max(float(spread[1]), float(np.quantile(posterior, 0.99)))
    # On a logarithmic axis where the prior spans a decade: its hill is then one.
    logarithmic = low > 0 and high / low > 8.0
    transform = np.log if logarithmic else np.positive
    edges = np.linspace(float(transform(low)), float(transform(high)), _BINS + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    at = np.exp(middles) if logarithmic else middles
    axes.plot(at, _hill(transform(prior), edges), color=MUTED, linewidth=1.2, linestyle=(0, (4, 2)))
    values = transform(posterior)
    margin = 0.12 * float(np.ptp(values))  # room for the hill to run out
    narrow = np.linspace(float(values.min()) - margin, float(values.max()) + margin, 32)
    inner = 0.5 * (narrow[1:] + narrow[:-1])
    hill = _hill(values, narrow)
    axes.fill_between(
        np.exp(inner) if logarithmic else inner, hill, color=FIT, alpha=0.4, linewidth=0.8
    )
    levels = test.parameters[name].quantiles
    ends = [factor * levels[0.05], factor * levels[0.95]]
    axes.plot(ends, [1.14, 1.14], color=INK, linewidth=1.8, solid_capstyle="butt")
    axes.plot([factor * levels[0.50]], [1.14], "o", color=INK, markersize=4)
    if logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks(_round_ticks(low, high))
    else:
        axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.tick_params(labelsize=7.8)
    axes.set_xlim(low, high)
    axes.set_ylim(0.0, 1.3)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False)
    unit = parameter_unit(name)
    axes.set_title(f"{parameter_name(name)}{f' [{unit}]' if unit else ''}", pad=13, fontsize=9)
    axes.text(
        0.0,
        1.03,
        contraction_words(test.parameters[name].contraction),
        transform=axes.transAxes,
        fontsize=7.8,
        color=MUTED,
    )


def _round_ticks(low: float, high: float) -> list[float]:
    """One to three round numbers inside a logarithmic axis."""
    powers = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    for factors in ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0)):
        found = [f * 10.0**p for p in powers for f in factors if low <= f * 10.0**p <= high]
        if len(found) >= 2:
            break
    return found[:: -(-len(found) // 3)] if len(found) > 3 else found


def _hill(values: FloatArray, edges: FloatArray) -> FloatArray:
    """Smoothed histogram whose top is 1."""
    counts = np.histogram(values, edges)[0].astype(float)
    smooth = np.convolve(np.convolve(counts, _SMOOTH, "same"), _SMOOTH, "same")
    return np.asarray(smooth / (smooth.max() or 1.0))


def _alt(test: TestResult, weak: list[str]) -> str:
    narrowed = max(test.parameters, key=lambda name: test.parameters[name].contraction)
    best = percent(test.parameters[narrowed].contraction)
    text = (
        f"Test {test.test_id}: the record narrowed {parameter_name(narrowed)} most, by {best} of"
        " its prior variance"
    )
    if not weak:
        return f"{text}, and told every parameter."
    names = listed(map(parameter_name, weak))
    verb = agree(len(weak), "rests", "rest")
    return f"{text}; {names} {verb} mostly on the prior."


def _data(test: TestResult, draws: ParameterDraws) -> PictureData:
    levels = (0.05, 0.25, 0.50, 0.75, 0.95)
    rows: list[tuple[Cell, ...]] = []
    for name in draws.posterior:
        factor = parameter_factor(name)
        own = test.parameters[name].quantiles
        before = np.quantile(draws.prior[name], levels)
        unit = parameter_unit(name)
        rows.append((name, unit, "prior", *(factor * float(value) for value in before)))
        rows.append((name, unit, "posterior", *(factor * own[level] for level in levels)))
    head = ("parameter", "unit", "which", *(f"{100 * level:g} %" for level in levels))
    return PictureData.of(f"{test.test_id}-prior-and-posterior", head, rows)
