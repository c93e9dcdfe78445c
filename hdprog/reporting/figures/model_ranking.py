"""Models in order: how far each is behind the best, and its error on what it did not see."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from hdprog.comparison.results import DRIVE, MARGIN, ComparedModel, Comparison
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.comparison_words import difference
from hdprog.reporting.error_words import micro
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import significant
from hdprog.reporting.style import FIT, INK, LIMIT, MEASURED, MUTED, Picture, new_figure, picture
from hdprog.reporting.words import listed

_ROW = 0.27  # inches
_BELOW, _ABOVE = 0.62, 0.42
_LINEAR = 10.0  # difference up to which the axis is even; beyond it is logarithmic


def model_ranking(result: Comparison) -> Picture:
    """Differences of log predictive density with error bars, and errors on a common scale."""
    models = result.models
    height = _ROW * len(models) + _BELOW + _ABOVE
    figure = new_figure(7.6, height)
    bottom, high = _BELOW / height, _ROW * len(models) / height
    evidence = figure.add_axes((0.29, bottom, 0.38, high))
    errors = figure.add_axes((0.71, bottom, 0.28, high))
    for axes in (evidence, errors):
        axes.set_ylim(len(models) - 0.4, -0.6)
        axes.grid(axis="y", visible=False)
    _draw_evidence(evidence, models)
    _draw_errors(errors, result)
    errors.set_yticks(range(len(models)), [""] * len(models))
    return picture(
        figure,
        alt=_alt(result),
        shows=(
            "Left: how far each model's expected log predictive density (leave-one-out over the "
            "record's blocks) is behind the best, with ± 2 standard errors; beyond "
            f"{_LINEAR:g} the axis is logarithmic. Shaded: differences below {MARGIN:g}, which "
            "count for nothing. Right: error over all readings (open) and on left-out parts of the "
            "record (filled), with the noise floor as a dashed line."
        ),
        good="one model clearly ahead, its filled mark near the noise floor.",
        bad="bars that overlap zero: the record does not tell these models apart; filled marks far "
        "right of open ones: a model that fits but does not predict.",
        action=(
            "where several models are level, rely only on figures that they agree on, or record a "
            "loop with a larger torque, minor loops or a second loading rate."
        ),
        data=_data(models),
    )


def _data(models: tuple[ComparedModel, ...]) -> PictureData:
    columns = (
        "model",
        "behind the best",
        "standard error",
        "error [µrad]",
        "error on left-out parts [µrad]",
    )
    rows = [
        (
            one.words,
            one.evidence.difference,
            one.evidence.difference_se,
            MICRORADIAN * one.errors.rmse_rad,
            MICRORADIAN * one.errors.heldout_rmse_rad,
        )
        for one in models
    ]
    return PictureData.of("model-ranking", columns, rows)


def _draw_evidence(axes: Axes, models: tuple[ComparedModel, ...]) -> None:
    axes.set_xscale("symlog", linthresh=_LINEAR, linscale=1.0)
    far = max(one.evidence.difference + 2 * one.evidence.difference_se for one in models)
    axes.set_xlim(-4.0, max(2 * far, 20.0))
    axes.xaxis.set_major_formatter(THOUSANDS)
    ticks = [0.0, 5.0, *(10.0**power for power in range(1, 7) if 10.0**power < 2 * far)]
    axes.set_xticks(ticks)
    axes.minorticks_off()
    axes.axvspan(-4.0, MARGIN, color="#eef0f3", linewidth=0, zorder=0)
    for at, one in enumerate(models):
        colour = FIT if one.id == DRIVE else MEASURED
        gap, spread = one.evidence.difference, 2 * one.evidence.difference_se
        ends = [max(gap - spread, -4.0), gap + spread]
        axes.plot(ends, [at, at], color=colour, linewidth=1.8, zorder=2)
        axes.plot(gap, at, "o", color=colour, markersize=5.5, zorder=3)
    labels = [one.words + ("" if one.converged else " *") for one in models]
    axes.set_yticks(range(len(models)), labels)
    for text, one in zip(axes.get_yticklabels(), models, strict=True):
        text.set_color(LIMIT if not one.converged else FIT if one.id == DRIVE else INK)
        text.set_fontweight("bold" if one.id == DRIVE else "normal")
    axes.set_xlabel("behind the best in log predictive density")
    axes.set_title("Prediction")


def _draw_errors(axes: Axes, result: Comparison) -> None:
    axes.set_xscale("log")
    floor = MICRORADIAN * result.noise_floor_rad
    axes.axvline(floor, color=MUTED, linestyle="--", linewidth=1.2, zorder=1)
    for at, one in enumerate(result.models):
        colour = FIT if one.id == DRIVE else MEASURED
        seen = MICRORADIAN * one.errors.rmse_rad
        unseen = MICRORADIAN * one.errors.heldout_rmse_rad
        axes.plot([seen, unseen], [at, at], color=colour, linewidth=1.2, zorder=2)
        axes.plot(unseen, at, "o", color=colour, markersize=5.5, zorder=3)
        axes.plot(seen, at, "o", color=colour, markerfacecolor="white", markersize=5.5, zorder=4)
    values = [
        MICRORADIAN * value
        for one in result.models
        for value in (one.errors.rmse_rad, one.errors.heldout_rmse_rad)
    ]
    low, high = min([floor, *values]) / 1.6, 1.6 * max([floor, *values])
    axes.set_xlim(low, high)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: significant(float(value), 1)))
    axes.xaxis.set_minor_formatter(FuncFormatter(lambda value, _: ""))
    axes.set_xlabel("error [µrad]")
    axes.set_title("Error")


def _alt(result: Comparison) -> str:
    level = result.level
    best = listed(one.words for one in level)
    text = f"Best: {best}"
    behind = [one for one in result.models if one not in level]
    if behind:
        text += f"; next {behind[0].words}, {difference(behind[0])} behind"
    error = micro(result.models[0].errors.heldout_rmse_rad)
    return f"{text}. Error of the best on left-out parts {error} µrad."
