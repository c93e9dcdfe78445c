"""The numbers of the run, and the same in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import norm

from hdprog.physics.parameters import NAMES
from tests.benchmarks.repeats import DRIVE, EXPLAINED, MODELS, NOISES, WHITE, WIDENED, Fit, grouped
from tests.benchmarks.repeats.agreement import (
    LEVEL,
    Pair,
    Z,
    binomial_interval,
    disjoint_pairs,
    held_by,
    pooled_chi_square,
    shares,
    steps,
    tails,
)
from tests.benchmarks.repeats.control import LENGTHS
from tests.benchmarks.repeats.fits import FIGURES, QUANTITIES
from tests.benchmarks.repeats.records import KINDS, SMALL, kind_of

DIRECT = FIGURES[:3]
SIMULATED = tuple(f"simulated {length}" for length in LENGTHS)
_LABELS = {
    "hysteresis_width_arcmin": "width",
    "hysteresis_loss_J": "loss",
    "lost_motion_arcmin": "lost motion",
    "secant_stiffness_Nm_per_rad": "secant stiffness",
}


def label(quantity: str) -> str:
    """Short name of a quantity."""
    return _LABELS.get(quantity, quantity.removesuffix("_Nm_per_rad"))


def chosen(fits: Iterable[Fit], kind: str, model: str, noise: str) -> dict[str, list[Fit]]:
    """Groups of one kind, model and noise with at least two fitted repeats."""
    found = grouped(
        one
        for one in fits
        if kind_of(one.group) == kind and one.model == model and one.noise == noise
    )
    return {name: repeats for name, repeats in found.items() if len(repeats) > 1}


def summary(fits: Sequence[Fit], unreadable: int) -> dict[str, Any]:
    """All numbers, ready for JSON."""
    codes: dict[str, int] = {}
    for one in fits:
        codes[one.code] = codes.get(one.code, 0) + 1
    return {
        "fits": len(fits),
        "failed": [one.words for one in fits if one.status != "fitted"],
        "not_converged": sum(one.status == "fitted" and not one.converged for one in fits),
        "unreadable_lines": unreadable,
        "absent": [kind for kind in KINDS if not any(kind_of(one.group) == kind for one in fits)],
        "states_of_the_code": codes,
        "repeats": {
            f"{kind}, {model}, {noise}": _repeats(groups)
            for kind in (*KINDS, *SIMULATED)
            for model in MODELS
            for noise in NOISES
            if (groups := chosen(fits, kind, model, noise))
        },
        "truth": {
            f"{kind}, {noise}": _truth([one for many in groups.values() for one in many])
            for kind in SIMULATED
            for noise in NOISES
            if (groups := chosen(fits, kind, DRIVE, noise))
        },
        "widened_over_white": {
            f"{kind}, {model}": _wider(
                chosen(fits, kind, model, WIDENED), chosen(fits, kind, model, WHITE)
            )
            for kind in (*KINDS, *SIMULATED)
            for model in MODELS
            if chosen(fits, kind, model, WIDENED)
        },
        "steps": {kind: _steps(chosen(fits, kind, DRIVE, WIDENED)) for kind in KINDS},
    }


def _repeats(groups: Mapping[str, Sequence[Fit]]) -> dict[str, Any]:
    pairs = disjoint_pairs(groups, QUANTITIES)
    figures = [pair for pair in pairs if pair.quantity in FIGURES]
    parameters = [pair for pair in pairs if pair.quantity in NAMES]
    fits = [one for many in groups.values() for one in many]
    return {
        "states": len(groups),
        "cycles": len(fits),
        "converged": float(np.mean([one.converged for one in fits])),
        "correlated_noise": float(np.mean([one.correlated for one in fits])),
        "ou_length": _quartiles([one.ou_length for one in fits if one.correlated]),
        "residual_urad": _quartiles([1e6 * one.residual_rad for one in fits]),
        "effects": sorted({"; ".join(one.effects) for one in fits if one.effects}),
        "figures": _agreement(figures),
        "beside_readings": _agreement(disjoint_pairs(groups, FIGURES, beside_readings=True)),
        "parameters": _agreement(parameters),
        "by_quantity": {
            name: _of_quantity(groups, [pair for pair in pairs if pair.quantity == name], name)
            for name in QUANTITIES
        },
        "direct": {
            name: _against(fits, name, [one.direct.get(name) for one in fits]) for name in DIRECT
        },
        "apart": [
            {
                "state": pair.group,
                "quantity": pair.quantity,
                "z": round(pair.z, 2),
            }
            for pair in sorted(figures, key=lambda pair: -abs(pair.z))
            if not pair.agrees
        ],
    }


def _agreement(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Shares of pairs that agree; what a prior fixes agrees more often than the level says."""
    bound = [Z / np.sqrt(np.clip(pair.contraction, 0.02, 1.0)) for pair in pairs]
    return {
        "agree": shares([(pair.group, pair.agrees) for pair in pairs]),
        "agree_by_z": shares([(pair.group, abs(pair.z) < Z) for pair in pairs]),
        "expected": float(np.mean(2 * norm.cdf(bound) - 1)),
    }


def _of_quantity(
    groups: Mapping[str, Sequence[Fit]], pairs: Sequence[Pair], name: str
) -> dict[str, Any]:
    total, degrees = pooled_chi_square(groups, name)
    large, small = tails(total, degrees)
    held = sum(pair.agrees for pair in pairs)
    return {
        "agree": held,
        "pairs": len(pairs),
        "interval_95": list(binomial_interval(held, len(pairs))),
        "distance": float(np.sqrt(total / degrees)),
        "degrees": degrees,
        "p_as_far": large,
        "p_as_near": small,
        "contraction": float(np.median([pair.contraction for pair in pairs])),
        "sd": float(np.median([one.sd[name] for many in groups.values() for one in many])),
    }


def _against(
    fits: Sequence[Fit], name: str, values: Sequence[float | None]
) -> dict[str, Any] | None:
    """Intervals against a known value of each fit."""
    known = {id(one): value for one, value in zip(fits, values, strict=True) if value is not None}
    if not known:
        return None
    compared = [one for one in fits if id(one) in known]
    held = held_by(compared, [name], lambda one: {name: known[id(one)]})
    # A figure that is zero in every draw has no spread to count in.
    spread = [one for one in compared if one.sd[name] > 0]
    off = [(one.mean[name] - known[id(one)]) / one.sd[name] for one in spread]
    part = [one.mean[name] / known[id(one)] - 1 for one in compared]
    return {
        **shares(held),
        "rms_z": float(np.sqrt(np.mean(np.square(off)))),
        "median_off": float(np.median(part)),
    }


def _truth(fits: Sequence[Fit]) -> dict[str, Any]:
    return {
        "cycles": len(fits),
        "correlated_noise": float(np.mean([one.correlated for one in fits])),
        "coverage_90_figures": shares(held_by(fits, FIGURES, lambda one: one.truth)),
        "coverage_50_figures": shares(held_by(fits, FIGURES, lambda one: one.truth, 0.5)),
        "coverage_90_parameters": shares(held_by(fits, NAMES, lambda one: one.truth)),
        "coverage_50_parameters": shares(held_by(fits, NAMES, lambda one: one.truth, 0.5)),
        "by_quantity": {
            name: _against(fits, name, [one.truth.get(name) for one in fits]) for name in QUANTITIES
        },
    }


def _wider(
    widened: Mapping[str, Sequence[Fit]], white: Mapping[str, Sequence[Fit]]
) -> dict[str, float]:
    """Median ratio of the standard deviations."""
    return {
        quantity: float(
            np.median(
                [
                    one.sd[quantity] / other.sd[quantity]
                    for name, many in widened.items()
                    for one, other in zip(many, white[name], strict=True)
                    if other.sd[quantity] > 0
                ]
            )
        )
        for quantity in QUANTITIES
    }


def _steps(groups: Mapping[str, Sequence[Fit]]) -> dict[str, Any]:
    """Changes from a cycle to the next of what is read off the record, in parts."""
    found = {}
    for name in DIRECT:
        changes = [change for _, change in steps(groups, name)]
        if changes:
            moves = [
                (two.direct[name] - one.direct[name], two.mean[name] - one.mean[name])
                / np.hypot(one.sd[name], two.sd[name])
                for many in groups.values()
                for one, two in pairwise(many)
                if name in one.direct and name in two.direct
            ]
            read, fitted = np.sqrt(np.mean(np.square(moves), axis=0))
            found[name] = {
                "read_rms_z": float(read),
                "fitted_rms_z": float(fitted),
                "changes": [round(change, 4) for change in changes],
                "falling": int(sum(change < 0 for change in changes)),
                "median": float(np.median(changes)),
            }
    return found


def _quartiles(values: Sequence[float]) -> list[float] | None:
    return [float(q) for q in np.quantile(values, (0.25, 0.5, 0.75))] if values else None


# ------------------------------------------------------------------------------------ in words


def in_words(result: Mapping[str, Any]) -> str:
    """The summary as Markdown."""
    parts = [
        "# Do fits of repeated cycles agree within their intervals?",
        f"{result['fits']} posteriors, {len(result['failed'])} failed, "
        f"{result['not_converged']} did not converge in a quick run and are kept in. "
        "Widened: the noise that the fit finds, white or white with an Ornstein-Uhlenbeck term; "
        "where that leads the fit away from the readings, least squares with the spread it gives. "
        "White: the same fit with white noise in spite of it. Posteriors agree where the central "
        f"{LEVEL:.0%} interval of their difference holds zero; right intervals do so in {LEVEL:.0%}"
        " of pairs, and in more where the prior says part of the answer (column expected).",
        *([f"**Not run: {', '.join(result['absent'])}.**"] if result["absent"] else []),
        "## How often repeats agree",
        "Disjoint pairs of neighbouring repeats, all seven figures (width, loss, lost motion, "
        "secant stiffness, K1 to K3) and all eight parameters. In brackets the 95 % range by "
        "resampling whole states, for the figures of one fit hang together. Beside readings: what "
        "the records themselves show width, loss and lost motion to change by from one repeat to "
        "the next is taken off first, for a drive that does change is no fault of intervals.",
        _agree_table(result),
        "## How far apart repeats are, in units of their intervals",
        "Root of pooled chi-square over its degrees of freedom: 1 where intervals are right, more "
        "where they are too narrow for the scatter of repeats. An asterisk: as far or further in "
        "less than 1 % of right intervals. In brackets pairs that agree.",
        _distance_table(result),
        "## Against what is read off the record",
        "Width, loss and lost motion of the same cycle without a model: straight lines through the "
        "readings near a torque, fall minus rise. An error of the model that all repeats share "
        "cancels between them and shows here. Share of 90 % intervals that hold the reading; "
        "distance of the mean from it (root mean square, standard deviations); median of mean over "
        "reading. Where explain found an empirical curve, what it adds is in none of these "
        "figures.",
        _direct_table(result),
        "## Simulated repeats, truth known",
        "Drives drawn from the prior, loops of the independent simulator, two records a drive. "
        f"The encoder's noise is 70 % Ornstein-Uhlenbeck with a memory of "
        f"{', '.join(f'{length:.0%}' for length in LENGTHS.values())} of the record.",
        _truth_table(result),
        "## What the widening does",
        "Median ratio of standard deviations, widened over white.",
        _wider_table(result),
        "## From a cycle to the next",
        "Change of what is read off the record, no fit in between: real changes of the drive. The "
        "last columns are root mean squares in units of the widened intervals of the drive model "
        "alone: where the fitted step is the larger, the fits disagree and not the cycles.",
        _steps_table(result),
        "## Figures that do not agree, widened",
        _apart_words(result),
    ]
    states = result["states_of_the_code"]
    if len(states) > 1:
        parts.append(f"**The fits come from {len(states)} states of the code:** {states}.")
    return "\n\n".join(parts) + "\n"


def _keys(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Kinds and models of the result, in their order."""
    found = [tuple(key.split(", ")[:2]) for key in result["repeats"]]
    return [(kind, model) for kind, model in dict.fromkeys(found)]


def _share_words(one: Mapping[str, Any]) -> str:
    low, high = one["interval_95"]
    return f"{one['share']:.0%} ({low:.0%} to {high:.0%})"


def _agree_table(result: Mapping[str, Any]) -> str:
    head = ["repeats", "model", "states", "cycles", "noise correlated", "converged"]
    head += [
        "figures, widened",
        "beside readings",
        "figures, white",
        "parameters, widened",
        "white",
        "expected",
    ]
    rows = []
    for kind, model in _keys(result):
        wide, white = (result["repeats"][f"{kind}, {model}, {noise}"] for noise in NOISES)
        rows.append(
            [
                kind,
                model,
                str(wide["states"]),
                str(wide["cycles"]),
                f"{wide['correlated_noise']:.0%}",
                f"{wide['converged']:.0%}",
                _share_words(wide["figures"]["agree"]),
                _share_words(wide["beside_readings"]["agree"]),
                _share_words(white["figures"]["agree"]),
                _share_words(wide["parameters"]["agree"]),
                _share_words(white["parameters"]["agree"]),
                f"{wide['figures']['expected']:.0%}, {wide['parameters']['expected']:.0%}",
            ]
        )
    return _table(head, rows)


def _distance_table(result: Mapping[str, Any]) -> str:
    head = ["repeats", "model", "noise", *(label(name) for name in QUANTITIES)]
    rows = []
    for kind, model in _keys(result):
        for noise in NOISES:
            by = result["repeats"][f"{kind}, {model}, {noise}"]["by_quantity"]
            rows.append([kind, model, noise, *(_distance(by[name]) for name in QUANTITIES)])
    return _table(head, rows)


def _distance(one: Mapping[str, Any]) -> str:
    star = "*" if one["p_as_far"] < 0.01 else ""
    return f"{one['distance']:.2f}{star} ({one['agree']}/{one['pairs']})"


def _direct_table(result: Mapping[str, Any]) -> str:
    head = ["repeats", "model", "noise", *(label(name) for name in DIRECT)]
    rows = []
    for key, one in result["repeats"].items():
        kind, model, noise = key.split(", ")
        if any(one["direct"].values()):
            rows.append([kind, model, noise, *(_against_words(one["direct"][n]) for n in DIRECT)])
    return _table(head, rows)


def _against_words(one: Mapping[str, Any] | None) -> str:
    if one is None:
        return "–"
    return f"{one['share']:.0%}, {one['rms_z']:.1f} sd, {one['median_off']:+.1%}"


def _truth_table(result: Mapping[str, Any]) -> str:
    head = ["repeats", "noise", "records", "noise found correlated", "figures: 90 % hold the truth"]
    head += ["50 %", "parameters: 90 %", "50 %"]
    rows = []
    for key, one in result["truth"].items():
        kind, noise = key.split(", ")
        cells = [
            _share_words(one[f"coverage_{level}_{what}"])
            for what in ("figures", "parameters")
            for level in (90, 50)
        ]
        rows.append([kind, noise, str(one["cycles"]), f"{one['correlated_noise']:.0%}", *cells])
    return _table(head, rows)


def _wider_table(result: Mapping[str, Any]) -> str:
    head = ["repeats", "model", *(label(name) for name in QUANTITIES)]
    rows = [
        [*key.split(", "), *(f"{one[name]:.2g}" for name in QUANTITIES)]
        for key, one in result["widened_over_white"].items()
    ]
    return _table(head, rows)


def _steps_table(result: Mapping[str, Any]) -> str:
    head = ["repeats", "figure", "steps", "falling", "median", "size of a step, read off", "fitted"]
    rows = [
        [
            kind,
            label(name),
            str(len(one["changes"])),
            str(one["falling"]),
            f"{one['median']:+.1%}",
            f"{one['read_rms_z']:.2f}",
            f"{one['fitted_rms_z']:.2f}",
        ]
        for kind, found in result["steps"].items()
        for name, one in found.items()
        if not (kind == SMALL and name == "lost_motion_arcmin")
    ]
    return _table(head, rows)


def _apart_words(result: Mapping[str, Any]) -> str:
    lines = []
    for key, one in result["repeats"].items():
        kind, model, noise = key.split(", ")
        if noise != WIDENED or kind in SIMULATED or not one["apart"]:
            continue
        named = "; ".join(
            f"{pair['state'].split(': ')[1]} {label(pair['quantity'])} {pair['z']:+.1f}"
            for pair in one["apart"]
        )
        lines.append(f"* {kind}, {model}: {named}")
    return "Later minus earlier repeat, in root summed variances.\n\n" + "\n".join(lines)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [list(head), ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


__all__ = ["DIRECT", "EXPLAINED", "in_words", "label", "summary"]
