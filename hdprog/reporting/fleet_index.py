"""The list of many drives, worst first: for a reader and as JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from hdprog.reporting.build import environment
from hdprog.reporting.fleet_words import PROVISIONAL, first_forecast, fleet_entry
from hdprog.reporting.forecast_words import inspect_words
from hdprog.reporting.rounding import hours, percent_beside
from hdprog.reporting.sparkline import sparkline
from hdprog.reporting.words import agree, counted, listed

_STATES = {
    "act": ("needs action now", "need action now"),
    "plan": ("has an inspection to plan", "have an inspection to plan"),
    "no date": ("needs a second test", "need a second test"),
    "good": ("is good up to its horizon", "are good up to their horizons"),
    "present": ("has no limit: present condition only", "have no limit: present condition only"),
}


def fleet_drive(
    folder: str, place: str, summary: Mapping[str, Any], *, explanation_converged: bool = True
) -> dict[str, Any]:
    """One drive of fleet.json.

    Parameters
    ----------
    folder : its name below the fleet's folder
    place : of its results, relative to fleet.json
    summary : content of its summary.json
    explanation_converged : whether the fits that its effects were found by did, the drive model's
        alone among them; of none are none that did not
    """
    entry = fleet_entry(summary)
    first = first_forecast(summary["forecast"])
    return {
        "id": summary["drive"]["id"],
        "folder": folder,
        "report": f"{place}/report.html",
        "summary": f"{place}/summary.json",
        "converged": summary["converged"],
        "explanation_converged": explanation_converged,
        "status": entry.status,
        "provisional": entry.provisional,
        "label": entry.label,
        "sentence": f"{entry.sentence} {PROVISIONAL}" if entry.provisional else entry.sentence,
        "rank": entry.rank,
        "rank_hours": entry.rank_hours,
        "tests": len(summary["tests"]),
        "now_hours": summary["tests"][-1]["service_hours"],
        "horizon_hours": None if first is None else first["horizon_hours"],
        "inspect_before_hours": entry.inspect_before_hours,
        "next_test_hours": summary["next_test_hours"],
        "dated": entry.dated,
        "remaining_hours": dict(entry.remaining_hours),
        "acceptable_risk": None if first is None else first["acceptable_risk"],
        "probability_crossed_by_shutdown": (
            None if first is None else first["probability_crossed_by_shutdown"]
        ),
        "probability_crossed_by_horizon": (
            None if first is None else first["probability_crossed_by_horizon"]
        ),
        "warnings": entry.warnings,
        "course": None
        if entry.course is None
        else asdict(entry.course) | {"points": [list(point) for point in entry.course.points]},
    }


def shared_ids(drives: Sequence[Mapping[str, Any]]) -> list[str]:
    """Say of which drives of a fleet.json the id is another one's, too: copied folders mostly."""
    folders: dict[str, list[str]] = {}
    for drive in drives:
        folders.setdefault(drive["id"], []).append(drive["folder"])
    return [
        f'The drives in {listed(sorted(found))} have the same id, "{name}", and are listed one by '
        "one. If they are different drives, give each an id of its own in drive.toml (a copied "
        "folder keeps the old one); if not, keep one folder. Until then `hdprog run --fleet` "
        "learns from one of them only."
        for name, found in folders.items()
        if len(found) > 1
    ]


def headline(content: Mapping[str, Any]) -> str:
    """How many drives need what, in plain words."""
    drives = content["drives"]
    counts = Counter(map(_state, drives))
    said = [
        f"{counts[state]} {agree(counts[state], *words)}"
        for state, words in _STATES.items()
        if counts[state]
    ]
    text = f"{counted(len(drives), 'drive')}: {'; '.join(said)}."
    unsettled = sum(not drive["converged"] for drive in drives)
    if unsettled:
        verb = agree(unsettled, "is", "are")
        text += f" {counted(unsettled, 'drive')} did not converge and {verb} provisional."
    unsure = sum(not drive["explanation_converged"] for drive in drives if drive["converged"])
    if unsure:
        text += (
            f" Of {counted(unsure, 'drive')} the drive model alone did not converge: "
            "the effects are provisional."
        )
    if content["left_out"]:
        left = len(content["left_out"])
        text += f" {counted(left, 'folder')} could not be used; the list says why."
    return text


def build_fleet_index(content: Mapping[str, Any]) -> str:
    """The list as one self-contained HTML page with links to the drives' reports."""
    return (
        environment()
        .get_template("fleet_index.html")
        .render(
            title=f"Fleet {content['fleet']} – hdprog",
            fleet=content,
            headline=headline(content),
            warnings=content.get("warnings", []),
            rows=[_row(drive) for drive in content["drives"]],
        )
    )


def _state(drive: Mapping[str, Any]) -> str:
    undated = drive["status"] == "plan" and not drive.get("dated", True)
    return "no date" if undated else str(drive["status"])


def _row(drive: Mapping[str, Any]) -> dict[str, Any]:
    inspect, status = drive["inspect_before_hours"], drive["status"]
    if status == "act":
        when = "now"
    elif not drive["remaining_hours"]:
        when = "–"
    elif inspect is None:
        when = "not before the horizon"
    else:
        when = inspect_words(
            inspect,
            drive["now_hours"],
            drive["remaining_hours"],
            drive["horizon_hours"],
            dated=drive.get("dated", True),
        )
    risk = drive["probability_crossed_by_shutdown"]
    now = drive["now_hours"]
    doubts = [counted(drive["warnings"], "warning")] if drive["warnings"] else []
    if not drive["explanation_converged"]:
        doubts.append("effects provisional")
    return {
        "drive": drive,
        "inspect": when,
        "risk": "–" if risk is None else percent_beside(risk, drive["acceptable_risk"]),
        "last": "hours not given" if now is None else hours(now),
        "tests": counted(drive["tests"], "test"),
        "warnings": ", ".join(doubts),
        "course": sparkline(drive["course"] or {}),
    }
