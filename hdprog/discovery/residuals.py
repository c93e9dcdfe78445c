"""Which coordinate carries a residual, by cross-validation, and how well a record repeats."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hdprog.explanation import Carrier
from hdprog.inference.smooth_term import FEATURES, basis_of, spectrum
from hdprog.physics.coordinates import coordinates
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray

_FOLDS = 10
_SURROGATES = 999
_PIECES, _FEWEST_PIECES = 30, 8  # of a record, each longer than the residual's memory
_LENGTH = 0.08  # of the smoother, in parts of a coordinate's range
_FEWEST = 12  # samples of a branch from which a repeated course can be read
_WHOLE = 0.8  # of the largest swing: a branch that counts as a whole one


def contiguous_folds(size: int, folds: int = _FOLDS) -> NDArray[np.intp]:
    """(size,) number of the contiguous block that each place belongs to."""
    return np.minimum(np.arange(size) * folds // size, folds - 1)


def carriers(
    residual: FloatArray,
    sensitivities: FloatArray,
    angle: FloatArray,
    course: Course,
    rng: np.random.Generator,
) -> tuple[Carrier, ...]:
    """How much of a residual a smooth function of each coordinate carries.

    The share is cross-validated over ten contiguous blocks. Its p-value comes from surrogates:
    pieces of the residual in a random order and with random signs, long enough to keep its serial
    correlation, with the fitted sensitivities taken out again; Holm's correction over the
    coordinates. A coordinate that predicts nothing has p = 1.

    Parameters
    ----------
    residual : (blocks,) in units of the noise
    sensitivities : (blocks, k) of the fit that left it, in the same units
    angle : (blocks,) model's angle in rad
    course : of the blocks
    rng : for the surrogates

    Returns
    -------
    largest share first
    """
    basis = np.linalg.qr(sensitivities)[0]
    folds = contiguous_folds(residual.size)
    tried = np.vstack([residual, _surrogates(residual, basis, rng)])
    found: list[tuple[str, float, float]] = []
    for name, features in _features(course, angle).items():
        shares = _shares(features, folds, tried)
        fraction, drawn = float(shares[0]), shares[1:]
        beaten = int(np.count_nonzero(drawn >= fraction))
        p_value = (1 + beaten) / (1 + drawn.size) if fraction > 0 else 1.0
        found.append((name, max(fraction, 0.0), p_value))
    found.sort(key=_p_value)
    p_values = [p_value * (len(found) - rank) for rank, (_, _, p_value) in enumerate(found)]
    corrected = [
        Carrier(name, fraction, float(min(1.0, max(p_values[: rank + 1]))))
        for rank, (name, fraction, _) in enumerate(found)
    ]
    return tuple(sorted(corrected, key=lambda carrier: -carrier.fraction))


def _p_value(entry: tuple[str, float, float]) -> float:
    return entry[2]


def _features(course: Course, angle: FloatArray) -> Mapping[str, FloatArray]:
    scaled = spectrum(_LENGTH)
    features = {}
    for name, values in coordinates(course).items():
        basis = basis_of(name, float(values.min()), float(values.max()), course)
        features[name] = basis * np.tile(scaled, basis.shape[1] // FEATURES)
        if name == "temperature":
            # A rig that warms up is coldest once: what was left out can only be read on a line.
            line = (values - values.mean()) / values.std()
            features[name] = np.column_stack([features[name], line])
    low, high = float(angle.min()), float(angle.max())
    place = np.outer((angle - low) / (high - low), np.arange(1, FEATURES + 1))
    features["angle"] = np.sqrt(2) * np.cos(np.pi * place) * scaled
    return features


def _shares(features: FloatArray, folds: NDArray[np.intp], residuals: FloatArray) -> FloatArray:
    """(draws,) share of residuals (draws, n) that is predicted from outside each block's fold.

    Features' weights have a unit prior, and noise has a unit variance. What a prediction from all
    blocks leaves of a fold, over the part of that fold which it does not take from the fold itself,
    is what one from the other folds leaves.
    """
    gain = np.linalg.solve(np.eye(features.shape[1]) + features.T @ features, features.T)
    left = residuals - (residuals @ features) @ gain
    for fold in range(int(folds.max()) + 1):
        out = folds == fold
        others = np.eye(int(out.sum())) - features[out] @ gain[:, out]
        left[:, out] = np.linalg.solve(others, left[:, out].T).T
    return np.asarray(1 - np.sum(left**2, axis=1) / np.sum(residuals**2, axis=1))


def _surrogates(residual: FloatArray, basis: FloatArray, rng: np.random.Generator) -> FloatArray:
    """(draws, n) the residual's short pieces in another order and with random signs."""
    lags = np.arange(1, max(2, residual.size // 8))
    memory = [float(residual[lag:] @ residual[:-lag] / (residual @ residual)) for lag in lags]
    # Summed up to where the correlation first goes below zero.
    length = 1 + 2 * float(np.sum(memory[: int(np.argmax(np.array([*memory, -1.0]) < 0))]))
    count = int(np.clip(residual.size / (3 * length), _FEWEST_PIECES, _PIECES))
    pieces = contiguous_folds(residual.size, count)
    places = [np.flatnonzero(pieces == piece) for piece in range(int(pieces.max()) + 1)]
    rows = np.empty((_SURROGATES, residual.size))
    for row in rows:
        order = rng.permutation(len(places))
        signs = rng.choice((-1.0, 1.0), len(places))
        row[:] = np.concatenate([signs[piece] * residual[places[piece]] for piece in order])
    return np.asarray(rows - (rows @ basis) @ basis.T)


def repeatability(course: Course, angle: FloatArray, noise: float) -> float | None:
    """How far readings of whole branches of one direction lie from the branches' mean.

    The first branch of a record is left out: from rest a drive takes another way.

    That is what a fit of the mean branch would leave. Branches are compared by means of readings,
    which have less noise than the readings have; the rest is added.

    Parameters
    ----------
    course : of the whole record
    angle : (samples,) in rad
    noise : of a reading, in rad

    Returns
    -------
    root mean square in rad, or None where no whole branch repeats
    """
    path = course.path
    spans = course.spans
    stretches = list(zip(path.starts, path.ends, spans, path.rising, strict=True))
    squares, degrees = 0.0, 0
    for rising in (True, False):
        branches = [
            slice(int(start), int(end))
            for start, end, span, up in stretches[1:]
            if up == rising and span >= _WHOLE * spans.max() and end - start >= _FEWEST
        ]
        if len(branches) < 2:
            continue
        low = max(float(path.torque[branch].min()) for branch in branches)
        high = min(float(path.torque[branch].max()) for branch in branches)
        grid = np.linspace(low, high, 60)
        found = [_smoothed(path.torque[one], angle[one], grid) for one in branches]
        curves, averaged_out = (
            np.array([curve for curve, _ in found]),
            [share for _, share in found],
        )
        freedom = (len(branches) - 1) * grid.size
        squares += float(np.sum((curves - curves.mean(axis=0)) ** 2))
        squares += freedom * noise**2 * float(np.mean(averaged_out))
        degrees += freedom
    return float(np.sqrt(squares / degrees)) if degrees else None


def _smoothed(torque: FloatArray, angle: FloatArray, grid: FloatArray) -> tuple[FloatArray, float]:
    """Angle over a grid of torque, and the share of the noise's variance that it is free of.

    Means of the readings near each point; interpolated where these are too few.
    """
    order = np.argsort(torque, kind="stable")
    torque, angle = torque[order], angle[order]
    edges = np.concatenate([[-np.inf], 0.5 * (grid[1:] + grid[:-1]), [np.inf]])
    cells = np.searchsorted(edges, torque, side="right") - 1
    count = np.bincount(cells, minlength=grid.size)
    if count.min() < 3:
        # A straight line between two readings keeps two thirds of their variance.
        return np.asarray(np.interp(grid, torque, angle)), 1.0 / 3.0
    at = np.bincount(cells, weights=torque, minlength=grid.size) / count
    mean = np.bincount(cells, weights=angle, minlength=grid.size) / count
    return np.asarray(np.interp(grid, at, mean)), 1.0 - float(np.mean(1.0 / count))
