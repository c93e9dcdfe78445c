"""Root of a covariance that rounding may have made indefinite."""

from __future__ import annotations

import numpy as np

from hdprog.physics.parameters import FloatArray


def root_of(covariance: FloatArray) -> FloatArray:
    """L (k, k) with L Lᵀ = the covariance (k, k), lower triangular where it is positive definite.

    Where a record has next to no noise, some directions are known so much better than others that
    the inverse of the curvature loses their sign: they get the least spread that can be told.
    """
    try:
        return np.asarray(np.linalg.cholesky(covariance))
    except np.linalg.LinAlgError:
        values, axes = np.linalg.eigh(0.5 * (covariance + covariance.T))
        least = np.finfo(float).eps * max(float(values[-1]), np.finfo(float).tiny)
        return np.asarray(axes * np.sqrt(np.maximum(values, least)))
