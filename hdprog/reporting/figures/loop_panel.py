"""One test: its loop with the fit, and below it what the fit leaves over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS, align_left
from hdprog.reporting.error_words import micro
from hdprog.reporting.geometry import (
    MICRORADIAN,
    MOST_STRETCHES,
    angle_zero,
    few,
    residual_scale,
    straightened,
    stretches,
)
from hdprog.reporting.left_structure import LOOK_IN_RIG, slow_errors, structure_remains
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.reader_units import loop_angle, loop_torque
from hdprog.reporting.style import (
    BAND,
    FIT,
    MEASURED,
    MUTED,
    Picture,
    new_figure,
    picture,
)
from hdprog.results import TestResult

_MOST_ROWS = 200  # in the file of a panel's numbers: a report may hold a dozen of them
_FEW = 0.02  # of a record's readings at either end, which may fall outside the axes


@dataclass(frozen=True)
class PanelScales:
    """Axes that all panels of a report share.

    Attributes
    ----------
    angle, torque : limits in the reader's units
    straightened : limits of the angle less its straight line, with the readings
    straightened_fits : the same of the fitted curves alone
    residual : half the height in µrad of the residual strip
    """

    angle: tuple[float, float]
    torque: tuple[float, float]
    straightened: tuple[float, float]
    straightened_fits: tuple[float, float]
    residual: float

    @staticmethod
    def of(tests: tuple[TestResult, ...]) -> PanelScales:
        """Scales that hold every test's record, offset removed."""
        fits = [test.fit for test in tests]
        angle = [loop_angle().factor * (fit.angle - angle_zero(fit)) for fit in fits]
        bent = [straightened(fit, fit.fitted, fit.torque) for fit in fits]
        readings = [straightened(fit, fit.angle, fit.torque) for fit in fits]
        return PanelScales(
            _padded(angle),
            _padded([loop_torque().factor * fit.torque for fit in fits]),
            _widened(_padded(bent), readings),
            _padded(bent),
            residual_scale(tests),
        )


def _padded(series: Sequence[FloatArray]) -> tuple[float, float]:
    low, high = min(map(np.min, series)), max(map(np.max, series))
    margin = 0.06 * (high - low)
    return float(low - margin), float(high + margin)


def _widened(limits: tuple[float, float], series: Sequence[FloatArray]) -> tuple[float, float]:
    """Limits that hold the readings too, but for the few that may be spikes."""
    low, high = _padded([np.quantile(each, (_FEW, 1.0 - _FEW)) for each in series])
    return min(limits[0], low), max(limits[1], high)


def loop_panel(test: TestResult, scales: PanelScales) -> Picture:
    """Torque against torsion angle with the fit, and the residual along the record."""
    figure = new_figure(7.6, 4.9)
    loop = figure.add_axes((0.09, 0.445, 0.485, 0.535))
    bent = figure.add_axes((0.615, 0.445, 0.37, 0.535))
    strip = figure.add_axes((0.09, 0.1, 0.895, 0.225))
    _draw_loop(loop, bent, test, scales)
    _draw_residual(strip, test, scales)
    align_left([loop, strip])
    return picture(
        figure,
        alt=_alt(test),
        shows=(
            "Above left: torque against torsion angle, grey the measurement, blue the fit with its"
            " 90 % band (often thinner than the line); the encoder's zero is removed. Above right:"
            " the same less the straight line between the loop's ends, which shows its width"
            " (friction) and its bend (softness at low torque)."
            " Below: measured minus fitted angle along the record. Grey band:"
            " noise of a point as fitted (± 2 standard deviations); blue band: where the fit may"
            " lie (90 %); shaded: torque falls. The same scales for all tests."
        ),
        good="the points below fill the grey band evenly, without a pattern.",
        bad="waves, steps or spikes at the edges of the shading (reversals), or points well"
        " outside the band: something acts that the model lacks, and its parameters are biased.",
        action=_action(test),
        data=_data(test),
    )


def _data(test: TestResult) -> PictureData:
    """Block averages with the fit, its 90 % band and what is left over."""
    fit, zero = test.fit, angle_zero(test.fit)
    seen, force = loop_angle(), loop_torque()
    angles = [seen.factor * (each - zero) for each in (fit.angle, fit.fitted, fit.low, fit.high)]
    named = ("measured", "fit", "fit 5 %", "fit 95 %")
    return PictureData.along(
        f"{test.test_id}-loop",
        (
            "reading",
            f"torque [{force.unit}]",
            *(f"{name} [{seen.unit}]" for name in named),
            "residual [µrad]",
            "noise, 1 sd [µrad]",
        ),
        fit.position,
        force.factor * fit.torque,
        *angles,
        MICRORADIAN * fit.residual,
        MICRORADIAN * fit.noise,
        most=_MOST_ROWS,
    )


def _action(test: TestResult) -> str:
    if not test.converged:
        return "do not use the numbers of this test; run it again with more draws."
    if structure_remains(test) and not slow_errors(test):
        return LOOK_IN_RIG
    return "nothing."


def _draw_loop(loop: Axes, bent: Axes, test: TestResult, scales: PanelScales) -> None:
    """Draw the loop, and beside it the same less its straight line."""
    fit, zero = test.fit, angle_zero(test.fit)
    seen, force = loop_angle(), loop_torque()
    chosen = few(len(test.loop))
    angle, torque = test.loop.angle[chosen], test.loop.torque[chosen]
    fit_name = "fit" if test.converged else "fit, NOT CONVERGED"
    readings: dict[str, Any] = {"color": MEASURED, "alpha": 0.6, "rasterized": True, "zorder": 2.0}
    blocks: dict[str, Any] = {
        "markersize": 2.6,
        "alpha": 0.45,
        "markeredgewidth": 0,
        "rasterized": True,
    }
    bent.plot(straightened(fit, angle, torque), force.factor * torque, ",", **readings)
    at = force.factor * fit.torque
    angles = (fit.angle, fit.fitted, fit.low, fit.high)
    for axes, (measured, fitted, low, high) in (
        (loop, [seen.factor * (each - zero) for each in angles]),
        (bent, [straightened(fit, each, fit.torque) for each in angles]),
    ):
        axes.plot(measured, at, "o", color=MEASURED, label="measured", **blocks)
        for first, last, _ in stretches(fit)[:MOST_STRETCHES]:
            part = slice(first, last + 1)
            band = axes.fill_betweenx(at[part], low[part], high[part], color=BAND, linewidth=0)
            band.set(alpha=0.3, zorder=2.0, rasterized=True)
        axes.plot(fitted, at, color=FIT, linewidth=1.3, zorder=3, label=fit_name)
        axes.set_ylim(*scales.torque)
        axes.axhline(0, color=MUTED, linewidth=0.7)
        axes.axvline(0, color=MUTED, linewidth=0.7)
        axes.xaxis.set_major_locator(MaxNLocator(6))
        axes.xaxis.set_major_formatter(THOUSANDS)
        axes.yaxis.set_major_formatter(THOUSANDS)
    loop.set_xlim(*scales.angle)
    bent.set_xlim(*scales.straightened)
    bent.tick_params(labelleft=False)
    loop.set_xlabel(f"torsion angle [{seen.unit}]", labelpad=1)
    bent.set_xlabel(f"the same less its straight line [{seen.unit}]", labelpad=1)
    loop.set_ylabel(f"torque [{force.unit}]")
    loop.legend(loc="upper left", markerscale=1.8)


def _draw_residual(axes: Axes, test: TestResult, scales: PanelScales) -> None:
    fit, top = test.fit, scales.residual
    for first, last, rising in stretches(fit)[:MOST_STRETCHES]:
        if not rising:
            axes.axvspan(
                fit.position[first], fit.position[last], color="#eef0f3", linewidth=0, zorder=0
            )
    noise = 2.0 * MICRORADIAN * fit.noise
    bands: dict[str, Any] = {"linewidth": 0, "rasterized": True}  # as lines they weigh the most
    axes.fill_between(fit.position, -noise, noise, color=MUTED, alpha=0.22, zorder=1, **bands)
    axes.fill_between(
        fit.position,
        MICRORADIAN * (fit.low - fit.fitted),
        MICRORADIAN * (fit.high - fit.fitted),
        color=BAND,
        alpha=0.45,
        zorder=2,
        **bands,
    )
    values = np.clip(MICRORADIAN * fit.residual, -top, top)
    axes.plot(
        fit.position,
        values,
        "o",
        color=MEASURED,
        markersize=2.4,
        alpha=0.75,
        rasterized=True,
        clip_on=False,
        zorder=3,
    )
    axes.axhline(0, color=FIT, linewidth=0.9, zorder=3.5)
    axes.set_xlim(0, max(float(fit.position.max()), len(test.loop) - 1.0))
    axes.set_ylim(-top, top)
    axes.grid(axis="x", visible=False)
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.yaxis.set_major_formatter(THOUSANDS)
    axes.set_xlabel("reading number along the record", labelpad=1)
    axes.set_ylabel("residual [µrad]")


def error_words(test: TestResult) -> str:
    """Error of the fit against the noise floor, in one sentence."""
    error, floor = micro(test.rmse_rad), micro(test.noise_floor_rad)
    text = f"Error of the fit {error} µrad (root mean square), noise floor {floor} µrad"
    if structure_remains(test):
        alike = f"{test.residual_correlation:.2f}"
        return f"{text}; neighbours are alike (correlation {alike}): structure remains."
    return f"{text}; no pattern between neighbours."


def _alt(test: TestResult) -> str:
    text = f"Test {test.test_id}: {error_words(test)}"
    return text if test.converged else f"Not converged. {text}"
