"""All cases' results in words and tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from hdprog.physics.parameters import NAMES
from tests.benchmarks.modes.annealed import LAST_MOVES, MOVES, PARTICLES, POPULATIONS
from tests.benchmarks.modes.compare import DEEP, MEAN_LIMIT, MODE, SD_LIMIT, SURE
from tests.benchmarks.modes.nested import LIVE_POINTS

COMMAND = "python -m tests.benchmarks.modes.run"
KINDS = {"long": "long run", "full": "full plan"}
Result = dict[str, Any]


def in_words(results: Sequence[Result], code: str, cases: int) -> str:
    """The results as Markdown.

    Parameters
    ----------
    results : of the finished cases
    code : digest of the sources as they are now
    cases : how many there are to do
    """
    parts = [
        _head(results, code, cases),
        "## Cases\n\n" + "\n".join(f"* **{one['name']}**: {one['why']}" for one in results),
        _verdicts(results),
        _modes(results),
        _against_nested(results),
        _reference(results),
        _parameters(results),
        _seconds(results),
    ]
    return "\n\n".join(parts) + "\n"


def _head(results: Sequence[Result], code: str, cases: int) -> str:
    long = [one for one in results if one["runs"]["long"][0]["converged"]]
    agree = [one for one in long if not _beyond(one["runs"]["long"][0])]
    runs = [run for one in results for run in one["runs"]["full"]]
    full = [run for run in runs if run["converged"]]
    empty = [
        (one["name"], kind, run["converged"])
        for one in results
        for kind in KINDS
        for run in one["runs"][kind]
        if run["cells"]["empty"]
    ]
    gone = [
        (one["name"], kind, run["converged"])
        for one in results
        for kind in KINDS
        for run in one["runs"][kind]
        if _lost(one, run)
    ]
    versions = ", ".join(f"{name} {number}" for name, number in results[0]["versions"].items())
    dates = sorted({one["date"] for one in results})
    words = (
        "# Modes of the loop posterior: hdprog's sampler against a reference\n\n"
        f"{len(results)} of {cases} hard loops. Made by `{COMMAND}`, {dates[0]}"
        + (f" to {dates[-1]}" if len(dates) > 1 else "")
        + f", with {versions}.\n\n"
        f"Reference: {POPULATIONS} independent populations of {PARTICLES} particles led from the "
        f"prior to the posterior, {MOVES} moves at each power of the likelihood and {LAST_MOVES} "
        "at the last; its error is the spread between the populations. Check of the reference: "
        f"nested sampling, {LIVE_POINTS} live points. Limits: {MEAN_LIMIT:g} standard deviations "
        f"for a mean, {SD_LIMIT:.0%} for a standard deviation, in the eight coordinates and the "
        f"figures of merit; a difference may exceed its limit by {SURE:g} Monte-Carlo errors.\n\n"
        f"**Long run** (20 000 effective draws asked for): {len(long)} of {len(results)} "
        f"converged, {len(agree)} of these within all limits.\n"
        f"**Full plan** (what a user gets), {len(runs)} runs: {len(full)} converged, "
        f"{sum(not _beyond(run) for run in full)} of these within all limits.\n"
        f"**Modes of more than {MODE:.0%} of the mass without a draw:** {_listed(gone)}.\n"
        f"**Cells of more than {MODE:.0%} of the mass without a draw:** {_listed(empty)}."
    )
    if any(one["code"] != code for one in results):
        words += "\n\n**Some cases come from another state of the code.**"
    return words


def _lost(one: Result, run: Result) -> bool:
    """Whether a side of a cut with `MODE` of the mass gets no draw in a run."""
    masses = zip(one["reference"]["modes"], run["modes"], strict=True)
    sides = [pair for above, got in masses for pair in ((above, got), (1 - above, 1 - got))]
    return any(mass > MODE and got <= 0 for mass, got in sides)


def _listed(found: Sequence[tuple[str, str, bool]]) -> str:
    if not found:
        return "none in any run"
    return "; ".join(
        f"{name}, {KINDS[kind]}{'' if converged else ' (marked as not converged)'}"
        for name, kind, converged in found
    )


def _beyond(run: Result) -> list[str]:
    return [name for name, one in run["deviations"].items() if one["excess"] > 0]


def _verdicts(results: Sequence[Result]) -> str:
    rows = [
        [one["name"], words, *_verdict(run)]
        for one in results
        for kind, words in KINDS.items()
        for run in one["runs"][kind]
    ]
    return (
        "## Means and spreads\n\n"
        "The largest differences of a run in any quantity, each with one Monte-Carlo error. "
        "Beyond: quantities outside their limit by more than the errors allow. Cells: least and "
        "largest ratio of a run's share to the reference's among the cells that hold "
        "a hundredth of it.\n\n"
        + _table(
            [
                "case",
                "run",
                "converged",
                "R-hat",
                "ESS",
                "τ",
                "mean",
                "SD ratio",
                "beyond",
                "cells",
            ],
            rows,
        )
    )


def _verdict(run: Result) -> list[str]:
    mean = max(run["deviations"].items(), key=lambda item: abs(item[1]["mean"]))
    sd = max(run["deviations"].items(), key=lambda item: abs(math.log(item[1]["sd"])))
    beyond = _beyond(run)
    return [
        "yes" if run["converged"] else "**no**",
        f"{run['rhat']:.4f}",
        f"{run['ess']:.0f}",
        f"{run['autocorrelation_time']:.0f}",
        f"{mean[1]['mean']:+.3f} ± {mean[1]['mean_error']:.3f} ({mean[0]})",
        f"{sd[1]['sd']:.3f} ± {sd[1]['sd_error']:.3f} ({sd[0]})",
        ", ".join(beyond) if beyond else "none",
        f"{run['cells']['least']:.2f} to {run['cells']['largest']:.2f}",
    ]


def _modes(results: Sequence[Result]) -> str:
    rows = []
    for one in results:
        for at, separator in enumerate(one["separators"]):
            depth = separator["depth"]
            known = one["reference"]
            head = [
                one["name"],
                f"{separator['coordinate']} > {separator['cut']:.3g}",
                "–" if depth is None else f"{depth:.2f}",
                _share(known["modes"][at], known["modes_error"][at]),
                _share(one["nested"]["modes"][at], one["nested"]["modes_error"][at]),
            ]
            long = one["runs"]["long"][0]
            rows.append([*head, _ensembles(long, at), _each(one["runs"]["full"], at)])
    return (
        "## Masses of the modes\n\n"
        f"Mass above a cut: at a valley of a marginal lower than {DEEP:g} of its lower peak, or "
        "where the case puts one (depth –). Long run: mass, and by ensemble. Full plan: mass of "
        "each run; an asterisk marks a run that says itself that it has not converged.\n\n"
        + _table(
            ["case", "above", "depth", "reference", "nested", "long run (ensembles)", "full plan"],
            rows,
        )
    )


def _share(mass: float, error: float) -> str:
    return f"{mass:.1%} ± {error:.1%}"


def _ensembles(run: Result, at: int) -> str:
    each = ", ".join(f"{ensemble[at]:.1%}" for ensemble in run["modes_of_ensembles"])
    return f"{run['modes'][at]:.1%}{_mark(run)} ({each})"


def _each(runs: Iterable[Result], at: int) -> str:
    return ", ".join(f"{run['modes'][at]:.1%}{_mark(run)}" for run in runs)


def _mark(run: Result) -> str:
    return "" if run["converged"] else "\\*"


def _against_nested(results: Sequence[Result]) -> str:
    rows = []
    for one in results:
        known, check = one["reference"], one["nested"]
        moments = [known["moments"][name] for name in NAMES]
        means = [
            (
                (check["mean"][at] - moment["mean"]) / moment["sd"],
                math.hypot(check["mean_error"][at], moment["mean_error"]) / moment["sd"],
                name,
            )
            for at, (name, moment) in enumerate(zip(NAMES, moments, strict=True))
        ]
        ratios = [
            (
                check["sd"][at] / moment["sd"],
                math.hypot(check["sd_error"][at], moment["sd_error"]) / moment["sd"],
                name,
            )
            for at, (name, moment) in enumerate(zip(NAMES, moments, strict=True))
        ]
        mean = max(means, key=lambda item: abs(item[0]))
        ratio = max(ratios, key=lambda item: abs(math.log(item[0])))
        gap = check["log_evidence"] - known["log_evidence"]
        error = math.hypot(check["log_evidence_error"], known["log_evidence_error"])
        rows.append(
            [
                one["name"],
                f"{gap:+.2f} ± {error:.2f}",
                f"{mean[0]:+.3f} ± {mean[1]:.3f} ({mean[2]})",
                f"{ratio[0]:.3f} ± {ratio[1]:.3f} ({ratio[2]})",
                f"{check['effective']:.0f}",
                f"{check['calls'] / 1e6:.1f}",
            ]
        )
    return (
        "## The reference against nested sampling\n\n"
        "Nested sampling minus reference: log evidence, and the largest differences among the "
        "eight coordinates. dynesty's errors count the chance in which points there are and how "
        "the prior volume shrinks, not what its slices remember of the point they start from.\n\n"
        + _table(
            ["case", "log evidence", "mean", "SD ratio", "effective draws", "million calls"], rows
        )
    )


def _reference(results: Sequence[Result]) -> str:
    rows = []
    for one in results:
        known = one["reference"]
        mean = max(m["mean_error"] / m["sd"] for m in known["moments"].values())
        sd = max(m["sd_error"] / m["sd"] for m in known["moments"].values())
        rows.append(
            [
                one["name"],
                f"{known['log_evidence']:.2f} ± {known['log_evidence_error']:.2f}",
                f"{mean:.3f}",
                f"{sd:.3f}",
                f"{known['memory']:.2f}",
                f"{one['blocks']}{', correlated noise' if one['correlated'] else ''}",
                ", ".join(f"{start:.1f}" for start in one["starts"][:5]),
            ]
        )
    return (
        "## The reference's own errors\n\n"
        "Largest standard error of a mean and of a standard deviation, in standard deviations. "
        "Memory: largest correlation of a coordinate before and after the last moves. Starts: the "
        "deviances of hdprog's starts above the best.\n\n"
        + _table(["case", "log evidence", "mean", "SD", "memory", "blocks", "starts"], rows)
    )


def _parameters(results: Sequence[Result]) -> str:
    rows = []
    for one in results:
        run = one["runs"]["long"][0]
        shown = [run["deviations"][name] for name in NAMES]
        mark = "" if run["converged"] else "\\*"
        rows.append([one["name"] + mark, *(f"{d['mean']:+.3f}, {d['sd']:.3f}" for d in shown)])
    return (
        "## The eight parameters in the long run\n\n"
        "Difference of the mean in standard deviations, and ratio of the standard deviations.\n\n"
        + _table(["case", *NAMES], rows)
    )


def _seconds(results: Sequence[Result]) -> str:
    parts = list(results[0]["processor_seconds"])
    rows = [
        [one["name"], *(f"{one['processor_seconds'][part]:.0f}" for part in parts)]
        for one in results
    ]
    return "## Processor seconds\n\n" + _table(["case", *parts], rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [list(head), ["---"] * len(head), *[list(row) for row in rows]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
