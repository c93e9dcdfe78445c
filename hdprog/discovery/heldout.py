"""Error on what a fit did not see: whole cycles left out in turn, or contiguous blocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hdprog.discovery.model import Model
from hdprog.discovery.residuals import contiguous_folds
from hdprog.inference.likelihood import COUNT
from hdprog.inference.prepare import Prepared
from hdprog.inference.starting_points import StartingPoint, descend
from hdprog.physics.parameters import FloatArray

_WHOLE = 0.6  # of the largest swing: a rising branch that begins a cycle
_FEWEST_CYCLES = 3
_ITERATIONS = 10
_NEVER = -1  # fold of readings that are not left out
_EITHER_END = 8.0  # of the way between the envelopes, as a logit
_MOVED = 1e-6  # of what the slip before the first reading moves at most
_MOST_MOVED = 0.5  # of the readings
_GROUPS = 30  # of blocks, whose joint density counts: neighbours' errors go together

Refit = Callable[[Any, FloatArray, int], StartingPoint | None]


@dataclass(frozen=True)
class HeldOut:
    """What a model says of the parts it did not see.

    Attributes
    ----------
    residual : (samples,) measured angle minus prediction in rad; NaN where set aside
    log_density : (groups,) log predictive density of groups of neighbouring blocks
    """

    residual: FloatArray
    log_density: FloatArray

    @property
    def rmse(self) -> float:
        """Root mean square of the residual in rad."""
        return float(np.sqrt(np.nanmean(self.residual**2)))


def sample_folds(prepared: Prepared) -> NDArray[np.intp]:
    """(samples,) fold of each reading: its cycle where there are three or more, else a tenth."""
    path = prepared.record_course.path
    spans = prepared.record_course.spans
    whole = spans >= _WHOLE * spans.max()
    # From zero torque a cycle's first rise is half a swing: then its falls tell the cycles.
    begins = max((path.starts[whole & (path.rising == up)] for up in (True, False)), key=len)
    if begins.size < _FEWEST_CYCLES:
        return contiguous_folds(len(prepared.loop))
    places = np.searchsorted(begins, np.arange(len(prepared.loop)), side="right") - 1
    return np.asarray(np.maximum(places, 0))


def _hangs_on_start(prepared: Prepared) -> NDArray[np.bool_]:
    """(samples,) whether the drive's slip before the first reading moves a reading.

    No reading does where it moves most of them, of a record that stays inside the play.
    """
    ends = np.tile(prepared.starts[0].point, (2, 1))
    ends[:, COUNT] = -_EITHER_END, _EITHER_END
    low, high = prepared.likelihood.at_course(prepared.record_course).angle(ends)
    apart = np.abs(high - low)
    moved = apart > _MOVED * apart.max()
    return np.asarray(moved & (moved.mean() < _MOST_MOVED))


def held_out(prepared: Prepared, model: Model, refit: Refit = descend) -> HeldOut:
    """Refit a model with each part left out in turn and predict that part.

    Readings that hang on the slip before the first one are never left out: no others tell it.

    The torque of the part stays: the history of the slip needs it.

    Parameters
    ----------
    prepared : the record
    model : at its best point
    refit : finds the best point of a likelihood near another in so many iterations
    """
    loop = prepared.loop
    # What is left out is predicted with the noise of the blocks themselves.
    likelihood = replace(model.likelihood, effective=None, within=None)
    reduced = likelihood.reduced
    middle = np.clip(np.round(reduced.position).astype(int), 0, len(loop) - 1)
    folds = np.where(_hangs_on_start(prepared), _NEVER, sample_folds(prepared))
    block_fold = folds[middle]
    whole = likelihood.at_course(prepared.record_course)
    features = None if model.term is None else model.term.features(prepared.record_course)
    residual = np.full(len(loop), np.nan)
    groups = contiguous_folds(likelihood.blocks, min(_GROUPS, likelihood.blocks))
    log_density = np.zeros(int(groups.max()) + 1)
    for fold in np.unique(folds[folds != _NEVER]):
        out = block_fold == fold
        if not out.any() or out.all():
            continue
        masked = replace(likelihood, noise=likelihood.noise.masking(out))
        start = refit(masked, model.start.point, _ITERATIONS) or model.start
        left = reduced.angle - masked.angle(start.point[None, :])[0]
        offset = masked.offset(left)
        left = left - offset
        predicted = whole.angle(start.point[None, :])[0] + offset
        if features is not None:
            coefficients = masked.noise.coefficients(left)
            predicted = predicted + features @ coefficients
            left = left - masked.noise.block_features @ coefficients
        seen = (folds == fold) & prepared.kept
        residual[seen] = (loop.angle - predicted)[seen]
        predictive = _predictive_covariance(model, likelihood.blocks - int(out.sum()), start)
        for group in np.unique(groups[out]):
            here = out & (groups == group)
            log_density[group] += _log_density(left[here], predictive(here))
    return HeldOut(residual, log_density)


def _predictive_covariance(
    model: Model, seen: int, start: StartingPoint
) -> Callable[[NDArray[np.bool_]], FloatArray]:
    """Covariance of some blocks' angles, the parameters' own included, in rad²."""
    likelihood = model.likelihood
    seen_share = max(seen, 1) / likelihood.blocks  # what is masked adds nothing to the scale
    scale = start.variance / seen_share
    own = likelihood.noise.covariance
    if likelihood.noise.features is not None:
        # The empirical term is predicted; what is left of it is small beside the rest.
        own = own - likelihood.noise.features @ likelihood.noise.features.T
    white = replace(likelihood, noise=likelihood.noise.as_white)
    derivative = white.jacobian(start.point)[1] * likelihood.noise.white_sd[:, None]

    def covariance(here: NDArray[np.bool_]) -> FloatArray:
        spread = derivative[here] @ start.covariance @ derivative[here].T / seen_share
        return np.asarray(scale * own[np.ix_(here, here)] + spread)

    return covariance


def _log_density(left: FloatArray, covariance: FloatArray) -> float:
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, left)
    return float(-0.5 * white @ white - np.log(np.diag(factor)).sum())


def elpd_difference(after: HeldOut, before: HeldOut) -> tuple[float, float]:
    """Gain of expected log predictive density and its standard error.

    The error comes from the scatter of the gain over the groups of neighbouring blocks.
    """
    gain = after.log_density - before.log_density
    return float(gain.sum()), float(np.sqrt(gain.size * np.var(gain, ddof=1)))
