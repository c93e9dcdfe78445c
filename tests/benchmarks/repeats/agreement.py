"""How far apart repeats are in units of their intervals, and how often they agree."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, chi2

from tests.benchmarks.repeats import LEVELS, Fit

FloatArray = NDArray[np.float64]

LEVEL = 0.90
Z = 1.6448536
_RESAMPLED = 2000
_SEED = 5


@dataclass(frozen=True)
class Pair:
    """Two repeats of one state in one quantity.

    Attributes
    ----------
    group, quantity : what is compared
    z : difference of the means over the root of the summed variances, the later minus the earlier
    above : posterior probability that the later is the larger
    contraction : smaller one of both
    """

    group: str
    quantity: str
    z: float
    above: float
    contraction: float

    @property
    def agrees(self) -> bool:
        """Whether the difference's central 90 % interval holds zero."""
        return (1 - LEVEL) / 2 < self.above < (1 + LEVEL) / 2


def disjoint_pairs(
    groups: Mapping[str, Sequence[Fit]], quantities: Sequence[str], *, beside_readings: bool = False
) -> list[Pair]:
    """Repeats 0 and 1, 2 and 3, …: none is used twice, so that the pairs are independent.

    Beside readings, what the records themselves show a figure to change by is taken off.
    """
    return [
        _pair(name, quantity, fits[at], fits[at + 1], beside_readings=beside_readings)
        for name, fits in groups.items()
        for at in range(0, len(fits) - 1, 2)
        for quantity in quantities
    ]


def _pair(name: str, quantity: str, one: Fit, two: Fit, *, beside_readings: bool) -> Pair:
    first, second = (np.array(fit.quantiles[quantity]) for fit in (one, two))
    change = 0.0
    if beside_readings and quantity in one.direct and quantity in two.direct:
        change = two.direct[quantity] - one.direct[quantity]
    difference = second[:, None] - first[None, :] - change
    above = float((difference > 0).mean() + 0.5 * (difference == 0).mean())
    spread = np.hypot(one.sd[quantity], two.sd[quantity])
    z = (two.mean[quantity] - one.mean[quantity] - change) / spread
    contraction = min(one.contraction[quantity], two.contraction[quantity])
    return Pair(name, quantity, float(z), above, contraction)


def pooled_chi_square(groups: Mapping[str, Sequence[Fit]], quantity: str) -> tuple[float, int]:
    """Sum over the groups of squared distances from their weighted mean, and its degrees.

    Groups of which a fit holds the quantity for certain (no slip, no width) are left out.
    """
    total, degrees = 0.0, 0
    for fits in groups.values():
        if not all(fit.sd[quantity] > 0 for fit in fits):
            continue
        mean = np.array([fit.mean[quantity] for fit in fits])
        weight = np.array([fit.sd[quantity] for fit in fits]) ** -2.0
        total += float(weight @ (mean - np.average(mean, weights=weight)) ** 2)
        degrees += len(fits) - 1
    return total, degrees


def tails(total: float, degrees: int) -> tuple[float, float]:
    """Probability of a chi-square as large, and of one as small."""
    return float(chi2.sf(total, degrees)), float(chi2.cdf(total, degrees))


def shares(
    items: Sequence[tuple[str, bool]], rate: float = 0.05
) -> dict[str, float | int | list[float]]:
    """Share that is true, with its interval by resampling whole groups.

    Parameters
    ----------
    items : group and whether it holds; quantities of one group hang together
    """
    names = sorted({name for name, _ in items})
    held = np.array([sum(ok for name, ok in items if name == one) for one in names], dtype=float)
    size = np.array([sum(name == one for name, _ in items) for one in names], dtype=float)
    rng = np.random.default_rng(_SEED)
    chosen = rng.integers(len(names), size=(_RESAMPLED, len(names)))
    drawn = held[chosen].sum(axis=1) / size[chosen].sum(axis=1)
    low, high = np.quantile(drawn, (rate / 2, 1 - rate / 2))
    return {
        "share": float(held.sum() / size.sum()),
        "count": int(size.sum()),
        "interval_95": [float(low), float(high)],
    }


def binomial_interval(held: int, count: int, rate: float = 0.05) -> tuple[float, float]:
    """Exact interval of a share (Clopper and Pearson)."""
    low = float(beta.ppf(rate / 2, held, count - held + 1)) if held else 0.0
    high = float(beta.isf(rate / 2, held + 1, count - held)) if held < count else 1.0
    return low, high


def below(fit: Fit, quantity: str, value: float) -> float:
    """Share of a posterior below a value, by its stored quantiles."""
    return float(np.interp(value, fit.quantiles[quantity], LEVELS, left=0.0, right=1.0))


def inside(fit: Fit, quantity: str, value: float, level: float = LEVEL) -> bool:
    """Whether a posterior's central interval holds a value."""
    return (1 - level) / 2 < below(fit, quantity, value) < (1 + level) / 2


def held_by(
    fits: Sequence[Fit],
    quantities: Sequence[str],
    known: Callable[[Fit], Mapping[str, float]],
    level: float = LEVEL,
) -> list[tuple[str, bool]]:
    """Group and whether the interval holds the known value, for all fits and quantities."""
    return [
        (fit.group, inside(fit, name, known(fit)[name], level))
        for fit in fits
        for name in quantities
        if name in known(fit)
    ]


def steps(groups: Mapping[str, Sequence[Fit]], quantity: str) -> list[tuple[str, float]]:
    """Relative change of a figure read off the record, from each repeat to the next."""
    return [
        (name, two.direct[quantity] / one.direct[quantity] - 1)
        for name, fits in groups.items()
        for one, two in pairwise(fits)
        if quantity in one.direct and quantity in two.direct
    ]
