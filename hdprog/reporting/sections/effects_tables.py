"""Tables of what the model lacked: errors, carriers, parameters, bias, what was not added."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hdprog.explanation import (
    UNKNOWN,
    Carrier,
    ConsideredEffect,
    Explanation,
    FoundEffect,
    Quantiles,
)
from hdprog.reporting.bias import Shift, shifts
from hdprog.reporting.effect_words import coordinate, effect_name
from hdprog.reporting.error_words import LEFT_OUT, micro
from hdprog.reporting.geometry import MICRORADIAN
from hdprog.reporting.reader_units import shown
from hdprog.reporting.rounding import (
    THIN_SPACE,
    grouped,
    interval,
    rounded,
    significant,
)
from hdprog.reporting.sections.table import Group, Row, Table, Value
from hdprog.reporting.words import (
    agree,
    capital,
    listed,
    parameter_factor,
    parameter_meaning,
    parameter_name,
    quantity,
    spoken,
    tidy,
)
from hdprog.results import EffectSummary

_NAMED = 2  # effects, at most, that the head of a column names
_CLEAR = 0.5  # standard deviations; a smaller shift is not worth a number
_SMALL_ANGLE = 0.01  # rad; above it an angle is a phase and no small error


def names(effects: Sequence[FoundEffect]) -> str:
    """Names of effects, "none" without any."""
    return listed(effect_name(effect.id) for effect in effects) or "none"


def column_head(effects: Sequence[FoundEffect]) -> str:
    """Head of the column with effects: their names where they are few."""
    return f"with {names(effects) if len(effects) <= _NAMED else 'what was added'}"


def error_table(found: Explanation) -> Table:
    """Error of the fit before and after, and what to hold it against."""
    before, after = found.before, found.after
    rows = [
        ("on the data fitted", micro(before.rmse_rad), micro(after.rmse_rad)),
        (LEFT_OUT, micro(before.heldout_rmse_rad), micro(after.heldout_rmse_rad)),
        (
            "just after reversals",
            micro(before.reversal_rmse_rad),
            micro(after.reversal_rmse_rad),
        ),
        *(
            (f"{spoken(branch)} branch", micro(old), micro(new))
            for branch, (old, new) in found.branch_rmse.items()
        ),
    ]
    floor, own = micro(found.noise_floor_rad), micro(found.repeatability_rad)
    against = [("noise floor", floor, floor)]
    if found.repeatability_rad is not None:
        against.append(("repeatability of the record's own cycles", own, own))
    likeness = (
        "likeness of neighbours (0 none, 1 full)",
        _signed(before.lag1),
        _signed(after.lag1),
    )
    columns: tuple[str, ...] = ("error", "drive model alone", column_head(found.effects))
    groups = [
        ("Root mean square of measured minus fitted angle [µrad]", rows),
        ("To hold it against [µrad]", against),
        ("Correlation of the residual with itself one reading on", [likeness]),
    ]
    cut = len(columns) if found.effects else 2
    return Table(
        "Error of the fit. Just after reversals: within 5 % of the torque span. An error at the "
        "noise floor and a likeness near 0 leave nothing to explain.",
        columns[:cut],
        tuple(
            Group(title, tuple(Row(head, tuple(cells[: cut - 1])) for head, *cells in part))
            for title, part in groups
        ),
        doubtful=not found.converged,
    )


def _signed(value: float) -> str:
    return grouped(value, 2)


def carrier_table(carried_by: Sequence[Carrier]) -> Table:
    """How much of the residual each coordinate carries."""
    rows = [
        Row(
            capital(coordinate(carrier.coordinate).name),
            (f"{100.0 * carrier.fraction:.0f}{THIN_SPACE}%", _p_value(carrier.p_value)),
        )
        for carrier in sorted(carried_by, key=lambda c: -c.fraction)
    ]
    return Table.flat(
        "What the residual of the drive model alone goes with: the share of its variance that a "
        "smooth curve over one coordinate predicts on data left out. Below a p-value of 0.05 "
        "chance does not explain it (corrected for the number of coordinates).",
        ("coordinate", "share carried", "p-value"),
        rows,
    )


def _p_value(value: float) -> str:
    return "below 0.001" if value < 1e-3 else significant(min(value, 1.0), 2)


def parameter_table(
    effects: Sequence[FoundEffect | EffectSummary], note: str, *, doubtful: bool
) -> Table | None:
    """Parameters of the effects with their units; None where they have none."""
    groups = tuple(
        Group(
            capital(effect_name(effect.id)),
            tuple(
                _parameter(name.removeprefix(f"{effect.id}."), levels, effect.units.get(name, ""))
                for name, levels in effect.parameters.items()
            ),
        )
        for effect in effects
        if effect.parameters
    )
    if not groups:
        return None
    columns = ("parameter", "5 %", "median", "95 %", "unit")
    return Table(f"Size of what was added{note}.", columns, groups, doubtful=doubtful)


def _parameter(name: str, levels: Quantiles, unit: str) -> Row:
    values = [levels[level] for level in (0.05, 0.50, 0.95)]
    if unit.startswith("rad") and max(map(abs, values)) < _SMALL_ANGLE:
        values, unit = [MICRORADIAN * value for value in values], f"µ{unit}"
    seen = shown(unit)
    low, middle, high = interval(*(seen.factor * value for value in values))
    unit = seen.unit
    return Row(spoken(name), (low, middle, high, "" if unit == "-" else unit))


def bias_table(found: Explanation, note: str = "") -> Table:
    """Every parameter and figure without and with the effects, the largest shift first."""
    both = shifts(found)
    groups = tuple(
        Group(title, tuple(_shift(shift) for shift in both if shift.is_figure == figures))
        for title, figures in (("Figures of merit", True), ("Parameters", False))
        if any(shift.is_figure == figures for shift in both)
    )
    columns = (
        "quantity",
        "drive model alone",
        column_head(found.effects),
        "was off by",
        "shift [standard deviations]",
    )
    lacked = agree(len(found.effects), "effect", "effects")
    return Table(
        f"What the missing {lacked} did to the numbers{note}: median, below it the 90 % interval; "
        "largest shift first. Shift: change of the median over the standard deviation that the "
        "drive model alone had claimed. Beyond 2 the claim was wrong.",
        columns,
        groups,
        doubtful=not found.converged,
    )


def shift_name(shift: Shift) -> str:
    """Name of a shifted quantity with its unit's meaning where it has one."""
    return quantity(shift.key).name if shift.is_figure else parameter_name(shift.key)


def off_words(shift: Shift) -> str:
    """How far a quantity was off: "12 % too low"; an en dash where nothing can be said.

    Of `c`, which may be negative, a part of itself says nothing where it is more than the whole.
    """
    off = shift.off_by
    if off is None or not math.isfinite(off):
        return "–"
    if abs(off) < 0.0005:
        return f"less than 0.1{THIN_SPACE}%"
    size = abs(off)
    way = "high" if off > 0 else "low"
    if size >= 1.0 and shift.key == "c" and (off < 0 or shift.after[0.50] < 0):
        return f"{significant(abs(shift.before[0.50] - shift.after[0.50]), 2)} too {way}"
    if size >= 2.0:
        return f"{significant(1.0 + size, 2)} times too {way}"
    return f"{significant(100.0 * size, 2)}{THIN_SPACE}% too {way}"


def _shift(shift: Shift) -> Row:
    by = "–" if shift.deviations is None else _deviations(shift.deviations)
    clear = shift.deviations is None or abs(shift.deviations) >= _CLEAR
    off = off_words(shift) if clear else "within its spread"
    named = quantity(shift.key)
    factor = named.factor if shift.is_figure else parameter_factor(shift.key)
    cells = (Value.of(shift.before, factor), Value.of(shift.after, factor), off, by)
    if shift.is_figure:
        return Row(capital(named.head), cells)
    return Row(parameter_name(shift.key), cells, note=parameter_meaning(shift.key))


def _deviations(value: float) -> str:
    return ("+" if value >= 0.05 else "") + grouped(value, 1)


def considered_table(considered: Sequence[ConsideredEffect]) -> Table | None:
    """What was looked at and not added, and why; None where nothing was."""
    if not considered:
        return None
    rows = [
        Row(
            capital(effect_name(effect.id)),
            (
                _gain(effect.log_evidence_gain),
                _gain(effect.elpd_gain, effect.elpd_se),
                tidy(effect.why_not),
            ),
            note="" if effect.id == UNKNOWN else effect.words,
        )
        for effect in considered
    ]
    columns = ("effect", "gain of log evidence", "gain on left-out blocks", "why it was not added")
    return Table.flat("Looked at and not added.", columns, rows)


def _gain(value: float | None, error: float | None = None) -> str:
    if value is None or not math.isfinite(value):
        return "–"
    if error is None or not math.isfinite(error) or error <= 0:
        return rounded(value, 2.0)
    return gain_words(value, error)


def gain_words(value: float, error: float) -> str:
    """Gain with its standard error, rounded by it: "38 ± 7"."""
    return f"{rounded(value, error / 2.0)} ± {rounded(error, error / 2.0)}"
