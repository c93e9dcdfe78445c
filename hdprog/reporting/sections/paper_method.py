"""The paper's own identification beside the posterior, with where it fails."""

from __future__ import annotations

from dataclasses import dataclass

from hdprog.physics.parameters import NAMES
from hdprog.reporting.error_words import micro
from hdprog.reporting.rounding import significant
from hdprog.reporting.sections.table import Row, Table, Value
from hdprog.reporting.words import (
    agree,
    capital,
    listed,
    parameter_factor,
    parameter_meaning,
    parameter_name,
    quantity,
    torque_words,
)
from hdprog.results import PaperIdentification, TestResult

_APART = 1.2  # times the other error: as good as equal below


@dataclass(frozen=True)
class PaperMethod:
    """What the page says of the identification: paragraphs, then the table."""

    paragraphs: tuple[str, ...]
    table: Table


def paper_method(test: TestResult) -> PaperMethod | None:
    """The identification of a test beside its posterior; None where it was not asked for."""
    found = test.paper
    if found is None:
        return None
    said = (
        "Five points read off the loop give the parameters for given friction and preload "
        "(29-34); these two are moved until the squared errors of both branches at positive "
        "torque are least (37). The paper picks the points by hand, here a rule does.",
        *where_it_fails(test),
    )
    return PaperMethod(said, _table(test, found))


def where_it_fails(test: TestResult) -> list[str]:
    """What the point estimate cannot say, and where it goes wrong on this record."""
    found = test.paper
    if found is None:
        return []
    said = [
        "It gives no error of its own: nothing in it says how far a number can be trusted.",
        f"The threshold T_T is read where the loading branch seems to turn straight, "
        f"{torque_words(found.threshold_read)} here. This choice and others, other "
        f"readings of it or other points, lead to the values in the last column: "
        f"{found.choices_solved} of {found.choices_tried} give an answer at all.",
    ]
    if not found.by_rule:
        said.append(
            "The rule's own points give no answer on this record: the numbers are those of the "
            "first other choice that does."
        )
    missed = [name for name in NAMES if not _inside(test, name, found.parameters[name])]
    if missed:
        names = listed(parameter_name(name) for name in missed)
        said.append(
            f"{capital(agree(len(missed), 'its value of', 'its values of'))} {names} "
            f"{agree(len(missed), 'lies', 'lie')} outside the posterior's 90 % interval."
        )
    if found.rmse_rad > _APART * test.rmse_rad:
        said.append(
            f"It leaves {micro(found.rmse_rad)} µrad at positive torque, "
            f"the posterior {micro(test.rmse_rad)} µrad over the record."
        )
    return said


def _inside(test: TestResult, name: str, value: float) -> bool:
    quantiles = test.parameters[name].quantiles
    return quantiles[0.05] <= value <= quantiles[0.95]


def _table(test: TestResult, found: PaperIdentification) -> Table:
    rows = []
    for name in NAMES:
        quantiles, factor = test.parameters[name].quantiles, parameter_factor(name)
        least, largest = (factor * value for value in found.other_choices[name])
        rows.append(
            Row(
                parameter_name(name),
                (
                    significant(factor * found.parameters[name]),
                    Value.of(quantiles, factor),
                    "yes" if _inside(test, name, found.parameters[name]) else "no",
                    f"{significant(least)} to {significant(largest)}",
                ),
                note=parameter_meaning(name),
            )
        )
    for key, value in found.figures.items():
        levels = test.figures[key]
        named = quantity(key)
        rows.append(
            Row(
                capital(named.name),
                (
                    significant(named.factor * value),
                    Value.of(levels, named.factor),
                    "yes" if levels[0.05] <= value <= levels[0.95] else "no",
                    "–",
                ),
                note=named.unit,
            )
        )
    return Table.flat(
        f"Test {test.test_id}: the paper's identification, and the posterior with its 90 % "
        "interval.",
        ("number", "five points", "posterior", "inside", "with other points"),
        rows,
        doubtful=not test.converged,
    )
