"""How many independent blocks a residual is worth whose correlation the noise model leaves behind.

With scores g_k = r_k ∂r_k/∂x of the whitened blocks and H = Σ (∂r_k)(∂r_k)ᵀ/s², noise that is as
its model says makes the variance of Σ g_k equal to H. Where neighbours' scores hang together, or
large errors sit where the sensitivities are large, it is J, estimated over some lags (Newey & West,
Econometrica 55 (1987) 703). The mean of J over H along what the data fix is the factor by which
misspecified noise makes variances too small; the likelihood is raised to its inverse (Pauli,
Racugno & Ventura, Statistica Sinica 21 (2011) 149; Ribatet, Cooley & Davison, ibid. 22 (2012) 813),
which makes it that of as many fewer blocks. Scores sum to nothing at a mode, so J comes out low: of
a planted factor of 3.7 half is found (tested), of a factor of one nothing is made.

The correction is a scale, estimated once at the best mode. It mends intervals, not a model whose
error repeats: that stays a bias.
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.noise_shape import FALSE_ALARM_RATE
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray

_TESTED_LAGS = 5
_LAGS = 15  # of some 300 blocks; a noise term with a longer memory has been whitened away
_FIXED = 4.0  # times the prior's information: what the data fix to half the prior's spread


def effective_degrees(likelihood: LoopLikelihood, start: StartingPoint) -> float:
    """Degrees of freedom that the blocks are worth: blocks − 1 where whitening has worked.

    Parameters
    ----------
    likelihood : with its noise
    start : its best mode

    Returns
    -------
    at most blocks − 1; that where the whitened residual passes a test of whiteness at
    `FALSE_ALARM_RATE`
    """
    whole = float(likelihood.blocks - 1)
    residual, derivative = likelihood.jacobian(start.point)
    residual = residual / np.sqrt(float(residual @ residual) / whole)
    if likelihood.noise.whitening is None or _is_white(residual):
        return whole
    fixed = fixed_directions(derivative / np.sqrt(start.variance), likelihood.prior_sd)
    if not fixed.size:
        return whole
    excess = float(np.trace(_long_run(residual[:, None] * fixed))) / fixed.shape[1]
    return float(whole / max(1.0, excess))


def fixed_directions(derivative: FloatArray, prior_sd: FloatArray) -> FloatArray:
    """Orthonormal directions (blocks, k) of the whitened angles along which the data fix a fit.

    Parameters
    ----------
    derivative : (blocks, size) of the angles by a point's coordinates, in units of the noise
    prior_sd : (size,) of the coordinates
    """
    scaled = np.nan_to_num(derivative * prior_sd)
    values, axes = np.linalg.eigh(scaled.T @ scaled)
    fixed = values > _FIXED
    return np.asarray(scaled @ axes[:, fixed] / np.sqrt(values[fixed]))


def _is_white(residual: FloatArray) -> bool:
    """Ljung and Box's test of the first lags (Biometrika 65 (1978) 297)."""
    count = residual.size
    lags = range(1, min(_TESTED_LAGS, count // 4) + 1)
    total = float(residual @ residual)
    found = [float(residual[lag:] @ residual[:-lag]) / total for lag in lags]
    score = sum(r**2 / (count - lag) for r, lag in zip(found, lags, strict=True))
    return bool(count * (count + 2) * score < chdtri(len(found), FALSE_ALARM_RATE))


def _long_run(scores: FloatArray) -> FloatArray:
    """(k, k) variance of the sum of scores (blocks, k), lags weighed down to zero."""
    found = scores.T @ scores
    lags = min(_LAGS, len(scores) // 10)
    for lag in range(1, lags + 1):
        product = scores[lag:].T @ scores[:-lag]
        found = found + (1 - lag / (lags + 1)) * (product + product.T)
    return np.asarray(found)
