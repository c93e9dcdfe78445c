"""A reproduction of the paper in plain words, and as lines for the screen."""

from __future__ import annotations

from collections import Counter

from hdprog.reporting.verdict import Verdict
from hdprog.reporting.words import counted, keyboard_signs, listed, tidy
from hdprog.reproduction.results import Reproduction


def verdict(result: Reproduction) -> Verdict:
    """How many claims came out, and which did not."""
    count = Counter(one.outcome for one in result.findings)
    said = list(result.warnings)
    said.append(
        f"Of {counted(len(result.findings), 'claim')} {count['agrees']} came out as the paper "
        f"says, {count['disagrees']} did not and {count['cannot be checked']} cannot be checked."
    )
    against = dict.fromkeys(one.figure for one in result.findings if one.outcome == "disagrees")
    if against:
        said.append(f"What did not come out is at {listed(against)}, below with its numbers.")
    said.append(
        "The paper states neither its tooth angle nor the torque of its loops: 30° and 100 Nm are "
        "taken."
    )
    label = "Provisional" if not result.converged else "Paper against computation"
    return Verdict("present", not result.converged, label, tuple(map(tidy, said)))


def screen(result: Reproduction) -> str:
    """The verdict, and a line a claim."""
    lines = [
        f"{one.outcome:18s} {one.figure:8s} {one.claim}\n{'':28s}{tidy(one.came_out)}"
        for one in result.findings
    ]
    return keyboard_signs("\n".join([verdict(result).text, "", *lines]))
