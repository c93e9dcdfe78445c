"""How good forecasts were: each score once, with its source.

Of a first crossing: times are hours; a distribution function is given on a grid that starts now
and ends at the horizon, behind which nothing is claimed. A crossing after that is infinite or any
later hour. Of a figure at a test: draws of it, and what was measured.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import FloatArray

_CONFIDENCE = 0.95


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


def log_score(
    hours: FloatArray, probability: FloatArray, crossed_at: float, least: float = 0.0
) -> float:
    """Negative log density of the crossing, per hour; smaller is better.

    Good, JRSS B 14, 1952; strictly proper. The density is the slope of the piecewise linear F. A
    crossing at now or behind the horizon is scored by the lump of probability there, as a censored
    one is by its chance of coming later (Rindt et al., Proc. AISTATS 2022). Infinite for a
    crossing that was held for impossible, unless a least probability is given.

    Parameters
    ----------
    hours, probability : (times,) grid and distribution function
    crossed_at : true hour of the crossing
    least : probability below which nothing is told apart, such as one over the number of paths:
        of the lumps, and of crossing between now and the horizon, spread evenly
    """
    if crossed_at <= hours[0]:
        chance = max(float(probability[0]), least)
    elif crossed_at >= hours[-1]:
        chance = max(1.0 - float(probability[-1]), least)
    else:
        step = int(np.searchsorted(hours, crossed_at, side="left")) - 1
        slope = (probability[step + 1] - probability[step]) / (hours[step + 1] - hours[step])
        chance = max(float(slope), least / float(hours[-1] - hours[0]))
    return float(-np.log(chance)) if chance > 0 else float("inf")


def sample_crps(draws: FloatArray, measured: float) -> float:
    """Continuous ranked probability score of draws (draws,), in their unit; smaller is better.

    E|X − y| − ½E|X − X′| (Gneiting & Raftery, J. Am. Stat. Assoc. 102, 2007, eq. 21), exact for
    the draws' own distribution function. For a single draw it is the absolute error.
    """
    values = np.sort(draws)
    count = values.size
    rank = 2.0 * np.arange(1, count + 1) - count - 1.0
    return float(np.mean(np.abs(values - measured)) - np.sum(rank * values) / count**2)


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


def interval_probability(probability: FloatArray, low: float, high: float) -> float:
    """Probability that a forecast itself gives the interval that `covers` looks at.

    It is high − low where F rises without lumps from 0 to 1. An end in a lump, at now or behind
    the horizon, takes the whole lump in, so that more than high − low is right.

    Parameters
    ----------
    probability : (times,) distribution function from now to the horizon
    low, high : levels of the interval's ends
    """
    first, last = float(probability[0]), float(probability[-1])
    below = 0.0 if first >= low else min(low, last)
    return (1.0 if last < high else max(high, first)) - below


def coverage_range(held: int, forecasts: int) -> tuple[float, float]:
    """Shares of intervals that hold the truth which a count does not rule out, at 95 %.

    Clopper & Pearson, Biometrika 26, 1934: exact for independent forecasts, never too narrow.
    """
    from scipy.stats import beta

    tail = (1.0 - _CONFIDENCE) / 2.0
    low = float(beta.ppf(tail, held, forecasts - held + 1)) if held > 0 else 0.0
    high = float(beta.isf(tail, held + 1, forecasts - held)) if held < forecasts else 1.0
    return low, high


@dataclass(frozen=True)
class TransformHistogram:
    """Counts (bins,) of transforms between 0 and 1, and the band of calibrated ones.

    Attributes
    ----------
    counts : transforms in each bin of equal width
    low, high : counts between which all bins of calibrated independent forecasts lie together
    """

    counts: NDArray[np.intp]
    low: int
    high: int

    @property
    def inside(self) -> bool:
        """Whether every bin is in the band."""
        return bool(np.all((self.counts >= self.low) & (self.counts <= self.high)))


def transform_histogram(transforms: Sequence[float], bins: int) -> TransformHistogram:
    """Histogram of probability integral transforms with a simultaneous band.

    Each bin's count is binomial for calibrated independent forecasts; by Bonferroni's inequality
    all bins lie in the band together with a probability of at least 95 % (Dawid, JRSS A 147, 1984;
    Gneiting, Balabdaoui & Raftery, JRSS B 69, 2007, on reading its shape).
    """
    from scipy.stats import binom

    counts = np.histogram(np.asarray(transforms), bins, (0.0, 1.0))[0]
    tail = (1.0 - _CONFIDENCE) / (2.0 * bins)
    low = int(binom.ppf(tail, len(transforms), 1.0 / bins))
    high = int(binom.isf(tail, len(transforms), 1.0 / bins))
    return TransformHistogram(counts, max(low, 0), high)


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


def cumulative_relative_accuracy(accuracies: Sequence[float]) -> float:
    """Mean of the relative accuracies of one crossing's forecasts, from the first origin on.

    Saxena et al., 2010, with equal weights; NaN without any.
    """
    return float(np.mean(accuracies)) if accuracies else float("nan")


def prognostic_horizon(
    origins: Sequence[float], meets: Sequence[bool], crossed_at: float
) -> float | None:
    """Hours from the first forecast that meets a criterion to the crossing; None if none does.

    Saxena et al., 2010. A forecast made at or after the crossing does not count.

    Parameters
    ----------
    origins : service hours at which forecasts were made, rising
    meets : whether each meets the criterion, such as `alpha_lambda` of more than a half
    crossed_at : true hour of the crossing
    """
    met = [hour for hour, good in zip(origins, meets, strict=True) if good and hour < crossed_at]
    return crossed_at - met[0] if met else None
