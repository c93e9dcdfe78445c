"""Test of uniform ranks: a band that the whole ECDF stays inside with a stated probability.

Säilynoja, Bürkner & Vehtari, Statistics and Computing 32 (2022) 32. Ranks 0 … L of N loops are
uniform where a posterior is calibrated. At a place k/(L + 1) the number of ranks below k is then
binomial, Bin(N, k/(L + 1)), and the count at one place given that at the place before is binomial
too. So the probability that all counts stay between bounds is had exactly, place by place (their
Algorithm 2), and no simulation is needed: neither for the band nor for a p value.

The distance of a sample is its worst place: the least two-sided binomial tail there,

    γ = min over k of  2 · min(P(X_k ≤ count_k), P(X_k ≥ count_k)),

and the band of a level holds the counts whose tails all exceed the γ that gives that level.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln
from scipy.stats import binom

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_MOST_PLACES = 128
_HALVINGS = 25
_NEVER = 1e-14
"""Tail of counts that are left out of the sums, so that p values below 1e-11 are not told apart."""
_ALIKE = 1 + 1e-9  # tails that differ by their rounding only


@dataclass(frozen=True)
class Uniformity:
    """The test for so many ranks.

    Attributes
    ----------
    count : N, number of ranks
    highest : L, the largest rank possible
    """

    count: int
    highest: int

    @cached_property
    def places(self) -> IntArray:
        """(places,) k at which the ECDF is looked at, evenly spaced and at most 128 of them."""
        wanted = min(self.highest, _MOST_PLACES - 1)
        return np.unique(np.linspace(0, self.highest + 1, wanted + 2)[1:-1].round().astype(int))

    @cached_property
    def shares(self) -> FloatArray:
        """(places,) k/(L + 1), what the ECDF should be there."""
        return np.asarray(self.places / (self.highest + 1))

    @cached_property
    def _tails(self) -> FloatArray:
        """(places, N + 1) two-sided tail of every count at every place."""
        counts = np.arange(self.count + 1)[None, :]
        below = binom.cdf(counts, self.count, self.shares[:, None])
        above = binom.sf(counts - 1, self.count, self.shares[:, None])
        return np.asarray(2 * np.minimum(below, above))

    def counts(self, ranks: IntArray) -> IntArray:
        """Number of ranks below each place, (places,) of ranks (N,).

        Raises
        ------
        ValueError
            for another number of ranks than N, or ranks outside 0 … L
        """
        if ranks.shape != (self.count,) or ranks.min() < 0 or ranks.max() > self.highest:
            raise ValueError(f"expected {self.count} ranks from 0 to {self.highest}")
        by_rank = np.bincount(ranks, minlength=self.highest + 1)
        return np.asarray(np.cumsum(by_rank)[self.places - 1])

    def distance(self, ranks: IntArray) -> float:
        """γ of ranks (N,): the smaller, the less uniform."""
        return float(self._tails[np.arange(self.places.size), self.counts(ranks)].min())

    def p_value(self, ranks: IntArray) -> float:
        """Probability that uniform ranks are as far off as these (N,) or further; exact."""
        return max(0.0, 1.0 - self._probability(self._tails > self.distance(ranks) * _ALIKE))

    def critical(self, rate: float) -> float:
        """The γ whose band uniform ranks leave with a probability of at most `rate`."""
        low, high = 0.0, rate  # one place alone leaves its tail of γ with probability γ at most
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            inside = self._probability(self._tails > middle)
            low, high = (middle, high) if 1.0 - inside <= rate else (low, middle)
        return low

    def band(self, rate: float) -> tuple[FloatArray, FloatArray]:
        """Least and largest ECDF at the places that stay inside the band, (places,) each."""
        inside = self._tails > self.critical(rate)
        lowest = np.argmax(inside, axis=1)
        largest = self.count - np.argmax(inside[:, ::-1], axis=1)
        return lowest / self.count, largest / self.count

    def _probability(self, inside: NDArray[np.bool_]) -> float:
        """Probability that uniform ranks have allowed counts (places, N + 1) at all places."""
        log_factorial = gammaln(np.arange(self.count + 1) + 1.0)
        alive = np.zeros(1, dtype=np.intp)  # counts that are possible at the place before
        mass = np.ones(1)
        before = 0.0
        for share, allowed in zip(self.shares, inside & (self._tails > _NEVER), strict=True):
            following = np.flatnonzero(allowed)
            if following.size == 0:
                return 0.0
            among = (share - before) / (1.0 - before)
            left = self.count - alive[:, None]
            more = following[None, :] - alive[:, None]
            possible = np.maximum(more, 0)
            rest = left - possible
            log_step = log_factorial[left] - log_factorial[possible] - log_factorial[rest]
            log_step += possible * np.log(among) + rest * np.log1p(-among)
            mass = mass @ np.where(more >= 0, np.exp(log_step), 0.0)
            alive, before = following, share
        return float(mass.sum())


@cache
def uniformity(count: int, highest: int) -> Uniformity:
    """The test for N ranks from 0 to L, kept for the next call."""
    return Uniformity(count, highest)
