"""Measurements of all samplers put into tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hdprog.physics.parameters import NAMES
from tests.benchmarks.samplers import Outcome
from tests.benchmarks.samplers.measuring import WANTED

OWN = "hdprog"
NUTS = "NumPyro NUTS"
"""The peer that the first aim is about."""
_COORDINATES = (*NAMES, "initial slip")
FASTER, PER_THOUSAND, TIMES_FUSED = 10.0, 35.0, 3.0
"""Aims: times faster than NUTS, effective draws per 1 000 evaluations, times a fused loop."""


def summary(
    outcomes: Sequence[Outcome],
    samplers: Sequence[str],
    circumstances: dict[str, Any],
    equality: Sequence[dict[str, Any]],
    fused: dict[str, Any] | None,
) -> dict[str, Any]:
    """Everything counted, ready for tables and picture.

    Parameters
    ----------
    outcomes : of all posteriors and samplers
    samplers : names in the order of the tables
    circumstances : versions, date and machine of the run
    equality : what the comparison of the densities found, by posterior
    fused : times of the likelihood beside a fused loop, if they were taken
    """
    measured = [one for one in outcomes if one.status == "measured"]
    own = {one.index: one for one in measured if one.sampler == OWN}
    by_sampler = {
        name: [
            _figures(one, own[one.index])
            for one in measured
            if one.sampler == name and one.index in own
        ]
        for name in samplers
    }
    return {
        "circumstances": circumstances,
        "equality": {
            "points": sum(one["posterior_draws"] + one["prior_draws"] for one in equality),
            "outside": sum(one["outside"] for one in equality),
            "deviation": max(one["deviation"] for one in equality),
        },
        "posteriors": [
            {"index": one.index, "kind": one.kind, "blocks": one.blocks, "stretches": one.stretches}
            for one in sorted(own.values(), key=lambda one: one.index)
        ],
        "samplers": {name: figures for name, figures in by_sampler.items() if figures},
        "failed": [
            f"{one.sampler} on posterior {one.index}: {one.reason}"
            for one in outcomes
            if one.status == "failed"
        ],
        "states_of_the_code": sorted({one.code for one in outcomes}),
        "fused": fused,
    }


def _figures(one: Outcome, own: Outcome) -> dict[str, Any]:
    """What the tables show of one measurement, beside hdprog's on the same posterior."""
    work = one.evaluations + one.gradients
    drawn = max(one.ess, 1e-9)
    known = one.ess > 0
    shift = np.abs(np.subtract(one.mean, own.mean)) / np.array(own.sd)
    ratio = np.array(one.sd) / np.array(own.sd)
    found: dict[str, Any] = {
        "index": one.index,
        "kind": one.kind,
        "reached": one.reached,
        "ess": one.ess,
        "rhat": one.rhat or None,
        "evaluations_each": one.evaluations / drawn if known else None,
        "gradients_each": one.gradients / drawn if known else None,
        "per_thousand": 1000 * one.ess / work,
        "shift": float(shift.max()) if known else None,
        "least_sd_ratio": float(ratio.min()) if known else None,
        "largest_sd_ratio": float(ratio.max()) if known else None,
        "furthest": _COORDINATES[int(np.argmax(np.abs(np.log(ratio))))],
        "converged": one.converged,
    }
    if one.sampler == OWN:
        whole = work + one.preparation_evaluations
        found["per_thousand_with_preparation"] = 1000 * one.ess / whole
    for clock in ("processor", "wall"):
        seconds, reference = (getattr(each, f"{clock}_seconds") for each in (one, own))
        whole = reference["preparation"] + reference["run"]
        found[clock] = {
            "run": seconds["run"],
            "all": sum(seconds.values()),
            "preparation": seconds.get("preparation"),
            "compile": seconds.get("compile"),
            "times_own": sum(seconds.values()) / whole,
            "run_times_own": seconds["run"] / whole,
            "run_times_own_run": seconds["run"] / reference["run"],
        }
    return found


def spread(
    figures: Sequence[dict[str, Any]], *path: str
) -> tuple[float, float, float, bool] | None:
    """Median, least and largest of a figure, and whether the median is only a lower bound.

    It is one for times where no more than half of the posteriors were done within the bound.
    """
    values, reached = [], []
    for one in figures:
        value: Any = one
        for key in path:
            value = value[key]
        if value is not None:
            values.append(float(value))
            reached.append(bool(one["reached"]))
    if not values:
        return None
    middle = float(np.median(values))
    timed = path[0] in ("processor", "wall")
    done = [value for value, ok in zip(values, reached, strict=True) if ok and value <= middle]
    return middle, min(values), max(values), timed and len(done) < len(values) / 2


def aims(result: dict[str, Any]) -> list[tuple[str, str, bool]]:
    """Each aim in words, what was found, and whether it is met at the median posterior."""
    found: list[tuple[str, str, bool]] = []
    peer = result["samplers"].get(NUTS)
    for words, key in (
        (f"{FASTER:g} times faster than {NUTS} end to end, its compilation counted", "times_own"),
        (f"{FASTER:g} times faster than {NUTS} end to end, without it", "run_times_own"),
    ):
        if peer:
            ratio = spread(peer, "processor", key)
            assert ratio is not None
            found.append((words, _shown(ratio), ratio[0] >= FASTER))
    work = spread(result["samplers"][OWN], "per_thousand")
    assert work is not None
    words = f"{PER_THOUSAND:g} effective draws of the worst coordinate per 1 000 evaluations"
    found.append((words, _shown(work), work[0] >= PER_THOUSAND))
    if result["fused"]:
        ratios = [one["ratio"] for one in result["fused"]["times"]]
        words = f"the likelihood takes at most {TIMES_FUSED:g} times as long as a fused loop"
        shown = f"{np.median(ratios):.2g} ({min(ratios):.2g} to {max(ratios):.2g})"
        found.append((words, shown, max(ratios) <= TIMES_FUSED))
    return found


def in_words(result: dict[str, Any]) -> str:
    """The tables as Markdown."""
    parts = [
        _head(result),
        "## Aims\n\nAt the median posterior; the likelihood's at every length and batch.\n\n"
        + _table(
            ["aim", "found", "met"],
            [[words, shown, "yes" if met else "no"] for words, shown, met in aims(result)],
        ),
        *(_seconds(result, clock) for clock in ("processor", "wall")),
        _work(result),
        _agreement(result),
        _posteriors(result),
    ]
    if result["fused"]:
        parts.append(fused_words(result["fused"]))
    parts.append(_circumstances(result))
    return "\n\n".join(parts) + "\n"


def _head(result: dict[str, Any]) -> str:
    equality, told = result["equality"], result["circumstances"]
    words = (
        "# Samplers on the posterior of a loop\n\n"
        f"{len(result['posteriors'])} posteriors of nine coordinates each; time and work until the "
        f"worst coordinate has {WANTED:,.0f} effective draws, bulk and tail (ArviZ; every chain or "
        "walker a chain of its own). Median, with least and largest in brackets. One core, one "
        f"thread; a sampler is stopped after {told['bound']:g} processor seconds without "
        "compilation, and ≥ stands where the median posterior was not done by then.\n\n"
        "hdprog runs its full plan, which stops when R-hat, effective draws and chain length all "
        "pass: mostly with more than 1 000 effective draws. Its own diagnostics are part of its "
        "time; for peers looking at the draws costs nothing, and the modes that they start about, "
        "which hdprog's preparation finds, cost nothing either. The log density of the peers is "
        f"compiled by JAX and equals hdprog's to {equality['deviation']:.0e} at "
        f"{equality['points']:,} points, {equality['outside']:,} of them outside the support. All "
        "sample in ridge coordinates unless it says otherwise; dynesty from its unit cube. zeus "
        "gets half of its walkers evaluated at once; dynesty cannot evaluate at once in one "
        "process; nutpie pays for a call of Python at every gradient, and was not run "
        "again where a run of the right length would have passed the bound."
    )
    if len(result["states_of_the_code"]) > 1:
        words += (
            "\n\n**The lines come from several states of the code:** "
            f"{', '.join(result['states_of_the_code'])}."
        )
    if result["failed"]:
        words += "\n\n**Failed:** " + "; ".join(result["failed"]) + "."
    return words


def _seconds(result: dict[str, Any], clock: str) -> str:
    rows = []
    for name, figures in result["samplers"].items():
        done = sum(one["reached"] for one in figures)
        times = [
            spread(figures, clock, key)
            for key in ("all", "run", "times_own", "run_times_own", "run_times_own_run")
        ]
        rows.append([name, f"{done} of {len(figures)}", *(_shown(one) for one in times)])
    head = [
        "sampler",
        "done",
        "seconds, all",
        "seconds, sampling",
        "all / hdprog all",
        "sampling / hdprog all",
        "sampling / hdprog sampling",
    ]
    others = (
        "What the clock on the wall showed in the same run, with what others did on the machine."
        if clock == "wall"
        else "All: with the preparation for hdprog, with compilation for the peers."
    )
    title = "Wall" if clock == "wall" else "Processor"
    return f"## {title} seconds\n\n{others}\n\n" + _table(head, rows)


def _work(result: dict[str, Any]) -> str:
    keys = ("evaluations_each", "gradients_each", "per_thousand")
    rows = [
        [name, *(_shown(spread(figures, key)) for key in keys)]
        for name, figures in result["samplers"].items()
    ]
    whole = spread(result["samplers"][OWN], "per_thousand_with_preparation")
    head = [
        "sampler",
        "evaluations an effective draw",
        "gradients an effective draw",
        "effective draws per 1 000 of both",
    ]
    return (
        "## Work\n\nWarm-up included. With the model curves that preparing takes, hdprog has "
        f"{_shown(whole)} effective draws per 1 000.\n\n" + _table(head, rows)
    )


def _agreement(result: dict[str, Any]) -> str:
    rows = []
    for name, figures in result["samplers"].items():
        done = [one for one in figures if one["reached"]]
        low, high = (spread(done, key) for key in ("least_sd_ratio", "largest_sd_ratio"))
        rows.append(
            [
                name,
                "" if name == OWN else _shown(spread(done, "shift")),
                "" if name == OWN or not low or not high else f"{low[1]:.2f} to {high[2]:.2f}",
                "" if name == OWN else _furthest(done),
                _shown(spread(done, "rhat"), digits=4),
                str(sum(one["rhat"] is not None and one["rhat"] > 1.01 for one in done)),
            ]
        )
    head = [
        "sampler",
        "mean, worst coordinate",
        "SD ratio",
        "furthest from 1",
        "R-hat",
        "R-hat above 1.01",
    ]
    return (
        "## Agreement\n\nBeside hdprog, where there were enough draws. Mean: largest distance of "
        "a coordinate's mean in its standard deviations; two right samplers with 1 000 and 2 500 "
        "effective draws differ by 0.04 in one coordinate, and by 0.07 in the worst of nine. SD "
        "ratio: least and largest of all coordinates and posteriors.\n\n" + _table(head, rows)
    )


def _furthest(figures: Sequence[dict[str, Any]]) -> str:
    """Coordinate and posterior whose standard deviations differ most."""

    def apart(one: dict[str, Any]) -> float:
        return max(float(one["largest_sd_ratio"]), 1 / float(one["least_sd_ratio"]))

    if not figures:
        return ""
    worst = max(figures, key=apart)
    return f"{worst['furthest']}, posterior {worst['index']}"


def _posteriors(result: dict[str, Any]) -> str:
    names = list(result["samplers"])
    rows = []
    for one in result["posteriors"]:
        row = [str(one["index"]), one["kind"], str(one["blocks"]), str(one["stretches"])]
        for name in names:
            of = [each for each in result["samplers"][name] if each["index"] == one["index"]]
            row.append(_of_one(of[0]) if of else "–")
        rows.append(row)
    head = ["", "loop", "blocks", "stretches", *names]
    return (
        "## Posterior by posterior\n\nProcessor seconds of all parts, and effective draws.\n\n"
        + _table(head, rows)
    )


def _of_one(one: dict[str, Any]) -> str:
    short = "" if one["reached"] else "≥ "
    return f"{short}{one['processor']['all']:.3g} s, {one['ess']:.0f}"


def fused_words(fused: dict[str, Any]) -> str:
    """Times of the likelihood beside those of a fused loop, as Markdown."""
    rows = [
        [
            str(one["blocks"]),
            "yes" if one["averaged"] else "no",
            str(one["batch"]),
            f"{one['own_us']:.3g}",
            f"{one['fused_us']:.3g}",
            f"{one['ratio']:.2f}",
            f"{one['fastmath_us']:.3g}",
            f"{one['density_us']:.3g}",
        ]
        for one in fused["times"]
    ]
    head = [
        "blocks",
        "averages",
        "batch",
        "hdprog, µs",
        "fused, µs",
        "ratio",
        "fused with fastmath, µs",
        "whole density, µs",
    ]
    return (
        "## Likelihood beside a fused loop\n\nMicroseconds of one evaluation, least of "
        f"{fused['rounds']} rounds: hdprog's likelihood in NumPy, and one loop over blocks in "
        "machine code (Numba, float64, the same arithmetic, no fastmath). Averages: blocks stand "
        "for more than one reading. Whole density: hdprog's, with prior, support and Jacobian. "
        f"Largest deviation of the log likelihood {fused['deviation']:.0e}. "
        f"{fused['date']}, NumPy {fused['numpy']}, Numba {fused['numba']}; "
        f"`{fused['command']}`.\n\n" + _table(head, rows)
    )


def _circumstances(result: dict[str, Any]) -> str:
    told = result["circumstances"]
    versions = ", ".join(f"{name} {version}" for name, version in told["versions"].items())
    return (
        f"## Circumstances\n\n{told['date']}, `{told['command']}`, {told['processor']}, one core. "
        f"{versions}."
    )


def _shown(figures: tuple[float, float, float, bool] | None, digits: int = 3) -> str:
    if figures is None:
        return ""
    middle, least, largest, bound = figures
    middle, least, largest = (float(f"{one:.{digits}g}") for one in (middle, least, largest))
    return f"{'≥ ' if bound else ''}{middle:g} ({least:g} to {largest:g})"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [list(head), ["---"] * len(head), *(list(row) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
