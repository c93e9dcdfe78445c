"""The clock, and how many effective draws a set of chains has."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from hdprog.inference.diagnostics import diagnose
from hdprog.inference.likelihood import COUNT
from hdprog.inference.ridge_coordinates import to_unconstrained
from hdprog.physics.parameters import FloatArray
from tests.benchmarks.samplers.posteriors import Target

WANTED = 1000.0


class Watch:
    """Processor and wall seconds by part.

    On one core and one thread the two agree on an idle machine. On a shared one the wall clock also
    counts what others do.
    """

    def __init__(self) -> None:
        self.processor: dict[str, float] = {}
        self.wall: dict[str, float] = {}

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        """Add the time inside to a part."""
        processor, wall = time.process_time(), time.perf_counter()
        try:
            yield
        finally:
            self.processor[part] = self.processor.get(part, 0.0) + time.process_time() - processor
            self.wall[part] = self.wall.get(part, 0.0) + time.perf_counter() - wall

    def scale(self, part: str, share: float) -> None:
        """Keep a share of a part: what was needed of a run that was longer."""
        self.processor[part] *= share
        self.wall[part] *= share


@dataclass(frozen=True)
class Effective:
    """Of the worst of the nine coordinates.

    Attributes
    ----------
    bulk, tail : least effective draws, tail for the 5 % and 95 % quantiles
    rhat : largest rank-normalised split R-hat; 0 where there are no chains
    """

    bulk: float
    tail: float
    rhat: float

    @property
    def enough(self) -> bool:
        """Whether there are as many draws as wanted."""
        return min(self.bulk, self.tail) >= WANTED


@dataclass(frozen=True)
class Found:
    """What a sampler delivered.

    Attributes
    ----------
    points : (chains, draws, 9) points of the likelihood after the warm-up
    effective : of these
    watch : its clock, with parts "compile" and "run"
    evaluations, gradients : log densities without and with gradient, warm-up included
    weights : (draws,) of the one chain of a sampler that weights its draws, else None
    converged : what hdprog says of its own draws
    """

    points: FloatArray
    effective: Effective
    watch: Watch
    evaluations: int = 0
    gradients: int = 0
    weights: FloatArray | None = field(default=None, repr=False)
    converged: bool | None = None


def effective_draws(points: FloatArray) -> Effective:
    """By ArviZ, every walker a chain of its own.

    Laid step by step into one chain, walkers would hide each other's memory.

    Parameters
    ----------
    points : (chains, draws, 9)
    """
    worst = diagnose(points[:, :, None, :])
    with np.errstate(invalid="ignore"):
        return Effective(
            float(np.nan_to_num(worst.ess_bulk).min()),
            float(np.nan_to_num(worst.ess_tail).min()),
            float(np.nan_to_num(worst.rhat, nan=np.inf).max()),
        )


def points_of(target: Target, ridge: FloatArray) -> FloatArray:
    """Points of the likelihood (…, 9) of peers' positions (…, 9)."""
    flat = ridge.reshape(-1, ridge.shape[-1])
    unconstrained, _ = to_unconstrained(flat[:, :COUNT], *target.likelihood.ridge_frame)
    return np.hstack([unconstrained, flat[:, COUNT:]]).reshape(ridge.shape)
