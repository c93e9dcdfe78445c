"""Ranks of all drives, tested and put into a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.special import ndtri
from scipy.stats import binomtest

from tests.benchmarks.calibration.ecdf_band import uniformity
from tests.benchmarks.end_to_end.drives import TESTS

HIGHEST = 383
"""Of a rank: so many paths are drawn."""
RATE = 0.05
"""Share of studies of right forecasts in which any quantity leaves its band."""
LEVELS = (0.5, 0.9)
FAULT = "narrow"


def summary(outcomes: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Everything counted and tested, ready for JSON."""
    failed = [one for one in outcomes if "failed" in one]
    outcomes = [one for one in outcomes if "failed" not in one]
    ranked = {name: [one["ranks"][name] for one in outcomes] for name in outcomes[0]["ranks"]}
    narrow = {name: [one[FAULT][name] for one in outcomes] for name in outcomes[0][FAULT]}
    for name in outcomes[0]["crossings"]:
        places = [one["crossings"].get(name) for one in outcomes]
        ranked[name] = [min(int(p * (HIGHEST + 1)), HIGHEST) for p in places if p is not None]
    tested = {name: _tested(ranks) for name, ranks in ranked.items()}
    faulty = {name: _tested(ranks)["p"] for name, ranks in narrow.items()}
    return {
        "drives": len(outcomes),
        "failed": [f"{one['index']}: {one['failed']}" for one in failed],
        "states_of_the_code": dict(Counter(one["code"] for one in outcomes)),
        "drives_with_a_fit_that_did_not_converge": sum(
            one["fits_converged"] < TESTS for one in outcomes
        ),
        "trends_not_converged": sum(not one["trend_converged"] for one in outcomes),
        "rate": RATE,
        "least_p": min(entry["p"] for entry in tested.values()),
        "outside": [name for name, entry in tested.items() if entry["p"] * len(tested) <= RATE],
        "fault_noticed_in": sum(p * len(faulty) <= RATE for p in faulty.values()),
        "fault_of": len(faulty),
        "quantities": tested,
        "seconds_a_drive": np.median([one["seconds"] for one in outcomes], axis=0).tolist(),
    }


def _tested(ranks: Sequence[int]) -> dict[str, Any]:
    found = np.array(ranks, dtype=np.intp)
    shares = (found + 0.5) / (HIGHEST + 1)
    scores = ndtri(shares)
    entry: dict[str, Any] = {
        "drives": len(found),
        "p": float(f"{uniformity(len(found), HIGHEST).p_value(found):.3g}"),
        "shift": round(float(scores.mean()), 3),
        "spread": round(float(np.sqrt(np.mean(scores**2))), 3),
        "tenths": np.histogram(shares, 10, (0, 1))[0].tolist(),
    }
    for level in LEVELS:
        held = int((np.abs(shares - 0.5) < 0.5 * level).sum())
        interval = binomtest(held, len(found)).proportion_ci(0.95, method="exact")
        entry[f"held_by_{level:.0%}"] = [
            round(value, 3) for value in (held / len(found), interval.low, interval.high)
        ]
    return entry


def in_words(result: dict[str, Any]) -> str:
    """The table for readers, as Markdown."""
    outside = ", ".join(result["outside"]) or "none"
    fits, trend = result["seconds_a_drive"]
    lines = [
        "# Forecasts end to end: ranks of simulated drives",
        "",
        f"{result['drives']} drives drawn from the priors, {TESTS} tests each, every loop fitted; "
        f"{len(result['failed'])} more failed. "
        f"{result['drives_with_a_fit_that_did_not_converge']} have a quick fit, "
        f"{result['trends_not_converged']} a trend that did not converge; all are kept in. Made by "
        "`python -m tests.benchmarks.end_to_end.run`; state of the code: "
        f"{', '.join(result['states_of_the_code'])}. Median processor time a drive: {fits:.1f} s "
        f"for the fits, {trend:.1f} s for trend and forecast.",
        "",
        f"**Quantities outside their band** (all inside in {1 - result['rate']:.0%} of studies of "
        f"right forecasts): {outside}. Least p: {result['least_p']:g} of "
        f"{len(result['quantities'])}. Draws three tenths too close to their median are noticed in "
        f"{result['fault_noticed_in']} of {result['fault_of']} quantities.",
        "",
        "Shift: mean normal score of the truth, above zero where it tends to lie above the "
        "forecast. Spread: above one where forecasts are too narrow. In brackets 95 % intervals.",
        "",
        "| quantity | drives | p | shift | spread | 50 % interval holds | 90 % | tenths |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, entry in result["quantities"].items():
        held = [
            f"{share:.0%} ({low:.0%} to {high:.0%})"
            for share, low, high in (entry["held_by_50%"], entry["held_by_90%"])
        ]
        tenths = " ".join(str(count) for count in entry["tenths"])
        lines.append(
            f"| {name.replace('_', ' ')} | {entry['drives']} | {entry['p']:g} | "
            f"{entry['shift']:+.2f} | {entry['spread']:.2f} | {held[0]} | {held[1]} | {tenths} |"
        )
    return "\n".join(lines) + "\n"
