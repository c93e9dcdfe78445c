"""The report of a comparison of models: one self-contained HTML page."""

from __future__ import annotations

from hdprog.comparison.results import Comparison
from hdprog.reporting.comparison_words import verdict
from hdprog.reporting.figures.model_loops import model_loops
from hdprog.reporting.figures.model_ranking import model_ranking
from hdprog.reporting.figures.model_stiffness import model_stiffness
from hdprog.reporting.sections import comparison as tables
from hdprog.reporting.sections.section import Section
from hdprog.reporting.sections_page import sections_page
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
                pictures=(("", model_ranking(result)),),
                tables=(tables.ranking(result),),
            ),
            Section("stiffness", "Local stiffness", pictures=(("", model_stiffness(result)),)),
            Section("loops", "What each model leaves over", pictures=(("", model_loops(result)),)),
            Section("models", "The models", tables=(tables.identities(result),)),
            Section(
                "parameters",
                "Parameters and sampling",
                tables=(tables.parameters(result), tables.sampling(result)),
            ),
        ]
    name = result.loop.source.rpartition("/")[2]
    parts = [
        counted(len(result.models), "model"),
        counted(len(result.loop), "reading"),
        ("two-sided" if result.two_sided else "one-sided")
        + f" cycle to {torque_words(result.amplitude)}",
    ]
    return sections_page(
        name,
        parts,
        said,
        tables.warnings(result),
        sections,
        tables.method(result),
        result.provenance,
        command="hdprog compare",
    )
