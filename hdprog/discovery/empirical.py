"""What no mechanism carries: an empirical term beside the mechanisms, or in their place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from hdprog.discovery.model import Model, gain_of_curve, gain_over
from hdprog.discovery.pooling import THRESHOLD, children, pooled, refitted, share
from hdprog.discovery.unknown import TERM_PENALTY, TermGain, term_gains, with_term

TERM_THRESHOLD = 5.0
"""Log evidence that an empirical term must gain."""
TIME_THRESHOLD = 14.0
"""The same for a term over time or order, which correlated noise looks like."""
UNKNOWN_SHARE = 0.08
"""Share of the explained error that an empirical term must carry beside mechanisms."""
NAMED_SHARE = 0.75
"""Share of the explainable error below which mechanisms give way to an empirical term."""
AS_GOOD = 1.15
"""Misfit over that of an empirical term alone, up to which mechanisms are not beaten by it: a free
curve follows the noise a little as well."""
_NOISE = 1.05  # mean square of what is left over the noise's, up to which it is noise alone
_TINY = 1e-12
_LIKE_NOISE = ("time", "order")
_REFITTED, _RIVAL = 3, 0.5  # coordinates, and the share of the leading one's gain that they need


def with_unknown(
    bases: Sequence[Model],
    models: Sequence[Model],
    remaining: Sequence[Mapping[str, TermGain]] | None,
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
) -> list[Model]:
    """Add an empirical term where structure remains, or put it in the mechanisms' place.

    `remaining` are the terms over `models`, where the last step has found them already; `rngs`,
    one a test, are spawned from.
    """
    remaining = list(spread(term_gains, models)) if remaining is None else remaining
    gain, named = over_threshold(remaining), any(model.ids for model in models)
    if gain <= 0 and not named:
        return list(bases)
    if gain <= -TERM_THRESHOLD and _noise_alone(models):
        # No curve gains anything beside the mechanisms: none does better in their place.
        return list(models)
    wider = _with_term(models, remaining, rngs, spread)
    if not named:
        return wider
    own = list(spread(term_gains, bases))
    alone = _with_term(bases, own, rngs, spread)
    base, left, left_alone, left_both = (
        sum(model.misfit for model in many) for many in (bases, models, alone, wider)
    )
    floor = min(left_both, left_alone)
    evidence = sum(gain_over(other, one) for one, other in zip(models, alone, strict=True))
    carried = (base - left) / max(base - floor, _TINY)
    beaten = evidence < -THRESHOLD and left > AS_GOOD * left_alone
    if over_threshold(own) > 0 and (beaten or (carried < NAMED_SHARE and evidence < 0)):
        # A curve may want the mechanism beside it, which carries most of what both explain; noise
        # with a memory must not make up for what they leave.
        beside = sum(gain_over(other, one) for one, other in zip(wider, alone, strict=True))
        wanted = beside > THRESHOLD and left_both <= left_alone
        return wider if wanted and carried >= NAMED_SHARE else alone
    if gain > 0 and share(bases, models, wider) > UNKNOWN_SHARE:
        return wider
    return list(models)


def _noise_alone(models: Sequence[Model]) -> bool:
    """Whether what models leave is no more than noise."""
    left = sum(model.misfit for model in models)
    return left <= _NOISE * sum(model.likelihood.blocks for model in models)


def over_threshold(terms: Sequence[Mapping[str, TermGain]]) -> float:
    """By how much the empirical term that gains most passes its threshold."""
    return max(_pooled_gains(terms).values())


def strongest(terms: Sequence[Mapping[str, TermGain]]) -> tuple[str, float, float]:
    """Coordinate of the empirical term that gains most over its threshold.

    With its log evidence, and by how much that passes the threshold.
    """
    name, over = max(_pooled_gains(terms).items(), key=lambda item: item[1])
    return name, pooled([found[name].gain for found in terms]), over


def _pooled_gains(terms: Sequence[Mapping[str, TermGain]]) -> dict[str, float]:
    """Log evidence above its threshold that a term over each coordinate gains over all tests."""
    names = set.intersection(*(set(found) for found in terms))
    return {
        name: _above_threshold(name, [found[name].gain for found in terms])
        for name in sorted(names)
    }


def _above_threshold(coordinate: str, gains: Sequence[float]) -> float:
    return pooled(gains) - (TIME_THRESHOLD if coordinate in _LIKE_NOISE else TERM_THRESHOLD)


def _with_term(
    models: Sequence[Model],
    terms: Sequence[Mapping[str, TermGain]],
    rngs: Sequence[np.random.Generator],
    spread: Callable[..., Iterable[Any]],
) -> list[Model]:
    """The models with an empirical term over the coordinate that gains most, where it does.

    A gain is that of a model linearised at its mode, which the term may move far: the coordinates
    that lead are all refitted.
    """
    gains = _pooled_gains(terms)
    least = _RIVAL * max(gains.values())
    leading = sorted(gains, key=lambda name: -gains[name])
    leading = leading[:1] + [name for name in leading[1:_REFITTED] if gains[name] > least > 0]
    found = {}
    for name in leading:
        own = [one[name] for one in terms]
        having = [at for at, term in enumerate(own) if term.gain > 0 or len(models) == 1]
        wider = refitted(models, having, spread, with_term, own, children(rngs))
        gained = [term.gain for term in own]
        for at in having:
            gained[at] = gain_of_curve(models[at], wider[at]) - TERM_PENALTY
        found[name] = (_above_threshold(name, gained), wider)
    return max(found.values(), key=lambda one: one[0])[1]
