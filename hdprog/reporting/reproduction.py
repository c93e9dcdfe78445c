"""The report on the paper's reproduction: one self-contained HTML page."""

from __future__ import annotations

from hdprog.reporting.figures.paper_curves import (
    curves_picture,
    loops_picture,
    of_figure,
    sweep_picture,
)
from hdprog.reporting.reproduction_words import verdict
from hdprog.reporting.sections import reproduction as tables
from hdprog.reporting.sections.section import Section
from hdprog.reporting.sections_page import sections_page
from hdprog.reporting.style import Picture, house_style
from hdprog.reporting.words import counted
from hdprog.reproduction.results import Reproduction

_CAPTION = "The claims and what came out."


def build_reproduction_report(result: Reproduction) -> str:
    """Report as HTML, without anything to fetch and without scripts."""
    said = verdict(result)
    with house_style():
        sections = [
            _section(result, "fig10", "Fig. 10: the loops", ("Fig. 10",), _loops(result)),
            _section(result, "fig11", "Fig. 11: other models", ("Fig. 11",), _others(result)),
            _section(result, "fig12", "Fig. 12: preload and meshing", ("Fig. 12",), _fig12(result)),
            _section(
                result, "fig13", "Fig. 13: friction and springs", ("Fig. 13",), _fig13(result)
            ),
            _section(result, "fig14", "Fig. 14: stiffness curves", ("Fig. 14",), _fig14(result)),
            _section(
                result, "fig15", "Fig. 15: local elastic coefficient", ("Fig. 15",), _fig15(result)
            ),
            _section(
                result, "mesh", "Tooth mesh: sum against integral", ("eq. 19",), _mesh(result)
            ),
            Section(
                "recovery",
                "Table 2 recovered",
                tables=(
                    tables.claims(of_figure(result, "Table 2"), _CAPTION),
                    *(tables.recovery(one) for one in result.recoveries),
                ),
            ),
        ]
    warnings = list(result.warnings)
    if result.provenance.quick:
        warnings.append("Quick run: fewer draws were made; run again without --quick.")
    return sections_page(
        "The paper reproduced",
        [counted(len(result.findings), "claim"), "from the values of its Table 2"],
        said,
        warnings,
        sections,
        tables.method(result),
        result.provenance,
        command="hdprog reproduce-paper",
        title="hdprog",
    )


def _section(
    result: Reproduction, name: str, title: str, figures: tuple[str, ...], shown: Picture
) -> Section:
    table = tables.claims(of_figure(result, *figures), _CAPTION)
    return Section(name, title, pictures=(("", shown),), tables=(table,))


def _loops(result: Reproduction) -> Picture:
    return loops_picture(
        result.loops,
        of_figure(result, "Fig. 10"),
        "Left: steady loops with Table 2's values; right: the angle between their branches.",
    )


def _others(result: Reproduction) -> Picture:
    return loops_picture(
        result.others,
        of_figure(result, "Fig. 11"),
        "The post-test loop, and Dhaouadi's and Zhang's models fitted to a noisy record of it.",
    )


def _fig12(result: Reproduction) -> Picture:
    return sweep_picture(
        [one for one in result.sweeps if one.figure == "Fig. 12"],
        of_figure(result, "Fig. 12"),
        "Post-test values, one of them varied: the positive half of the loop and its width.",
    )


def _fig13(result: Reproduction) -> Picture:
    return sweep_picture(
        [one for one in result.sweeps if one.figure == "Fig. 13"],
        of_figure(result, "Fig. 13"),
        "Post-test values, one of them 30 % lower and higher: the positive half of the loop and "
        "its width.",
    )


def _fig14(result: Reproduction) -> Picture:
    return curves_picture(
        result.stiffness,
        of_figure(result, "Fig. 14"),
        "Left: stiffness curves of the post-test drive; right: how far the other two are off.",
        "angle [mrad]",
        1e3,
    )


def _fig15(result: Reproduction) -> Picture:
    return curves_picture(
        result.local,
        of_figure(result, "Fig. 15"),
        "Left: local elastic coefficient dT/dΔθ (39); right: how far the other two are off.",
        "stiffness [kNm/rad]",
        1e-3,
    )


def _mesh(result: Reproduction) -> Picture:
    return curves_picture(
        result.mesh,
        of_figure(result, "eq. 19"),
        "Left: torsion of the post-test drive's tooth mesh; right: the sums less the integral.",
        "mesh torsion [µrad]",
        1e6,
    )
