"""How good forecasts of a first crossing were: each score once, with its source.

Times are hours; a distribution function is given on a grid that starts now and ends at the
horizon, behind which nothing is claimed. A crossing after that is infinite or any later hour.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hdprog.physics.parameters import FloatArray


def crps(hours: FloatArray, probability: FloatArray, crossed_at: float) -> float:
    """Continuous ranked probability score up to the horizon, in hours; smaller is better.

    ∫ (F(t) − 1[T ≤ t])² dt from now to the horizon, exact for a piecewise linear F: the
    threshold-weighted score of Gneiting & Ranjan (J. Bus. Econ. Stat. 29, 2011) with weight one
    before the horizon, proper for a crossing that is only seen up to there. For a forecast of one
    hour it is the absolute error.

    Parameters
    ----------
    hours, probability : (times,) grid and distribution function
    crossed_at : true hour of the crossing
    """
    at = float(np.clip(crossed_at, hours[0], hours[-1]))
    place = int(np.searchsorted(hours, at, side="right"))
    grid = np.insert(hours, place, at)
    values = np.insert(probability, place, np.interp(at, hours, probability))
    target = np.where(np.arange(grid.size - 1) >= place, 1.0, 0.0)
    left, right = values[:-1] - target, values[1:] - target
    return float(np.sum(np.diff(grid) * (left**2 + left * right + right**2) / 3.0))


def probability_integral_transform(
    hours: FloatArray, probability: FloatArray, crossed_at: float, deviate: float = 0.5
) -> float:
    """F(T); uniform over many forecasts if they are calibrated (Dawid, JRSS A 147, 1984).

    Where the distribution has a lump (at now, or all that lies past the horizon), a uniform
    deviate places T inside it (Czado, Gneiting & Held, Biometrics 65, 2009).
    """
    if crossed_at <= hours[0]:
        return deviate * float(probability[0])
    if crossed_at >= hours[-1]:
        last = float(probability[-1])
        return last + deviate * (1.0 - last)
    return float(np.interp(crossed_at, hours, probability))


def covers(
    remaining: Mapping[float, float | None], low: float, high: float, remaining_true: float
) -> bool:
    """Whether the interval between two quantiles of remaining hours holds the truth.

    A quantile of None lies past the horizon: above every hour that can be told.
    """
    lower, upper = remaining[low], remaining[high]
    lower = np.inf if lower is None else lower
    upper = np.inf if upper is None else upper
    return bool(lower <= remaining_true <= upper)


def kupiec_p_value(held: int, forecasts: int, nominal: float) -> float:
    """P-value of a coverage: likelihood ratio of the counted share against the nominal one.

    Kupiec, Journal of Derivatives 3, 1995: −2 log of the ratio is χ² with one degree of freedom.
    """
    from scipy.special import xlogy
    from scipy.stats import chi2

    missed, share = forecasts - held, held / forecasts
    counted = xlogy(held, share) + xlogy(missed, 1 - share)
    expected = xlogy(held, nominal) + xlogy(missed, 1 - nominal)
    return float(chi2.sf(2 * (counted - expected), df=1))


def alpha_lambda(
    hours: FloatArray, probability: FloatArray, crossed_at: float, alpha: float = 0.2
) -> float:
    """Probability that the forecast puts within ± alpha of the true remaining life.

    Saxena et al., International Journal of Prognostics and Health Management 1, 2010; above 0.5
    the forecast is said to pass.
    """
    remaining = crossed_at - hours[0]
    edges = hours[0] + remaining * np.array([1.0 - alpha, 1.0 + alpha])
    low, high = np.interp(edges, hours, probability)
    return float(high - low)


def relative_accuracy(remaining_estimate: float, remaining_true: float) -> float:
    """1 − |error| / true remaining life (Saxena et al., 2010); 1 is exact."""
    return 1.0 - abs(remaining_estimate - remaining_true) / remaining_true
