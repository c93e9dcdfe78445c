"""A comparison of models in plain words, and as a table for the screen."""

from __future__ import annotations

import math

from hdprog.comparison.results import DRIVE, ComparedModel, Comparison, StiffnessBand
from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.reporting.error_words import micro
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.rounding import interval, rounded, share, significant
from hdprog.reporting.verdict import Verdict
from hdprog.reporting.words import agree, capital, keyboard_signs, listed, tidy, torque_words

_NO_WIDTH = 0.002  # arcmin: no rig tells it from nothing
_STRUCTURE = 1.5  # times the noise floor: an error beyond it is more than noise


_NUMBERS = dict(enumerate(("no", "one", "two", "three", "four", "five", "six", "seven"))) | {
    8: "eight",
    9: "nine",
    10: "ten",
    11: "eleven",
}


def verdict(result: Comparison) -> Verdict:
    """Which models predict the record best, how well, and what they agree on."""
    said = [] if result.converged else [result.warnings[0]]
    said += [_best(result), *_drive(result), _error(result), *_agreement(result)]
    best = result.models[0]
    level = len(result.level)
    label = (
        f"{capital(best.words)} predicts best"
        if level == 1
        else f"{capital(_NUMBERS[level])} models level"
    )
    if not result.converged:
        label += " \u2013 provisional"
    return Verdict("present", not result.converged, label, tuple(map(tidy, said)))


def _best(result: Comparison) -> str:
    best, *others = result.level
    name = capital(_named(best))
    if others:
        return (
            f"{name} predicts this record best, but {listed(one.words for one in others)} cannot "
            "be told from it."
        )
    following = next((one for one in result.models if one is not best), None)
    if following is None:
        return f"{name} is the only model that can be defined on this record."
    return (
        f"{name} predicts this record best; next comes {following.words}, "
        f"{difference(following)} behind in log predictive density."
    )


def _named(model: ComparedModel) -> str:
    return f"the {model.words}" if model.id == DRIVE else model.words


def _drive(result: Comparison) -> list[str]:
    """Where the drive model stands, if it is not among the best."""
    drive = result.of(DRIVE)
    if drive in result.level:
        return []
    place = result.models.index(drive) + 1
    return [
        f"The drive model comes {_ordinal(place)}, {difference(drive)} behind: the record carries "
        "what it lacks. `hdprog explain` looks for that."
    ]


def _ordinal(place: int) -> str:
    return {1: "first", 2: "second", 3: "third"}.get(place, f"{place}th")


def _error(result: Comparison) -> str:
    best = result.models[0]
    error, floor = best.errors.heldout_rmse_rad, result.noise_floor_rad
    noise = error < _STRUCTURE * floor
    said = (
        f"On parts of the record that it did not see its error is {micro(error)} µrad, "
        f"{'about the noise' if noise else 'more than noise'} ({micro(floor)} µrad)."
    )
    if noise or result.of(DRIVE) not in result.level:
        return said
    return f"{said} `hdprog explain` looks for what the drive model lacks."


def _agreement(result: Comparison) -> list[str]:
    """What the models with as small an error say of the local stiffness at the largest torque."""
    level = [one for one in result.level if one.stiffness is not None]
    if not level:
        return []
    named = {one.id: stiffness_at_end(one) for one in level}
    low, high = min(named.values()), max(named.values())
    at = torque_words(result.amplitude)
    if len(level) == 1:
        whose = "Its" if level[0] is result.models[0] else f"By {_named(level[0])} the"
        return [f"{whose} local stiffness at {at} is {significant(low)} Nm/rad."]
    apart = share(round((high - low) / low, 3))
    return [
        f"{agree(len(level), 'It puts', 'They put')} the local stiffness at {at} between "
        f"{significant(low)} and {significant(high)} Nm/rad, {apart} apart."
    ]


def stiffness_at_end(model: ComparedModel) -> float:
    """Median local stiffness in Nm/rad at the largest torque of the cycle."""
    assert model.stiffness is not None
    return at_end(model.stiffness)[1]


def at_end(band: StiffnessBand) -> tuple[float, float, float]:
    """Local stiffness in Nm/rad (5, 50, 95 %) at the largest torque of the cycle.

    The end at positive torque of a two-sided one: not every model is alike at both.
    """
    end = -1 if band.torque[-1] > 0 else 0
    low, middle, high = (float(band.quantiles[level][end]) for level in (0.05, 0.5, 0.95))
    return low, middle, high


def difference(model: ComparedModel) -> str:
    """How far a model is behind the best, with its standard error."""
    evidence = model.evidence
    if evidence.difference == 0:
        return "0"
    spread = evidence.difference_se
    return f"{rounded(evidence.difference, spread)} ± {rounded(spread, spread)}"


def width(model: ComparedModel) -> tuple[str, str]:
    """Median width in arcmin, and its interval."""
    low, middle, high = (ARCMIN_PER_RAD * model.width[level] for level in (0.05, 0.5, 0.95))
    if middle < _NO_WIDTH:
        return "0", f"up to {significant(_raised(max(high, _NO_WIDTH)), 1)}"
    texts = interval(low, middle, high)
    return texts[1], f"{texts[0]} to {texts[2]}"


def _raised(value: float) -> float:
    """Round up to one digit, as an upper bound must be."""
    step = 10.0 ** math.floor(math.log10(value))
    return math.ceil(value / step - 1e-9) * step


def screen(result: Comparison) -> str:
    """The verdict and a table of plain text."""
    head = ("model", "RMSE", "held-out", "behind in elpd", "weight", "width", "stiffness")
    units = ("", "µrad", "µrad", "± s.e.", "", "arcmin", "Nm/rad")
    rows = [head, units]
    rows += [
        (
            model.words + ("" if model.converged else " *"),
            significant(MICRORADIAN * model.errors.rmse_rad, 3),
            significant(MICRORADIAN * model.errors.heldout_rmse_rad, 3),
            difference(model),
            f"{model.evidence.weight:.2f}",
            width(model)[0],
            "–" if model.stiffness is None else significant(stiffness_at_end(model)),
        )
        for model in result.models
    ]
    wide = [max(len(row[column]) for row in rows) for column in range(len(head))]
    lines = [
        "  ".join(
            cell.ljust(wide[0]) if column == 0 else cell.rjust(wide[column])
            for column, cell in enumerate(row)
        ).rstrip()
        for row in rows
    ]
    lines += [f"left out: {one.words}: {one.why}" for one in result.left_out]
    if not result.converged:
        lines.append("* not converged")
    at = torque_words(result.width_torque)
    lines.append(f"width at {at}, local stiffness at {torque_words(result.amplitude)}.")
    return keyboard_signs("\n".join([verdict(result).text, "", *lines]))
