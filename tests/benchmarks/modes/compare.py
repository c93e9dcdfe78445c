"""hdprog's draws of a loop beside the reference's: means, spreads, modes, and cells of the whole.

Every difference comes with its Monte-Carlo error, that of hdprog's chains and of the reference
together. A difference counts as one where it is beyond the limit by more than two such errors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2, vq
from scipy.ndimage import gaussian_filter1d

from hdprog.inference.lazy_arviz import arviz
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.physics.figures import Operation, figures, standard_requests
from hdprog.physics.parameters import NAMES, FloatArray
from tests.benchmarks.modes.annealed import Reference
from tests.benchmarks.modes.coordinates import RIDGE, ridge

MEAN_LIMIT = 0.05
"""Of a mean's difference, in the reference's standard deviations."""
SD_LIMIT = 0.02
"""Of a standard deviation's ratio to the reference's, from one."""
SURE = 2.0
"""Monte-Carlo errors that a difference may add to its limit."""
MODE = 0.01
"""Least mass of what counts as a mode."""
DEEP = 0.5
"""A valley between two modes is lower than this part of the lower of the two peaks."""
CELLS = 40
_BINS, _SMOOTH = 120, 2.5
_FIGURE_DRAWS = 2000  # of each population; width and loss are traced along whole cycles
_SEED = 3


@dataclass(frozen=True)
class Separator:
    """A valley of a marginal distribution, and the modes to its sides.

    Attributes
    ----------
    coordinate : name, of `coordinates`
    cut : where the valley is
    depth : density there over that of the lower peak; None for a cut that the case names
    """

    coordinate: str
    cut: float
    depth: float | None


def coordinates(likelihood: LoopLikelihood, points: FloatArray) -> dict[str, FloatArray]:
    """Coordinates in which modes are looked for, (draws,) each of points (draws, 9)."""
    straight = ridge(likelihood, points)
    found = {name: points[:, index] for index, name in enumerate(NAMES)}
    found["logit of the initial slip"] = points[:, COUNT]
    kept = [(name, straight[:, at]) for at, name in enumerate(RIDGE) if name not in found]
    return found | dict(kept)


def separators(
    named: dict[str, FloatArray], weights: FloatArray, known: tuple[str, float] | None = None
) -> list[Separator]:
    """The deepest valleys, those left out that part the draws as a deeper one does.

    Parameters
    ----------
    named : coordinates by name, (draws,) each
    weights : (draws,) of sum one
    known : coordinate and value of a cut that comes before all valleys
    """
    found = [(name, _valley(values, weights)) for name, values in named.items()]
    deep = sorted((v[1], v[0], name) for name, v in found if v and v[1] < DEEP)
    kept = [] if known is None else [Separator(*known, None)]
    for depth, cut, name in deep:
        one = Separator(name, cut, depth)
        above = named[name] > cut
        if all(_differ(above, named[k.coordinate] > k.cut, weights) for k in kept):
            kept.append(one)
    return kept


def _differ(above: NDArray[np.bool_], other: NDArray[np.bool_], weights: FloatArray) -> bool:
    unlike = float(weights @ (above != other))
    small = min(float(weights @ above), float(weights @ ~above))
    return min(unlike, 1 - unlike) > 0.5 * small


def _valley(values: FloatArray, weights: FloatArray) -> tuple[float, float] | None:
    """Place and depth of the deepest valley with `MODE` to either side, if there is one."""
    order = np.argsort(values)
    cumulated = np.cumsum(weights[order])
    low, high = values[order][np.searchsorted(cumulated, [5e-4, 1 - 5e-4]).clip(max=len(order) - 1)]
    if not high > low:
        return None
    heights, edges = np.histogram(values, _BINS, (low, high), weights=weights)
    smooth = gaussian_filter1d(heights, _SMOOTH)
    left = np.maximum.accumulate(smooth)
    right = np.maximum.accumulate(smooth[::-1])[::-1]
    depth = smooth / np.minimum(left, right)
    below = np.cumsum(heights)
    depth[(below < MODE) | (below > 1 - MODE)] = np.inf
    at = int(np.argmin(depth))
    return (float(edges[at] + edges[at + 1]) / 2, float(depth[at])) if depth[at] < 1 else None


class Compared:
    """The reference's side of the comparison, worked out once.

    Parameters
    ----------
    reference : its populations
    likelihood, operation : of the loop
    known : a cut between modes that the case names
    """

    def __init__(
        self,
        reference: Reference,
        likelihood: LoopLikelihood,
        operation: Operation,
        known: tuple[str, float] | None = None,
    ) -> None:
        self.reference, self.likelihood, self.operation = reference, likelihood, operation
        populations, draws, size = reference.points.shape
        self.pooled = reference.points.reshape(-1, size)
        self.weights = np.repeat(reference.weights / draws, draws)
        self.named = coordinates(likelihood, self.pooled)
        self.separators = separators(self.named, self.weights, known)
        # The last moment of each population: its particles are the farthest from their origin.
        last = reference.points[:, -_FIGURE_DRAWS:]
        quantities = self.quantities(last.reshape(-1, size))
        by = {name: values.reshape(populations, -1) for name, values in quantities.items()}
        by |= {name: reference.points[:, :, at] for at, name in enumerate(NAMES)}
        self.moments = {name: _moments(reference, values) for name, values in by.items()}
        rng = np.random.default_rng(_SEED)
        scaled = self._scaled(self.pooled)
        chosen = rng.choice(len(scaled), 6000, p=self.weights)
        self.centres, _ = kmeans2(scaled[chosen], CELLS, minit="++", rng=rng)
        self.cells, self.cells_error = self._by_population(self._cell_shares)

    def quantities(self, points: FloatArray) -> dict[str, FloatArray]:
        """All that is compared by mean and spread, (draws,) each of points (draws, 9)."""
        physical = self.likelihood.prior.to_physical(points[:, :COUNT])
        merit = figures(standard_requests(self.operation), physical, self.operation)
        return {name: points[:, at] for at, name in enumerate(NAMES)} | merit

    def modes(self, points: FloatArray, weights: FloatArray | None = None) -> FloatArray:
        """Mass above each separator's cut, (separators,), of points (draws, 9)."""
        named = coordinates(self.likelihood, points)
        equal = np.full(len(points), 1 / len(points)) if weights is None else weights
        return np.array([equal @ (named[s.coordinate] > s.cut) for s in self.separators])

    @property
    def mode_masses(self) -> tuple[FloatArray, FloatArray]:
        """The reference's mass above each cut with its error, (separators,) each."""
        return self._by_population(self.modes)

    def cell_shares(self, points: FloatArray) -> FloatArray:
        """Share of points (draws, 9) in each of the cells that the reference is divided into."""
        return self._cell_shares(points)

    def _cell_shares(self, points: FloatArray) -> FloatArray:
        nearest, _ = vq(self._scaled(points), self.centres)
        return np.bincount(nearest, minlength=CELLS) / len(points)

    def _scaled(self, points: FloatArray) -> FloatArray:
        straight = np.column_stack([ridge(self.likelihood, points), points[:, COUNT:]])
        own = np.column_stack([ridge(self.likelihood, self.pooled), self.pooled[:, COUNT:]])
        return np.asarray((straight - own.mean(axis=0)) / own.std(axis=0))

    def _by_population(
        self, shares: Callable[[FloatArray], FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        each = np.array([shares(points) for points in self.reference.points])
        return self.reference.estimate(lambda weights: weights @ each)


def _moments(reference: Reference, values: FloatArray) -> dict[str, float]:
    """Mean and standard deviation of values (populations, draws), with their errors."""
    shift = values.mean()
    first, second = (values - shift).mean(axis=1), ((values - shift) ** 2).mean(axis=1)

    def both(weights: FloatArray) -> FloatArray:
        mean = weights @ first
        return np.array([shift + mean, np.sqrt(weights @ second - mean**2)])

    (mean, sd), (mean_error, sd_error) = reference.estimate(both)
    return {"mean": mean, "sd": sd, "mean_error": mean_error, "sd_error": sd_error}


def deviations(compared: Compared, chains: FloatArray) -> dict[str, dict[str, float]]:
    """By quantity: how far chains are from the reference, in the limits' units.

    Parameters
    ----------
    chains : (ensembles, steps, walkers, 9) of points

    Returns
    -------
    by quantity: mean (difference in the reference's standard deviations), mean_error, sd (ratio),
    sd_error, and excess (the larger of what is beyond the limits and the errors, in limits; at
    most 0 where nothing is)
    """
    stats = arviz()
    folded = chains.transpose(0, 2, 1, 3)
    ensembles = folded.shape[0]
    thin = max(1, folded[0, ..., 0].size * ensembles // 24_000)
    kept = folded.reshape(ensembles, -1, folded.shape[-1])
    quantities = compared.quantities(kept[:, ::thin].reshape(-1, folded.shape[-1]))
    by = {name: values.reshape(ensembles, -1) for name, values in quantities.items()}
    by |= {name: kept[:, :, at] for at, name in enumerate(NAMES)}
    found = {}
    for name, values in by.items():
        known = compared.moments[name]
        squares = (values - values.mean()) ** 2
        sd = float(np.sqrt(squares.mean()))
        error = sd / np.sqrt(float(stats.ess(values, method="mean")))
        sd_error = squares.std() / (2 * sd) / np.sqrt(float(stats.ess(squares, method="mean")))
        one = {
            "mean": float(values.mean() - known["mean"]) / known["sd"],
            "mean_error": float(np.hypot(error, known["mean_error"])) / known["sd"],
            "sd": sd / known["sd"],
            "sd_error": float(np.hypot(sd_error, known["sd_error"])) / known["sd"],
        }
        beyond_mean = (abs(one["mean"]) - SURE * one["mean_error"] - MEAN_LIMIT) / MEAN_LIMIT
        beyond_sd = (abs(one["sd"] - 1) - SURE * one["sd_error"] - SD_LIMIT) / SD_LIMIT
        found[name] = one | {"excess": max(beyond_mean, beyond_sd, 0.0)}
    return found


def missed(compared: Compared, points: FloatArray) -> dict[str, Any]:
    """What part of the reference gets no draw, or too few.

    Returns
    -------
    cells : how many cells of the reference hold `MODE` of its mass or more
    empty : how many of these get no draw; mass : of these together
    least : least ratio of the draws' share to the reference's among them
    """
    large = compared.cells >= MODE
    ratio = compared.cell_shares(points)[large] / compared.cells[large]
    mass = float(compared.cells[large][ratio == 0].sum())
    return {
        "cells": int(large.sum()),
        "empty": int((ratio == 0).sum()),
        "mass": mass,
        "least": float(ratio.min()),
        "largest": float(ratio.max()),
    }
