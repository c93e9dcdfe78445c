"""Tables and words of the report on the paper's reproduction."""

from __future__ import annotations

from collections.abc import Sequence

from hdprog.reporting.rounding import significant
from hdprog.reporting.sections.method import Passage
from hdprog.reporting.sections.table import Row, Table, Value
from hdprog.reporting.words import capital, parameter_name, quantity, tidy
from hdprog.reproduction.results import Finding, Recovery, Reproduction


def claims(findings: Sequence[Finding], caption: str) -> Table:
    """The paper's claims with what came out."""
    rows = [Row(one.figure, (tidy(one.claim), tidy(one.came_out), one.outcome)) for one in findings]
    return Table.flat(caption, ("figure", "the paper says", "came out", ""), rows)


def recovery(one: Recovery) -> Table:
    """Truth and posterior of one record."""
    rows = []
    for name, levels in one.found.items():
        held = levels[0.05] <= one.truth[name] <= levels[0.95]
        rows.append(
            Row(
                _name(name),
                (
                    significant(one.truth[name], 4),
                    Value.of(levels),
                    "yes" if held else "no",
                    tidy(f"{one.deviations[name]:+.1f}"),
                ),
            )
        )
    return Table.flat(
        f"The {one.label} record: what it was made with, and the posterior with its 90 % interval; "
        "deviation in posterior standard deviations.",
        ("number", "Table 2", "posterior", "inside", "deviation"),
        rows,
        doubtful=not one.converged,
    )


def _name(name: str) -> str:
    named = {"combined_stiffness_Nm_per_rad": "Combined stiffness K (38)", "c_T_i_Nm": "c·T_i"}
    if name in named:
        return named[name]
    known = parameter_name(name)
    return known if "_" not in name or len(name) < 4 else capital(quantity(name).name)


def method(result: Reproduction) -> list[Passage]:
    """How the numbers came about."""
    return [
        Passage(
            "What is taken from the paper",
            "The parameters of its Table 2. The tooth angle, which it does not state, is 30°; the "
            "loops run to ± 100 Nm, as its figures seem to. The tooth-mesh torsion is the integral "
            "unless said otherwise.",
        ),
        Passage(
            "Fits",
            "Dhaouadi's and Zhang's models are fitted by least squares from several starts to "
            "records made with Table 2, with the noise and resolution of the published rig (0.1 "
            "Nm, 0.00056°). The cubic is fitted to the stiffness curve by least squares of the "
            "torque, as (9) is written; the piecewise line by least squares of the angle, with "
            "the catalogue's thresholds of 14 and 48 Nm.",
        ),
        Passage(
            "Recovery",
            "Two cycles to ± 100 Nm, 1 201 readings, are made with each column of Table 2 and "
            "fitted as any record is, with the prior of the CSF-25-80.",
        ),
    ]
