"""Ranks of all loops, tested and put into tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import binomtest

from tests.benchmarks.calibration import Outcome
from tests.benchmarks.calibration.ecdf_band import uniformity
from tests.benchmarks.calibration.faults import FAULTS
from tests.benchmarks.calibration.loops import KINDS, NOISE, READINGS
from tests.benchmarks.calibration.ranks import HIGHEST, QUANTITIES, rank_of

RATE = 0.05
"""Share of studies of a right posterior in which any quantity leaves its band."""
LEVELS = (0.5, 0.9)
REPETITIONS = 1000
POWER_LOOPS = 1000
CONTROL = "none"
_SEED = 62

IntArray = NDArray[np.intp]
FloatArray = NDArray[np.float64]


def summary(outcomes: Sequence[Outcome], unreadable: int = 0) -> dict[str, Any]:
    """Everything counted and tested, ready for JSON."""
    fitted = [one for one in outcomes if one.status == "fitted"]
    groups = {"all": fitted} | {k: [one for one in fitted if one.kind == k] for k in KINDS}
    groups = {name: group for name, group in groups.items() if group}
    return {
        "loops": len(outcomes),
        "fitted": len(fitted),
        "failed": len(outcomes) - len(fitted),
        "states_of_the_code": dict(Counter(one.code for one in outcomes)),
        "unreadable_lines": unreadable,
        "rate": RATE,
        "loops_by_kind": {name: _counts(group) for name, group in groups.items()},
        "uniform": {name: tested(group) for name, group in groups.items()},
        "coverage": {
            f"{level:g}": {name: covered(group, level) for name, group in groups.items()}
            for level in LEVELS
        },
        "faults": planted(fitted),
        "processor_seconds_a_loop": {
            part: _spread(one.processor_seconds.get(part) for one in fitted)
            for part in ("fit", "ranks", "refit")
        },
    }


def _counts(group: Sequence[Outcome]) -> dict[str, Any]:
    """How many loops of a kind are what its name says, and how their fits went."""
    sides = [one.largest_torque < one.T_i for one in group]
    return {
        "loops": len(group),
        "one-sided": sum(one.one_sided for one in group),
        "T_max below T_i": sum(sides),
        "not converged, kept": sum(not one.converged for one in group),
        "taken for correlated noise": sum(one.correlated for one in group),
        "readings set aside": sum(one.spikes for one in group),
        "least effective draws": _spread(one.ess for one in group),
        "autocorrelation time": _spread(one.autocorrelation_time for one in group),
    }


def ranks_of(group: Sequence[Outcome], fault: str = CONTROL) -> IntArray:
    """Ranks (loops, quantities) of the right posterior or of one with a fault."""
    rows = [one.ranks if fault == CONTROL else one.faults[fault] for one in group]
    return np.array(rows, dtype=np.intp).reshape(len(rows), len(QUANTITIES))


def tested(group: Sequence[Outcome]) -> dict[str, dict[str, float]]:
    """By quantity: p value, and location and spread of the ranks' normal scores.

    A score's mean beyond zero says that the truth tends to lie above the posterior, a spread above
    one that the posterior is too narrow by that factor.
    """
    test = uniformity(len(group), HIGHEST)
    ranks = ranks_of(group)
    scores = _normal_scores(ranks)
    return {
        name: {
            "p": float(f"{test.p_value(ranks[:, at]):.3g}"),
            "shift": round(float(scores[:, at].mean()), 3),
            "spread": round(float(np.sqrt(np.mean(scores[:, at] ** 2))), 3),
        }
        for at, name in enumerate(QUANTITIES)
    }


def _normal_scores(ranks: IntArray) -> FloatArray:
    """Ranks as draws of a standard normal variable, if they are uniform."""
    grid = ndtri((np.arange(HIGHEST + 1) + 0.5) / (HIGHEST + 1))
    return np.asarray((grid / np.sqrt(np.mean(grid**2)))[ranks])


def covered(group: Sequence[Outcome], level: float) -> dict[str, dict[str, Any]]:
    """By quantity: how often the central interval that a user reads holds the truth."""
    shares = np.array([one.shares for one in group])
    inside = np.abs(shares - 0.5) < 0.5 * level
    held = inside.sum(axis=0).tolist()
    return {name: _rate(count, len(group)) for name, count in zip(QUANTITIES, held, strict=True)}


def _rate(count: int, of: int) -> dict[str, Any]:
    """A share with the 95 % interval of Clopper and Pearson."""
    interval = binomtest(count, of).proportion_ci(0.95, method="exact")
    bounds = [round(float(interval.low), 4), round(float(interval.high), 4)]
    return {"count": count, "of": of, "share": round(count / of, 4), "interval_95": bounds}


def planted(fitted: Sequence[Outcome]) -> dict[str, dict[str, Any]]:
    """By fault: whether the loops give it away, and how surely other loops would."""
    rng = np.random.default_rng(_SEED)
    found = {}
    for fault in (CONTROL, *FAULTS):
        having = [one for one in fitted if fault == CONTROL or fault in one.faults]
        if not having:
            continue
        ranks = ranks_of(having, fault)
        test = uniformity(len(having), HIGHEST)
        p = {name: test.p_value(ranks[:, at]) for at, name in enumerate(QUANTITIES)}
        worst = min(p, key=lambda name: p[name])
        right = np.array([[rank_of(share) for share in one.shares] for one in having])
        efficiency = [one.efficiency[fault] for one in having if fault in one.efficiency]
        found[fault] = {
            "loops": len(having),
            "caught": bool(p[worst] * len(QUANTITIES) <= RATE),
            "plainest in": worst,
            "p": float(f"{p[worst]:.3g}"),
            "power": power(right if fault == CONTROL else ranks, right, rng),
            "effective_share_of_draws": _spread(efficiency),
        }
    return found


def power(ranks: IntArray, right: IntArray, rng: np.random.Generator) -> float:
    """Share of studies with `POWER_LOOPS` loops in which any quantity leaves its band.

    Bootstrap over loops. The ranks of the wrong posterior are first counted in those of the right
    one for the same loops: these are off uniform by chance, which every resampling would repeat and
    the band take for a fault. Counted so, the right posterior itself is uniform, and only what the
    fault changes is left.

    Parameters
    ----------
    ranks, right : (loops, quantities) of the wrong and of the right posterior, both from the shares
        of all their draws
    rng : of the resampling
    """
    test = uniformity(POWER_LOOPS, HIGHEST)
    least, largest = test.band(RATE / len(QUANTITIES))
    cells = test.places.size + 1
    cell = np.searchsorted(test.places, ranks, side="right")
    low, width = _right_shares(np.searchsorted(test.places, right, side="right"), cells)
    columns = np.arange(len(QUANTITIES))
    low, width = low[cell, columns], width[cell, columns]
    noticed = 0
    for _ in range(REPETITIONS):
        taken = rng.integers(len(ranks), size=POWER_LOOPS)
        share = low[taken] + width[taken] * rng.random((POWER_LOOPS, columns.size))
        place = np.minimum((share * cells).astype(int), cells - 1)
        counts = np.bincount((place + cells * columns).ravel(), minlength=cells * columns.size)
        ecdf = np.cumsum(counts.reshape(-1, cells), axis=1)[:, :-1] / POWER_LOOPS
        noticed += bool(((ecdf < least - 1e-9) | (ecdf > largest + 1e-9)).any())
    return noticed / REPETITIONS


def _right_shares(cell: IntArray, cells: int) -> tuple[FloatArray, FloatArray]:
    """Share of right ranks below each cell and in it, (cells, quantities) each."""
    inside = np.array([(cell == one).mean(axis=0) for one in range(cells)])
    return np.cumsum(inside, axis=0) - inside, inside


def _spread(values: Iterable[float | None]) -> dict[str, float] | None:
    """Of those that there are: number, mean, least, median and largest."""
    array = np.array([value for value in values if value is not None], dtype=float)
    if not array.size:
        return None
    points = {
        "mean": array.mean(),
        "least": array.min(),
        "median": np.median(array),
        "largest": array.max(),
    }
    return {"count": int(array.size), **{k: float(f"{v:.4g}") for k, v in points.items()}}


def in_words(result: dict[str, Any]) -> str:
    """The tests as Markdown."""
    groups = list(result["loops_by_kind"])
    parts = [
        _head(result),
        "## Loops\n\n"
        + _table(
            ["", *groups],
            {
                key: [_shown(result["loops_by_kind"][group][key]) for group in groups]
                for key in result["loops_by_kind"]["all"]
            },
        ),
        "## Ranks: p value, shift, spread\n\n"
        "p: probability that uniform ranks leave a band as wide; small is bad. Shift: mean of the "
        "ranks' normal scores, positive where the truth lies above the posterior. Spread: their "
        "root mean square, above one where the posterior is too narrow by that factor.\n\n"
        + _table(["quantity", *groups], _by_quantity(result["uniform"], _tested_words)),
        *(
            f"## Central {float(level):.0%} intervals\n\nShare that holds the truth, with the 95 % "
            "interval of Clopper and Pearson.\n\n"
            + _table(["quantity", *groups], _by_quantity(by, _rate_words))
            for level, by in result["coverage"].items()
        ),
        "## Planted faults\n\n" + _faults_words(result),
        "## Processor seconds a loop\n\nCount, mean, least / median / largest.\n\n"
        + _table(
            ["part", "seconds"],
            {k: [_shown(v)] for k, v in result["processor_seconds_a_loop"].items() if v},
        ),
    ]
    return "\n\n".join(parts) + "\n"


def verdict(result: dict[str, Any]) -> tuple[bool, str, float]:
    """Whether all quantities are uniform over all loops at `RATE`, and the worst with its p."""
    p = {name: one["p"] for name, one in result["uniform"]["all"].items()}
    worst = min(p, key=lambda name: p[name])
    return p[worst] * len(p) > RATE, worst, p[worst]


def worst_of_kinds(result: dict[str, Any]) -> tuple[str, str, float]:
    """Kind and quantity with the least p value, and that."""
    every = [
        (one["p"], kind, name)
        for kind, by in result["uniform"].items()
        if kind != "all"
        for name, one in by.items()
    ]
    p, kind, name = min(every)
    return kind, name, p


def _head(result: dict[str, Any]) -> str:
    uniform, worst, p = verdict(result)
    kind, name, p_of_kind = worst_of_kinds(result)
    kinds = len(result["uniform"]) - 1
    chance = 1 - (1 - p_of_kind) ** (kinds * len(QUANTITIES))  # were they independent
    counts = result["loops_by_kind"]["all"]
    many = len(QUANTITIES)
    words = (
        "# Calibration of the loop posterior\n\n"
        f"{result['fitted']} loops drawn from the prior and fitted with it by the quick plan; "
        f"{result['failed']} failed and are left out; {counts['not converged, kept']} did not "
        f"converge and are kept in. {READINGS[0]} to {READINGS[1]} readings, white noise of "
        f"{NOISE[0]:g} to {NOISE[1]:g} rad. "
        f"Each truth is ranked among {HIGHEST} independent draws in {many} quantities.\n\n"
        f"**{'No quantity leaves' if uniform else 'At least one quantity leaves'} the band** that "
        f"uniform ranks of all {many} stay in together in at least {1 - RATE:.0%} of studies. The "
        f"least p value is {p:.2g} ({worst}), {min(1.0, p * many):.2g} with {many} quantities "
        f"looked at. Over the kinds the least is {p_of_kind:.2g} ({name}, {kind}); among "
        f"{kinds * many} independent ones the least is so small in {chance:.0%} of studies."
    )
    states = result["states_of_the_code"]
    if len(states) > 1:
        words += f"\n\n**The loops come from {len(states)} states of the code:** {states}."
    if result["unreadable_lines"]:
        words += f"\n\n{result['unreadable_lines']} lines of the file could not be read."
    return words


def _faults_words(result: dict[str, Any]) -> str:
    words = (
        "Caught: some quantity leaves the band for these loops. Power: share of "
        f"{REPETITIONS} studies of {POWER_LOOPS} loops in which one does, by bootstrap over the "
        "loops; ranks are counted in those of the right posterior for the same loops, so that "
        "their chance deviation is no fault, which needs some hundred loops. The line without a "
        "fault is the rate of false alarms. Draws: least and median effective share of the draws "
        "under the fault's weights.\n\n"
    )
    rows = {}
    for fault, one in result["faults"].items():
        share = one["effective_share_of_draws"]
        rows[fault] = [
            str(one["loops"]),
            "yes" if one["caught"] else "no",
            f"{one['plainest in']} (p {one['p']:.1g})",
            f"{one['power']:.1%}",
            "" if share is None else f"{share['least']:.0%}, {share['median']:.0%}",
        ]
    return words + _table(["fault", "loops", "caught", "plainest in", "power", "draws"], rows)


def _by_quantity(groups: dict[str, Any], shown: Any) -> dict[str, list[str]]:
    return {name: [shown(by[name]) for by in groups.values()] for name in QUANTITIES}


def _tested_words(one: dict[str, float]) -> str:
    return f"{one['p']:.2g}, {one['shift']:+.2f}, {one['spread']:.2f}"


def _rate_words(one: dict[str, Any]) -> str:
    low, high = one["interval_95"]
    return f"{one['share']:.1%} ({low:.1%} to {high:.1%})"


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return (
            f"{value['count']}: {value['mean']:.3g}, "
            f"{value['least']:.3g} / {value['median']:.3g} / {value['largest']:.3g}"
        )
    return "–" if value is None else str(value)


def _table(head: Sequence[str], rows: dict[str, list[str]]) -> str:
    lines = [list(head), ["---"] * len(head), *([name, *row] for name, row in rows.items())]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
