"""Tables of what the parameters and figures rest on: the record, the prior, the tooth angle."""

from __future__ import annotations

import math
from collections.abc import Mapping

from hdprog.reporting.reader_units import shown
from hdprog.reporting.rounding import (
    THIN_SPACE,
    grouped,
    interval,
    percent,
    plain,
    significant,
)
from hdprog.reporting.sections.table import Cell, Row, Table, Value
from hdprog.reporting.weak_words import LEAST_CHANGE, moved_by_angle, not_reached
from hdprog.reporting.words import (
    agree,
    capital,
    listed,
    parameter_factor,
    parameter_meaning,
    parameter_name,
    quantity,
    with_unit,
)
from hdprog.results import (
    Diagnosis,
    DriveResult,
    Identification,
    Sensitivity,
    TestResult,
)

_RESTS_ON: dict[Diagnosis, str] = {
    "record": "the record",
    "shared": "both",
    "prior": "the prior",
    "conflict": "they disagree",
    "overruled": "record against prior",
}


def rests_on(result: DriveResult) -> list[Table]:
    """Parameters known together, what leans on the prior, and what on the tooth angle."""
    found = [_together(result), _leaning(result), _tooth_angle(result.tests[-1])]
    return [table for table in found if table is not None]


def _together(result: DriveResult) -> Table | None:
    states = [(test, test.identification) for test in result.tests]
    if not any(state is not None and _weak(state) for _, state in states):
        return None
    rows = [
        Row(
            test.test_id,
            (
                Value.of(state.combined_stiffness.quantiles, shown("Nm/rad").factor),
                "no" if state.one_spring else "yes",
                Value.of(state.no_load_friction.quantiles, shown("Nm").factor),
                significant(shown("Nm").factor * state.largest_torque),
                percent(state.beyond_record),
            ),
            doubtful=not test.converged,
        )
        for test, state in states
        if state is not None
    ]
    columns = (
        "test",
        f"stiffness K of cup and teeth [{shown('Nm/rad').unit}]",
        "K_F, a, b, T_T told apart",
        f"friction at no load [{shown('Nm').unit}]",
        f"largest torque [{shown('Nm').unit}]",
        "T_i beyond it",
    )
    caption = (
        "What is known together: median, below it the 90 % interval. K: 1/K = 1/K_F + "
        "1/(a·T_T + b); where its parts are not told apart, use K. Friction at no load: "
        "−c·μ·T_i; where T_i lies beyond the largest torque, use it instead of its factors, or "
        "load beyond T_i if the drive allows it."
    )
    return Table.flat(caption, columns, rows)


def _weak(state: Identification) -> bool:
    return state.one_spring or not_reached(state)


def _leaning(result: DriveResult) -> Table | None:
    names = dict.fromkeys(name for test in result.tests for name in test.sensitivity)
    told = {name: [test.sensitivity.get(name) for test in result.tests] for name in names}
    rows = [
        Row(_name(name), tuple(map(_rest, found)))
        for name, found in told.items()
        if any(one is not None and one.diagnosis != "record" for one in found)
    ]
    if not rows:
        return None
    caption = (
        "What each number rests on; what is not listed rests on the record alone. Below: how fast "
        "it moves with the weight of the prior, and of the record (power-scaling sensitivity; 0.05 "
        "counts and is a shift by about 0.3 standard deviations where a weight is doubled)."
    )
    return Table.flat(
        caption,
        ("number", *(test.test_id for test in result.tests)),
        rows,
        doubtful=not all(test.converged for test in result.tests),
    )


def _name(name: str) -> str:
    return parameter_name(name) if parameter_meaning(name) else capital(quantity(name).name)


def _rest(found: Sensitivity | None) -> Cell:
    if found is None:
        return "–"
    spread = f"prior {grouped(found.prior, 2)}, record {grouped(found.record, 2)}"
    return Value(_RESTS_ON[found.diagnosis], spread)


def _tooth_angle(test: TestResult) -> Table | None:
    other = test.other_tooth_angle
    if other is None:
        return None
    now, then = (f"{plain(round(math.degrees(a), 6))}°" for a in (test.drive.alpha, other.alpha))
    moved = moved_by_angle(test)
    rows = []
    for name in moved:
        summary = test.parameters.get(name)
        levels = test.figures[name] if summary is None else summary.quantiles
        changed = other.figures[name] if summary is None else other.parameters[name]
        factor = quantity(name).factor if summary is None else parameter_factor(name)
        before, after = (
            interval(*(factor * values[at] for at in (0.05, 0.50, 0.95)))
            for values in (levels, changed)
        )
        change = _change(levels, changed)
        cells = (
            Value(significant(factor * levels[0.50]), f"{before[0]} to {before[2]}"),
            Value(significant(factor * changed[0.50]), f"{after[0]} to {after[2]}"),
            "–" if change is None else with_unit(grouped(100 * change, 0), "%"),
        )
        unit = quantity(name).unit if summary is None else ""
        rows.append(Row(_name(name), cells, note=parameter_meaning(name) or unit))
    changes = {key: _change(test.figures[key], changed) for key, changed in other.figures.items()}
    still = {
        key: change for key, change in changes.items() if key not in moved and change is not None
    }
    caption = (
        f"The gear-tooth angle is not declared; {now} is assumed. With {then}, test "
        f"{test.test_id} gives what is below; where that matters, set alpha_deg in drive.toml."
    )
    if still:
        most = max(map(abs, still.values()))
        names = [quantity(key).name for key in still]
        kinds = dict.fromkeys("stiffness" if "stiffness" in name else name for name in names)
        caption += (
            f" {capital(listed(kinds))} {agree(len(kinds), 'changes', 'change')} by less than "
            f"{_up(100 * most)}{THIN_SPACE}%. Parameters that are not listed change by less than "
            f"{100 * LEAST_CHANGE:g}{THIN_SPACE}% or stay well inside their intervals."
        )
    return Table.flat(
        caption, ("number", f"{now}, assumed", then, "change"), rows, doubtful=not test.converged
    )


def _change(levels: Mapping[float, float], changed: Mapping[float, float]) -> float | None:
    """Part by which a median changed; None from zero, as the width of a loop without friction."""
    return changed[0.50] / levels[0.50] - 1 if levels[0.50] != 0 else None


def _up(value: float) -> str:
    """A bound that is not below the value, to a tenth."""
    return grouped(math.ceil(10 * value + 1e-9) / 10, 1)
