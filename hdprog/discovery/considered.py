"""Effects that were looked at and not added, and why not."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from hdprog.discovery.heldout import HeldOut, elpd_difference, held_out
from hdprog.discovery.pooling import THRESHOLD
from hdprog.discovery.search import Traced
from hdprog.explanation import ConsideredEffect, spoken_effect
from hdprog.physics.effects import BY_ID

_WEIGHED = 3  # of the best, by held-out data


def considered(traced: Traced, held_before: HeldOut, alone: bool) -> tuple[ConsideredEffect, ...]:
    """What was looked at and not added, best first, then what the record cannot show.

    Parameters
    ----------
    traced : what the search found
    held_before : what held-out data say of the drive model alone
    alone : whether the record was searched by itself; held-out data then weigh the best, too
    """
    first = traced.steps[0]
    gains, each = first.gains, [step.gains for step in traced.steps]
    looked_at: list[ConsideredEffect] = []
    for rank, name in enumerate(sorted(gains, key=lambda name: -gains[name])):
        if name in traced.final.ids:
            continue
        gain, error = None, None
        if alone and rank < _WEIGHED and gains[name] > 0:
            held = held_out(traced.prepared, first.models[name])
            gain, error = elpd_difference(held, held_before)
        curve = traced.final.term is not None
        why = why_not(name, each, traced.mechanisms.ids, traced.final.ids, curve, decided=alone)
        looked_at.append(ConsideredEffect(name, BY_ID[name].words, gains[name], gain, error, why))
    lacking = [
        ConsideredEffect(
            name,
            BY_ID[name].words,
            None,
            None,
            None,
            cannot_be_told([needs]),
        )
        for name, needs in traced.missing.items()
    ]
    return (*looked_at, *lacking)


def cannot_be_told(needs: Sequence[Sequence[str]]) -> str:
    """Why no record shows an effect: what all lack, else what one or the other does."""
    if len(needs) == 1:
        return f"cannot be told from this record: it lacks {' and '.join(needs[0])}"
    each = [set(lacking) for lacking in needs]
    all_lack = " and ".join(sorted(set.intersection(*each)))
    lacking = all_lack or " or ".join(sorted(set.union(*each)))
    return f"cannot be told from any of the {len(needs)} tests: they lack {lacking}"


def why_not(
    name: str,
    gains: Sequence[Mapping[str, float]],
    mechanisms: Collection[str],
    final: Collection[str],
    curve: bool,
    *,
    decided: bool,
) -> str:
    """Why an effect was not added.

    Parameters
    ----------
    name : its id
    gains : of log evidence by id, one mapping a forward step
    mechanisms, final : ids that the search took, and that were left in the end
    curve : whether an empirical term was added
    decided : whether the search went by these gains, and not by those of all tests together
    """
    gain = gains[0][name]
    most = max(step[name] for step in gains if name in step)
    if name not in mechanisms and most < THRESHOLD:
        return f"no evidence: log Bayes factor {_told(gain)} where {THRESHOLD:g} is asked for"
    if name in mechanisms:
        return (
            "carries part of the error only; an empirical term carries more of it, so the "
            "mechanism is not believed"
        )
    if final:
        best = max(gains[0][one] for one in final if one in gains[0])
        last = next((step[name] for step in reversed(gains) if name in step), gain)
        beside = " + ".join(spoken_effect(one) for one in final)
        if len(gains) > 1 and last < THRESHOLD:
            return (
                f"log Bayes factor {_told(gain)} where {best:.1f} was reached; beside {beside} it "
                f"gains nothing more ({_told(last)})"
            )
        too_little = "it would carry too little of the error"
        if not decided:
            too_little = f"over all tests it gains too little, or {too_little}"
        return f"log Bayes factor {_told(last)} beside {beside}, but {too_little}"
    if not decided:
        return f"log Bayes factor {_told(gain)} on this test, too little over all tests"
    if curve:
        return f"log Bayes factor {_told(gain)}, less than an empirical term gains"
    return f"log Bayes factor {_told(gain)}, and not kept in the end"


def _told(gain: float) -> str:
    """To one decimal, and no minus before a zero."""
    return f"{round(gain, 1) + 0.0:.1f}"
