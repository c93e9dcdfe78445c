"""What the tests of a drive say together: their evidence pooled, and shares of their error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

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


def replaced(models: Sequence[Model], places: Sequence[int], by: Iterable[Model]) -> list[Model]:
    """The models with others in some places."""
    found = list(models)
    for at, model in zip(places, by, strict=True):
        found[at] = model
    return found
