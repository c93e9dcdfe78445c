"""Tables of what the model lacked over a drive's tests: each test, and the hours left."""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.explanation import DriveExplanation, ErrorFigures
from hdprog.reporting.effect_words import effect_name, remaining_cells
from hdprog.reporting.error_words import LEFT_OUT, micro
from hdprog.reporting.rounding import hours
from hdprog.reporting.sections.effects_tables import column_head, names
from hdprog.reporting.sections.table import Row, Table, Value
from hdprog.reporting.words import listed

VERDICTS: Mapping[str, str] = {
    "adequate": "nothing added",
    "explained": "explained",
    "partly_explained": "explained in part",
    "unexplained": "unexplained",
}


def tests_table(found: DriveExplanation) -> Table:
    """Verdict, errors and effects of every test."""
    rows = [
        Row(
            test.test_id,
            (
                "not given" if test.service_hours is None else hours(test.service_hours),
                VERDICTS[test.verdict],
                _error(test.before),
                _error(test.after),
                micro(test.noise_floor_rad),
                names(test.effects) + _not_shown(found, test.test_id),
            ),
            doubtful=not test.converged,
        )
        for test in found.tests
    ]
    return Table.flat(
        "Each test by itself. Error: root mean square of measured minus fitted angle, below it "
        f"{LEFT_OUT}.",
        (
            "test",
            "at",
            "verdict",
            "error, drive model alone [µrad]",
            "error, with effects [µrad]",
            "noise floor [µrad]",
            "added",
        ),
        rows,
    )


def _not_shown(found: DriveExplanation, test_id: str) -> str:
    hidden = [effect_name(name) for name in found.not_shown_by(test_id)]
    return f" (cannot show {listed(hidden, 'or')})" if hidden else ""


def _error(errors: ErrorFigures) -> Value:
    return Value(micro(errors.rmse_rad), f"left out: {micro(errors.heldout_rmse_rad)}")


def remaining_table(found: DriveExplanation) -> Table | None:
    """Hours left with and without the effects; None where nothing was forecast."""
    before, after = found.remaining_hours_before, found.remaining_hours_after
    if before is None or after is None:
        return None
    rows = [
        Row("drive model alone", remaining_cells(before)),
        Row(column_head(found.effects), remaining_cells(after)),
    ]
    return Table.flat(
        "Hours from the last test until the first limit is passed; “later” is past the horizon.",
        ("model", "5 %", "median", "95 %"),
        rows,
        doubtful=not all(test.converged for test in found.tests),
    )
