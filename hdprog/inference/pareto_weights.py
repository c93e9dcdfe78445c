"""Importance weights, Pareto-smoothed (Vehtari et al., J. Mach. Learn. Res. 25 (2024) 72)."""

from __future__ import annotations

import numpy as np

from hdprog.inference.lazy_arviz import arviz
from hdprog.physics.parameters import FloatArray

_OUT_OF_REACH = 700.0  # below the lowest log weight that is one: nothing is left of it


def pareto_weights(log_weight: FloatArray) -> tuple[FloatArray, float]:
    """Smoothed weights (draws,) that sum to one, and Pareto k, of log weights (draws,).

    Those that are not finite count for nothing.
    """
    finite = np.isfinite(log_weight)
    lowest = np.min(log_weight[finite], initial=0.0) - _OUT_OF_REACH
    found, k = arviz().psislw(np.where(finite, log_weight, lowest))
    weight = np.exp(found - np.max(found))
    return weight / weight.sum(), float(k)


def worth(weight: FloatArray) -> float:
    """Effective draws of weights (draws,) that sum to one."""
    return float(1.0 / np.sum(weight**2))
