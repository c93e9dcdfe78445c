"""Loop and residual of every model, all on one scale."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, MaxNLocator

from hdprog.comparison.results import ComparedModel, Comparison
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.error_words import micro
from hdprog.reporting.figures.residual_strip import FALLING, RISING
from hdprog.reporting.geometry import ARCMIN, MICRORADIAN, few, straight_slope, stretches
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.style import FIT, MEASURED, MUTED, Picture, new_figure, picture
from hdprog.reporting.words import listed
from hdprog.results import LoopFit

_ROWS = 200  # of each model, in the file of numbers
_HEIGHT, _TOP, _BELOW, _GAP = 1.18, 0.42, 0.5, 0.33  # inches of a row and between rows


def model_loops(result: Comparison) -> Picture:
    """A row a model: the loop less its straight line with the fit, and the residual."""
    models = result.models
    height = len(models) * (_HEIGHT + _GAP) - _GAP + _TOP + _BELOW
    figure = new_figure(7.6, height)
    slope = straight_slope(_closest(models).fit)
    middle = float(np.mean(models[0].fit.angle))
    bent = [ARCMIN * _straight(one.fit, one.fit.angle, slope, middle) for one in models]
    low = min(float(values.min()) for values in bent)
    high = max(float(values.max()) for values in bent)
    margin = 0.06 * (high - low)
    noise = MICRORADIAN * result.noise_floor_rad
    top = 1.15 * max(float(np.abs(MICRORADIAN * one.fit.residual).max()) for one in models)
    for row, one in enumerate(models):
        bottom = (height - _TOP - (row + 1) * _HEIGHT - row * _GAP) / height
        loop = figure.add_axes((0.08, bottom, 0.36, _HEIGHT / height))
        residual = figure.add_axes((0.57, bottom, 0.42, _HEIGHT / height))
        _draw_loop(loop, one, slope, middle)
        loop.set_xlim(low - margin, high + margin)
        _draw_residual(residual, one, noise, top)
        last = row == len(models) - 1
        for axes in (loop, residual):
            axes.tick_params(labelbottom=last)
        loop.set_title(one.words + ("" if one.converged else ", NOT CONVERGED"))
        residual.set_title(f"error {micro(one.errors.rmse_rad)} µrad")
        if last:
            loop.set_xlabel("angle less a straight line [arcmin]")
            residual.set_xlabel("torque [Nm]")
    return picture(
        figure,
        alt=_alt(result),
        shows=(
            "Left, for each model from the best to the worst: torque (upright, Nm) against the "
            "torsion angle less one straight line, the same for all; grey the measurement, blue "
            "the model. Right: measured less modelled angle in µrad over torque, blue points "
            "where torque rises, orange ones where it falls; grey band: ± twice the noise floor. "
            "The scale is the same for all, and logarithmic beyond three times the noise."
        ),
        good="points scattered in the grey band, blue and orange alike.",
        bad="blue and orange points apart (friction that the model lacks or has wrong), a bend "
        "(stiffness that it has wrong).",
        action="take no figure from a model whose points leave the band.",
        data=_data(models, slope, middle),
    )


def _data(models: tuple[ComparedModel, ...], slope: float, middle: float) -> PictureData:
    """Record, model and residual of every model, at most so many rows each."""
    rows, left_out = [], 0
    for one in models:
        fit, at = one.fit, few(one.fit.torque.size, _ROWS)
        left_out += fit.torque.size - at.size
        columns = (
            fit.torque,
            ARCMIN * _straight(fit, fit.angle, slope, middle),
            ARCMIN * _straight(fit, fit.fitted, slope, middle),
            MICRORADIAN * fit.residual,
        )
        values = (column[at].tolist() for column in columns)
        rows += [(one.words, *row) for row in zip(*values, strict=True)]
    bent = (f"{whose} angle less a straight line [arcmin]" for whose in ("measured", "modelled"))
    named = ("model", "torque [Nm]", *bent, "measured less modelled angle [µrad]")
    found = PictureData.of("model-loops", named, rows)
    return replace(found, left_out=left_out)


def _closest(models: tuple[ComparedModel, ...]) -> ComparedModel:
    """The model with the smallest error: its fit gives the straight line."""
    return min(models, key=lambda one: one.errors.rmse_rad)


def _straight(fit: LoopFit, angle: FloatArray, slope: float, middle: float) -> FloatArray:
    return angle - middle - slope * fit.torque


def _draw_loop(axes: Axes, one: ComparedModel, slope: float, middle: float) -> None:
    fit = one.fit
    marks: dict[str, Any] = {"markersize": 2.2, "alpha": 0.45, "markeredgewidth": 0}
    measured = ARCMIN * _straight(fit, fit.angle, slope, middle)
    fitted = ARCMIN * _straight(fit, fit.fitted, slope, middle)
    axes.plot(measured, fit.torque, "o", color=MEASURED, rasterized=True, **marks)
    axes.plot(fitted, fit.torque, color=FIT, linewidth=1.1, zorder=3)
    axes.axhline(0, color=MUTED, linewidth=0.7)
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.yaxis.set_major_formatter(THOUSANDS)


def _draw_residual(axes: Axes, one: ComparedModel, noise: float, top: float) -> None:
    fit = one.fit
    axes.set_yscale("symlog", linthresh=3 * noise, linscale=1.2)
    axes.axhspan(-2 * noise, 2 * noise, color=MUTED, alpha=0.22, linewidth=0, zorder=0)
    axes.axhline(0, color=MUTED, linewidth=0.7)
    for first, last, rising in stretches(fit):
        part = slice(first, last + 1)
        axes.plot(
            fit.torque[part],
            MICRORADIAN * fit.residual[part],
            "o" if rising else "v",
            color=RISING if rising else FALLING,
            markersize=2.4,
            alpha=0.7,
            markeredgewidth=0,
            rasterized=True,
        )
    axes.set_ylim(-top, top)
    axes.yaxis.set_major_locator(FixedLocator(_ticks(3 * noise, top)))
    axes.yaxis.set_minor_locator(FixedLocator([]))
    axes.yaxis.set_major_formatter(THOUSANDS)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.xaxis.set_major_formatter(THOUSANDS)


def _ticks(linear: float, top: float) -> list[float]:
    """Zero and a few powers of ten on either side."""
    first = 10.0 ** np.ceil(np.log10(1.2 * linear))
    powers = [first * 10.0**step for step in range(8) if first * 10.0**step < top]
    return [*(-one for one in reversed(powers)), 0.0, *powers]


def _alt(result: Comparison) -> str:
    floor = 1.5 * result.noise_floor_rad
    clean = [one.words for one in result.models if one.errors.rmse_rad < floor]
    if not clean:
        return "Every model leaves more than the noise of this record."
    return f"At the level of the noise: {listed(clean)}."
