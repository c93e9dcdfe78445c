"""What a prior says of a drive: loops drawn from it, its stiffness curve and its hysteresis."""

from __future__ import annotations

import io
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hdprog.inference.prior_predictive import PriorPredictive, catalogue_curve
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.rounding import THIN_SPACE, significant
from hdprog.reporting.style import BAND, FIT, LIMIT, MEASURED, MUTED, house_style, new_figure

_PNG_DPI = 130
_FARTHEST = 0.95  # quantile of the draws that the axes hold
_MAGNIFIED = 5  # loops drawn near zero torque
_NEAR_ZERO = 0.12  # of the reference torque


def prior_picture(predictive: PriorPredictive, kind: Literal["png", "svg"]) -> bytes:
    """Picture of a prior as the bytes of a file.

    Left: loops drawn from the prior. Middle: the stiffness curve, with the maker's three straight
    pieces. Right: hysteresis width, and the slopes K1, K2 and K3 over the maker's.
    """
    with house_style():
        figure = _draw(predictive)
        buffer = io.BytesIO()
        metadata = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
        figure.savefig(buffer, format=kind, dpi=_PNG_DPI, metadata=metadata)
    return buffer.getvalue()


def _draw(predictive: PriorPredictive) -> Figure:
    figure = new_figure(10.0, 4.3)
    loops = figure.add_axes((0.08, 0.13, 0.275, 0.70))
    curve = figure.add_axes((0.435, 0.13, 0.245, 0.70))
    slopes = figure.add_axes((0.74, 0.56, 0.24, 0.27))
    width = figure.add_axes((0.74, 0.13, 0.24, 0.27))
    alpha = np.degrees(predictive.operation.alpha)
    figure.text(
        0.08,
        0.955,
        f"Prior {predictive.prior.name} before any test"
        f" (tooth angle {alpha:g}°, {100 * predictive.in_support:.3g} % of draws in the model's"
        " support)",
        fontsize=10.5,
        fontweight="bold",
        va="center",
        parse_math=False,
    )
    _loops(loops, predictive)
    _curve(curve, predictive)
    _slopes(slopes, predictive)
    _width(width, predictive)
    return figure


def _loops(axes: Axes, predictive: PriorPredictive) -> None:
    """Draw the loops, and some of them magnified where they cross zero torque."""
    angles = ARCMIN_PER_RAD * predictive.loops
    for angle in angles:
        axes.plot(angle, predictive.torque, color=FIT, linewidth=0.7, alpha=0.35)
    farthest = np.quantile(np.max(np.abs(angles), axis=1), 0.85)
    axes.set_xlim(-1.05 * farthest, 1.05 * farthest)
    _crossing(axes.inset_axes((0.58, 0.06, 0.4, 0.37)), predictive)
    axes.axhline(0, color=MUTED, linewidth=0.7)
    axes.axvline(0, color=MUTED, linewidth=0.7)
    axes.set_title(f"{len(angles)} loops drawn")
    axes.set_xlabel("torsion angle [arcmin]")
    axes.set_ylabel("torque [Nm]", labelpad=1)
    _plain_ticks(axes)


def _crossing(axes: Axes, predictive: PriorPredictive) -> None:
    """Draw the loops near zero torque, where the gap between their branches shows."""
    wide = float(np.quantile(predictive.figures["hysteresis_width_arcmin"], _FARTHEST))
    for angle in ARCMIN_PER_RAD * predictive.loops[:_MAGNIFIED]:
        axes.plot(angle, predictive.torque, color=FIT, linewidth=0.8, alpha=0.7)
    axes.set_xlim(-0.8 * wide, 0.8 * wide)
    axes.set_ylim(*(_NEAR_ZERO * np.array([-1, 1]) * predictive.operation.reference_torque))
    axes.axhline(0, color=MUTED, linewidth=0.7)
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    axes.tick_params(labelsize=7, length=2, pad=1)
    axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.yaxis.set_major_locator(MaxNLocator(3))
    axes.set_title(f"{_MAGNIFIED} near zero torque", fontsize=8, fontweight="normal", pad=2)


def _curve(axes: Axes, predictive: PriorPredictive) -> None:
    torque, angle = predictive.curve_torque, ARCMIN_PER_RAD * predictive.curves
    low, quarter, middle, three, high = np.quantile(angle, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    axes.fill_betweenx(
        torque, low, high, color=BAND, alpha=0.15, linewidth=0, label="90 % of draws"
    )
    axes.fill_betweenx(torque, quarter, three, color=BAND, alpha=0.3, linewidth=0, label="50 %")
    axes.plot(middle, torque, color=FIT, label="median")
    maker = catalogue_curve(predictive.prior, torque)
    if maker is not None:
        axes.plot(
            ARCMIN_PER_RAD * maker,
            torque,
            color=LIMIT,
            linestyle="--",
            linewidth=1.8,
            label="catalogue K1, K2, K3",
        )
        for at, name in zip(
            predictive.operation.catalogue_torques or (), ("T1", "T2"), strict=True
        ):
            bend = float(np.interp(at, torque, ARCMIN_PER_RAD * maker))
            axes.plot(bend, at, "o", color=LIMIT, markersize=5)
            axes.annotate(name, (bend, at), (6, -4), textcoords="offset points", va="top")
    axes.set_xlim(0, float(high[-1]))
    axes.set_ylim(0, float(torque[-1]))
    axes.set_title("stiffness curve, without friction")
    axes.set_xlabel("torsion angle [arcmin]")
    axes.set_ylabel("torque [Nm]", labelpad=1)
    axes.legend(loc="lower right")
    _plain_ticks(axes)


def _slopes(axes: Axes, predictive: PriorPredictive) -> None:
    """Draw the slopes relative to the maker's, on a logarithmic axis."""
    maker = predictive.prior.catalogue
    keys = [key for key in predictive.figures if key[0] == "K" and key in maker]
    if not keys:
        axes.set_title("no catalogue stiffness given")
        axes.set_axis_off()
        return
    for row, key in enumerate(reversed(keys)):
        ratio = predictive.figures[key] / maker[key]
        low, quarter, middle, three, high = np.quantile(ratio, [0.05, 0.25, 0.5, 0.75, 0.95])
        axes.plot([low, high], [row, row], color=BAND, linewidth=1.4, alpha=0.6)
        axes.plot([quarter, three], [row, row], color=BAND, linewidth=5, alpha=0.6)
        axes.plot(middle, row, "o", color=FIT, markersize=5)
    axes.axvline(1.0, color=LIMIT, linestyle="--", linewidth=1.4)
    axes.set_xscale("log", base=2)
    axes.set_xticks([0.125, 0.25, 0.5, 1.0, 2.0, 4.0], ["⅛", "¼", "½", "1", "2", "4"])
    axes.set_xlim(0.11, 4.0)
    axes.set_yticks(range(len(keys)), [key.partition("_")[0] for key in reversed(keys)])
    axes.set_ylim(-0.6, len(keys) - 0.4)
    axes.grid(axis="y", visible=False)
    axes.set_title("stiffness over the catalogue's")


def _width(axes: Axes, predictive: PriorPredictive) -> None:
    width = predictive.figures["hysteresis_width_arcmin"]
    top = _histogram(axes, width)
    middle = float(np.median(width))
    axes.axvline(middle, color=FIT, linewidth=1.4)
    axes.text(
        middle + 0.02 * top,
        0.97,
        f"median {significant(middle, 2)}",
        transform=axes.get_xaxis_transform(),
        ha="left",
        va="top",
        fontsize=8.5,
    )
    reference = f"{predictive.operation.reference_torque:.4g}"
    axes.set_title("hysteresis width at zero torque")
    axes.set_xlabel(f"arcmin, after ±{reference}{THIN_SPACE}Nm")
    axes.set_yticks([])
    axes.grid(visible=False)


def _histogram(axes: Axes, values: FloatArray) -> float:
    """Draw a histogram up to where nearly all values lie; gives the end of the axis."""
    top = 1.3 * float(np.quantile(values, _FARTHEST))
    axes.hist(values, bins=45, range=(0.0, top), color=MEASURED, alpha=0.45)
    axes.set_xlim(0.0, top)
    return top


def _plain_ticks(axes: Axes) -> None:
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6))
        axis.set_major_formatter(THOUSANDS)
