"""The report of a comparison of models: one self-contained HTML page."""

from __future__ import annotations

from hdprog.comparison.results import Comparison
from hdprog.reporting.build import environment
from hdprog.reporting.comparison_words import verdict
from hdprog.reporting.figures.model_loops import model_loops
from hdprog.reporting.figures.model_ranking import model_ranking
from hdprog.reporting.figures.model_stiffness import model_stiffness
from hdprog.reporting.sections import comparison as tables
from hdprog.reporting.sections import provenance
from hdprog.reporting.sections.section import Section
from hdprog.reporting.style import house_style
from hdprog.reporting.words import counted, torque_words


def build_comparison_report(result: Comparison) -> str:
    """Report of a comparison as HTML, without anything to fetch and without scripts."""
    said = verdict(result)
    with house_style():
        sections = [
            Section(
                "ranking",
                "Which model predicts the record",
                (),
                (("", model_ranking(result)),),
                (tables.ranking(result),),
            ),
            Section(
                "stiffness",
                "Local stiffness",
                (),
                (("", model_stiffness(result)),),
                (),
            ),
            Section("loops", "What each model leaves over", (), (("", model_loops(result)),), ()),
            Section("models", "The models", (), (), (tables.identities(result),)),
            Section(
                "parameters",
                "Parameters and sampling",
                (),
                (),
                (tables.parameters(result), tables.sampling(result)),
            ),
        ]
    name = result.loop.source.rpartition("/")[2]
    parts = [
        counted(len(result.models), "model"),
        counted(len(result.loop), "reading"),
        ("two-sided" if result.two_sided else "one-sided")
        + f" cycle to {torque_words(result.amplitude)}",
        f"report of {result.provenance.created[:10]}",
    ]
    return (
        environment()
        .get_template("sections.html")
        .render(
            kicker="hdprog compare",
            title=f"{name} \u2013 {said.label} \u2013 hdprog compare",
            name=name,
            subtitle=" · ".join(parts),
            verdict=said,
            warnings=tables.warnings(result),
            sections=sections,
            method=tables.method(result),
            provenance=provenance.provenance(result.provenance),
        )
    )
