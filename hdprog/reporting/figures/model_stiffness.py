"""Local stiffness over torque as each model has it."""

from __future__ import annotations

import numpy as np

from hdprog.comparison.results import DRIVE, ComparedModel, Comparison
from hdprog.reporting.axes import THOUSANDS
from hdprog.reporting.picture_data import PictureData
from hdprog.reporting.rounding import significant
from hdprog.reporting.style import FIT, Picture, new_figure, picture
from hdprog.reporting.words import torque_words

# Okabe and Ito's colours, each with a line of its own, so that a grey print can be read.
_LOOKS: dict[str, tuple[str, str | tuple[float, tuple[float, ...]]]] = {
    DRIVE: (FIT, "-"),
    "tuttle": ("#999999", "-."),
    "catalogue_piecewise": ("#3d4852", "--"),
    "cubic": ("#E69F00", "-."),
    "dhaouadi": ("#D55E00", (0, (5, 1.5))),
    "zhang": ("#009E73", (0, (3, 1, 1, 1))),
    "seyfferth": ("#CC79A7", (0, (1.2, 1.2))),
    "taghirad": ("#8F2D77", (0, (6, 1, 1, 1, 1, 1))),
    "preisach": ("#56B4E9", (0, (2, 1))),
    "maxwell_slip": ("#7a6a00", (0, (4, 2, 1, 2))),
}
_SPARE = ("#1c2430", ":")


def model_stiffness(result: Comparison) -> Picture:
    """Curves of all models that yield, with the drive model's 90 % band."""
    figure = new_figure(7.6, 3.9)
    axes = figure.add_axes((0.095, 0.13, 0.56, 0.83))
    shown = [one for one in result.models if one.stiffness is not None]
    for one in reversed(shown):
        band = one.stiffness
        assert band is not None
        colour, line = _LOOKS.get(one.id, _SPARE)
        own = one.id == DRIVE
        axes.plot(
            band.torque,
            1e-3 * band.quantiles[0.5],
            color=colour,
            linestyle=line,
            linewidth=2.2 if own else 1.5,
            zorder=4 if own else 3,
            label=one.words + ("" if one.converged else " *"),
        )
        if own:
            low, high = (1e-3 * band.quantiles[level] for level in (0.05, 0.95))
            axes.fill_between(band.torque, low, high, color=colour, alpha=0.2, linewidth=0)
    axes.set_xlabel("torque [Nm]")
    axes.set_ylabel("local stiffness [kNm/rad]")
    axes.set_ylim(0.0, 1.08e-3 * _top(shown))
    axes.margins(x=0.01)
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.yaxis.set_major_formatter(THOUSANDS)
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(
        handles[::-1],
        labels[::-1],
        loc="upper left",
        bbox_to_anchor=(1.01, 1.0),
        handlelength=3.2,
        title="best first",
        alignment="left",
    )
    return picture(
        figure,
        alt=_alt(result, shown),
        shows=(
            "Slope of torque over torsion angle on each model's stiffness curve (posterior "
            "median), for the drive model with its 90 % band. Models without such a curve of "
            "their own (Preisach, Maxwell slip) show that of the middle of their loop, between "
            "torques some per cent apart."
        ),
        good="the models that predict well run together.",
        bad="they part: the stiffness there is the model's word, not the record's.",
        action="quote a stiffness with the model that it comes from where the curves part.",
        data=_data(shown),
    )


def _data(shown: list[ComparedModel]) -> PictureData:
    """Every model's curve with its band."""
    rows = []
    for one in shown:
        band = one.stiffness
        assert band is not None
        levels = (band.quantiles[level].tolist() for level in (0.05, 0.5, 0.95))
        rows += [(one.words, *values) for values in zip(band.torque.tolist(), *levels, strict=True)]
    named = (f"local stiffness, {level} % [Nm/rad]" for level in (5, 50, 95))
    return PictureData.of("local-stiffness", ("model", "torque [Nm]", *named), rows)


def _top(shown: list[ComparedModel]) -> float:
    """Largest stiffness to show in Nm/rad: what a few wild points exceed is cut."""
    tops = [
        float(np.nanquantile(one.stiffness.quantiles[0.5], 0.97))
        for one in shown
        if one.stiffness is not None
    ]
    return 1.25 * float(np.median(tops)) if len(tops) > 2 else max(tops)


def _alt(result: Comparison, shown: list[ComparedModel]) -> str:
    curves = {one.id: one.stiffness.quantiles[0.5] for one in shown if one.stiffness is not None}
    which, curve = "best", curves.get(result.models[0].id)
    if curve is None:  # of the rigid model
        which, curve = "drive", curves[DRIVE]
    return (
        f"On the {which} model the local stiffness runs from {significant(float(np.nanmin(curve)))}"
        f" to {significant(float(np.nanmax(curve)))} Nm/rad up to {torque_words(result.amplitude)}."
    )
