"""What no mechanism carries: an empirical term beside the mechanisms, or in their place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from hdprog.discovery.model import Model
from hdprog.discovery.pooling import THRESHOLD, pooled, refitted, share
from hdprog.discovery.unknown import TermGain, term_gains, with_term

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
_LIKE_NOISE = ("time", "order")


def with_unknown(
    bases: Sequence[Model],
    models: Sequence[Model],
    remaining: Sequence[Mapping[str, TermGain]] | None,
    spread: Callable[..., Iterable[Any]],
) -> list[Model]:
    """Add an empirical term where structure remains, or put it in the mechanisms' place.

    `remaining` are the terms over `models`, where the last step has found them already.
    """
    remaining = list(spread(term_gains, models)) if remaining is None else remaining
    best, gain = _best_term(remaining)
    if not any(model.ids for model in models):
        return _with_term(models, remaining, best, spread) if gain > 0 else list(bases)
    wider = _with_term(models, remaining, best, spread)
    own = list(spread(term_gains, bases))
    best_alone, alone_gain = _best_term(own)
    alone = _with_term(bases, own, best_alone, spread)
    floor = min(sum(model.misfit for model in many) for many in (wider, alone))
    base, left, left_alone = (
        sum(model.misfit for model in many) for many in (bases, models, alone)
    )
    evidence = sum(
        one.log_evidence - other.log_evidence for one, other in zip(models, alone, strict=True)
    )
    poorly = (base - left) < NAMED_SHARE * (base - floor)
    beaten = evidence < -THRESHOLD and left > AS_GOOD * left_alone
    if alone_gain > 0 and (beaten or (poorly and evidence < 0)):
        return alone
    if gain > 0 and share(bases, models, wider) > UNKNOWN_SHARE:
        return wider
    return list(models)


def _best_term(terms: Sequence[Mapping[str, TermGain]]) -> tuple[str, float]:
    """Coordinate whose empirical term gains most, and by how much that is above its threshold."""
    names = set.intersection(*(set(found) for found in terms))
    gains = {
        name: pooled([found[name].gain for found in terms])
        - (TIME_THRESHOLD if name in _LIKE_NOISE else TERM_THRESHOLD)
        for name in sorted(names)
    }
    best = max(gains, key=lambda name: gains[name])
    return best, gains[best]


def _with_term(
    models: Sequence[Model],
    terms: Sequence[Mapping[str, TermGain]],
    coordinate: str,
    spread: Callable[..., Iterable[Any]],
) -> list[Model]:
    """The models with the empirical term over a coordinate, where it gains anything."""
    own = [found[coordinate] for found in terms]
    having = [at for at, term in enumerate(own) if term.gain > 0 or len(models) == 1]
    return refitted(models, having, spread, with_term, own)
