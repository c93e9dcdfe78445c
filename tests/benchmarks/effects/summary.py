"""Outcomes of the benchmark's loops, counted and put into tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

from tests.benchmarks.effects import NOTHING, UNKNOWN, Outcome, loops
from tests.benchmarks.effects.loops import CLEAN, LISTED, PAIR_SIZE, SIZES, UNLISTED, Case
from tests.independent.effects import EFFECTS

COLUMNS = (*dict.fromkeys(EFFECTS[name].identifier for name in LISTED), UNKNOWN, NOTHING)


def summary(outcomes: Sequence[Outcome], unreadable: int = 0) -> dict[str, Any]:
    """Everything counted, ready for JSON."""
    fitted = [one for one in outcomes if one.status == "fitted"]
    single = [one for one in outcomes if Case(one.case).effect]
    listed = [one for one in single if Case(one.case).effect in LISTED]
    unlisted = [one for one in single if Case(one.case).effect in UNLISTED]
    return {
        "loops": len(outcomes),
        "states_of_the_code": dict(Counter(one.code for one in outcomes)),
        "unreadable_lines": unreadable,
        **_statuses(outcomes),
        "draws_rejected_on_the_way": sum(one.rejected for one in outcomes),
        "false_finds": {name: _false(outcomes, name) for name in CLEAN},
        "listed_by_size": _by_size(listed, _listed),
        "listed_by_effect": {
            name: _by_size([one for one in listed if Case(one.case).effect == name], _listed)
            for name in LISTED
        },
        "confusion": _by_size(single, _confusion),
        "pairs": _pairs([one for one in outcomes if one.case == "pair"]),
        "unlisted_by_size": _by_size(unlisted, _unlisted),
        "unlisted_by_effect": {
            name: _by_size([one for one in unlisted if Case(one.case).effect == name], _unlisted)
            for name in UNLISTED
        },
        "seconds_a_loop": {
            "by the wall's clock": _spread(one.seconds for one in fitted),
            "of the processor": _spread(one.processor_seconds for one in fitted),
        },
    }


def _statuses(outcomes: Sequence[Outcome]) -> dict[str, int]:
    counts = Counter(one.status for one in outcomes)
    return {name.replace(" ", "_"): counts[name] for name in ("fitted", "not drawable", "failed")}


def _by_size(
    outcomes: Sequence[Outcome], counted: Callable[[list[Outcome]], dict[str, Any]]
) -> dict[str, Any]:
    """Counts of the fitted loops of each size that has any, beside those left out."""
    found = {}
    for size in SIZES:
        here = [one for one in outcomes if Case(one.case).size == size]
        if here:
            fitted = [one for one in here if one.status == "fitted"]
            found[f"{size:g}"] = {**_statuses(here), **counted(fitted)}
    return found


def _false(outcomes: Sequence[Outcome], case: str) -> dict[str, Any]:
    here = [one for one in outcomes if one.case == case]
    fitted = [one for one in here if one.status == "fitted"]
    finds = [one for one in fitted if one.main != NOTHING]
    named = sum(bool(one.names) for one in finds)
    return {
        **_statuses(here),
        "any_find": _rate(len(finds), len(fitted)),
        "a_mechanism": _rate(named, len(fitted)),
        "main_names": dict(Counter(one.main for one in finds).most_common()),
    }


def _rate(count: int, of: int) -> dict[str, Any]:
    """A share with the 95 % interval of Clopper and Pearson."""
    if not of:
        return {"count": 0, "of": 0, "share": None, "interval_95": None}
    interval = binomtest(count, of).proportion_ci(0.95, method="exact")
    bounds = [round(float(interval.low), 4), round(float(interval.high), 4)]
    return {"count": count, "of": of, "share": round(count / of, 4), "interval_95": bounds}


def _listed(fitted: list[Outcome]) -> dict[str, Any]:
    right = [one.main in one.truth for one in fitted]
    grouped = [bool(one.truth & {one.main, *one.alike}) for one in fitted]
    compared = [one for one in fitted if one.heldout_oracle]
    ratios = [one.heldout_after / one.heldout_oracle for one in compared if one.heldout_oracle]
    return {
        "main_right": _rate(sum(right), len(fitted)),
        "right_or_in_stated_group": _rate(sum(grouped), len(fitted)),
        "other_names_in_the_stated_group": _spread(float(len(one.alike)) for one in fitted),
        "only_the_right_name": sum(one.truth == set(one.names) for one in fitted),
        "spurious_extra_names": sum(len(one.extra) for one in fitted),
        "loops_with_spurious_extra_names": sum(bool(one.extra) for one in fitted),
        "unknown_beside_names": sum(bool(one.names and one.term) for one in fitted),
        **_errors(fitted),
        "heldout_over_oracle": _spread(ratios),
    }


def _errors(fitted: list[Outcome]) -> dict[str, Any]:
    gains = [one.heldout_after / one.heldout_before for one in fitted if one.heldout_before]
    return {
        "misfit_before": _spread([one.before for one in fitted]),
        "misfit_after": _spread([one.after for one in fitted]),
        "heldout_after_over_before": _spread(gains),
    }


def _unlisted(fitted: list[Outcome]) -> dict[str, Any]:
    return {
        "called_unknown": _rate(sum(one.main == UNKNOWN for one in fitted), len(fitted)),
        "nothing": sum(one.main == NOTHING for one in fitted),
        "a_mechanisms_name": sum(bool(one.names and not one.term) for one in fitted),
        "name_and_unknown": sum(bool(one.names and one.term) for one in fitted),
        **_errors(fitted),
    }


def _confusion(fitted: list[Outcome]) -> dict[str, Any]:
    rows = {
        name: Counter(one.main for one in fitted if one.effects == [name])
        for name in (*LISTED, *UNLISTED)
    }
    return {"named": {name: dict(counts.most_common()) for name, counts in rows.items() if counts}}


def _pairs(pairs: list[Outcome]) -> dict[str, Any]:
    fitted = [one for one in pairs if one.status == "fitted"]
    hits = [len(one.truth & set(one.names)) for one in fitted]
    extra = [set(one.names) - one.truth for one in fitted]
    return {
        **_statuses(pairs),
        "both_found": _rate(sum(hit == 2 for hit in hits), len(fitted)),
        "one_found": sum(hit == 1 for hit in hits),
        "none_found": sum(hit == 0 for hit in hits),
        "both_and_nothing_else": sum(one.truth == set(one.names) for one in fitted),
        "loops_with_wrong_names": sum(bool(names) for names in extra),
        "unknown_beside_names": sum(bool(one.names and one.term) for one in fitted),
        **_errors(fitted),
    }


def _spread(values: Iterable[float]) -> dict[str, float] | None:
    """Number, median, 95 % point and largest."""
    array = np.array(list(values))
    if not array.size:
        return None
    points = {"median": np.median(array), "p95": np.quantile(array, 0.95), "max": array.max()}
    return {"count": int(array.size), **{k: float(f"{v:.4g}") for k, v in points.items()}}


def in_words(result: dict[str, Any]) -> str:
    """The counts as Markdown tables."""
    seconds = result["seconds_a_loop"]
    pairs = {f"each {PAIR_SIZE:g} × noise": result["pairs"]}
    parts = [
        _head(result),
        "## False finds\n\n" + _table("clean loops", result["false_finds"]),
        "## One effect that a list knows, by size\n\n"
        + _table("size", result["listed_by_size"])
        + "\n\nMain name right of the loops fitted, and loops left out in brackets:\n\n"
        + _matrix(result["listed_by_effect"], "main_right"),
        "## Two effects\n\n" + _table("size", pairs),
        "## One effect on no list, by size\n\n"
        + _table("size", result["unlisted_by_size"])
        + "\n\nMain finding unknown of the loops fitted, and loops left out in brackets:\n\n"
        + _matrix(result["unlisted_by_effect"], "called_unknown"),
        "## Seconds a loop\n\n"
        + _lines(
            ["seconds", "median / 95 % / largest"], [[k, _shown(v)] for k, v in seconds.items()]
        ),
    ]
    return "\n\n".join(parts) + "\n"


def _head(result: dict[str, Any]) -> str:
    states = result["states_of_the_code"]
    words = (
        "# Effects traced on loops of the independent simulator\n\n"
        f"{result['loops']} loops: {result['fitted']} fitted, {result['not_drawable']} not "
        f"drawable and left out, {result['failed']} failed and left out. Not drawable: none of "
        f"{loops.ATTEMPTS} draws reached its size within {loops.OFF:.0%}; "
        f"{result['draws_rejected_on_the_way']} further draws were rejected before another "
        "did. Size: what the base model cannot absorb "
        "of the effect over the noise, both RMS. Shares with the 95 % interval of Clopper and "
        "Pearson; other figures as median / 95 % point / largest. "
        f"{loops.DECOYS:.0%} of the records without one got a temperature that tells nothing, "
        "and likewise an output angle."
    )
    if len(states) > 1:
        words += f"\n\n**The loops come from {len(states)} states of the code:** {_shown(states)}."
    if result["unreadable_lines"]:
        words += f"\n\n{result['unreadable_lines']} lines of the file could not be read."
    return words


def _table(corner: str, columns: dict[str, dict[str, Any]]) -> str:
    """One row a figure, one column a size or sort of loop."""
    if not columns:
        return "No loops."
    rows = [
        [name.replace("_", " "), *(_shown(column[name]) for column in columns.values())]
        for name in next(iter(columns.values()))
    ]
    return _lines([corner, *columns], rows)


def _matrix(effects: dict[str, dict[str, Any]], key: str) -> str:
    sizes = [f"{size:g}" for size in SIZES]
    rows = [[name, *(_cell(by.get(size), key) for size in sizes)] for name, by in effects.items()]
    return _lines(["effect", *sizes], rows)


def _cell(one: dict[str, Any] | None, key: str) -> str:
    if one is None:
        return "–"
    left = one["not_drawable"] + one["failed"]
    return f"{one[key]['count']}/{one[key]['of']}" + (f" ({left})" if left else "")


def _lines(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _shown(value: Any) -> str:
    """A count, share, spread or tally in words."""
    if not isinstance(value, dict):
        return "–" if value is None else str(value)
    if "interval_95" in value:
        if not value["of"]:
            return "–"
        low, high = value["interval_95"]
        return f"{value['count']}/{value['of']} = {value['share']:.1%} ({low:.1%} to {high:.1%})"
    if "median" in value:
        return f"{value['median']:.3g} / {value['p95']:.3g} / {value['max']:.3g}"
    return ", ".join(f"{name} {count}" for name, count in value.items()) or "–"
