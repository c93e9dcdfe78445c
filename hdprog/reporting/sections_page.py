"""The page of a report that is made of sections: of a backtest, a comparison, a reproduction."""

from __future__ import annotations

from collections.abc import Sequence

from hdprog.reporting.build import environment
from hdprog.reporting.sections.method import Passage
from hdprog.reporting.sections.provenance import provenance
from hdprog.reporting.sections.section import Section
from hdprog.reporting.verdict import Verdict
from hdprog.results import Provenance


def sections_page(
    name: str,
    facts: Sequence[str],
    said: Verdict,
    warnings: Sequence[str],
    sections: Sequence[Section],
    method: Sequence[Passage],
    made: Provenance,
    *,
    command: str,
    title: str | None = None,
) -> str:
    """Page as HTML.

    Parameters
    ----------
    name : of what is reported on
    facts : that stand below it, the day of the report after them
    said : the verdict
    warnings, sections, method : in this order
    made : how it came about
    command : that makes such reports
    title : what ends the title of the page, the command if None
    """
    return (
        environment()
        .get_template("sections.html")
        .render(
            kicker=command,
            title=f"{name} \u2013 {said.label} \u2013 {title or command}",
            name=name,
            subtitle=" · ".join([*facts, f"report of {made.created[:10]}"]),
            verdict=said,
            warnings=warnings,
            sections=sections,
            method=method,
            provenance=provenance(made),
        )
    )
