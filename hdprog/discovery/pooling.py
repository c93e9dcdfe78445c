"""What the tests of a drive say together: their evidence pooled, and shares of their error."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from hdprog.discovery.model import Model

THRESHOLD = 5.0
"""Log evidence that an effect must gain. Rates on simulated loops: tests/benchmarks/effects."""


def pooled(gains: Sequence[float]) -> float:
    """Log evidence of "some tests have it" over "none has it", each as likely as not."""
    if len(gains) == 1:
        return gains[0]
    return float(np.sum(np.logaddexp(0.0, gains) - np.log(2.0)))


def share(bases: Sequence[Model], before: Sequence[Model], after: Sequence[Model]) -> float:
    """Share of the error explained by `after` that it explains and `before` does not."""
    return share_of(*(sum(model.misfit for model in many) for many in (bases, before, after)))


def share_of(base: float, before: float, after: float) -> float:
    """The same of three misfits."""
    return float(np.clip((before - after) / (base - after), -1.0, 1.0)) if base > after else 0.0


def refitted(
    models: Sequence[Model],
    places: Sequence[int],
    spread: Callable[..., Iterable[Any]],
    refit: Callable[..., Model],
    *arguments: Sequence[Any],
) -> list[Model]:
    """The models, refitted in some places; the others stay the very same.

    Parameters
    ----------
    models : one a test
    places : of those to refit
    spread : map over them, e.g. an executor's
    refit : of a model and its arguments
    arguments : sequences, one a test each
    """
    found = list(models)
    jobs = ([each[at] for at in places] for each in (models, *arguments))
    for at, model in zip(places, spread(refit, *jobs), strict=True):
        found[at] = model
    return found


def children(rngs: Sequence[np.random.Generator]) -> list[np.random.Generator]:
    """Generators for one piece of work: the next draws differ, whichever process does it."""
    return [rng.spawn(1)[0] for rng in rngs]
