"""Numbers rounded by their uncertainty, with thin spaces between thousands."""

from __future__ import annotations

import math
from itertools import pairwise

THIN_SPACE = "\u202f"
"""Narrow no-break space: groups thousands and stands before a unit."""
MINUS = "\u2212"
"""The sign of negative numbers on pages and in pictures."""
_SLACK = 1e-9  # a number that lies on a step up to floating point is on it
_LEAST_OF_FAR_END = 0.01
_LEAST_APART = 0.1  # of two numbers: from there on they are not said to be one
_MOST_DIGITS = 7  # significant ones: more are never of use, however small the uncertainty
_LEAST_WRITTEN_OUT = 0.01  # a number from here on has at most six decimals and no power of ten


def digit_step(uncertainty: float) -> float:
    """Power of ten to which a number is rounded: at most half of its uncertainty.

    Rounding then moves the number by a quarter of the uncertainty at most.
    """
    return float(10.0 ** math.floor(math.log10(uncertainty / 2.0) + _SLACK))


def round_step(uncertainty: float) -> float:
    """Largest of 1, 2 and 5 × 10^k at most a fifth of the uncertainty, for hours."""
    wanted = uncertainty / 5.0
    power = 10.0 ** math.floor(math.log10(wanted) + _SLACK)
    factor = max(f for f in (1.0, 2.0, 5.0) if f * power <= wanted * (1.0 + _SLACK))
    return float(factor * power)


def grouped(value: float, decimals: int) -> str:
    """Write a number with a fixed count of decimals, thousands grouped, and a true minus sign."""
    text = f"{value:,.{max(decimals, 0)}f}".replace(",", THIN_SPACE)
    if not text.strip("-0." + THIN_SPACE):
        return text.lstrip("-")  # no minus before a zero
    return text.replace("-", MINUS)


def plain(value: float) -> str:
    """Write a number as it was given (a limit, a setting), thousands grouped."""
    text = f"{value:.10g}"
    if "e" in text:
        return scientific(value, 3)
    decimals = len(text.partition(".")[2])
    return grouped(value, decimals)


def scientific(value: float, digits: int) -> str:
    """Write a number with a power of ten, such as 1.2 × 10⁻⁵, to a count of significant digits."""
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa} × 10{raised}".replace("-", MINUS)


def rounded(value: float | None, uncertainty: float) -> str:
    """Round a number to the digits that its uncertainty allows; an en dash for none.

    Parameters
    ----------
    value : the number; None or not finite gives "–"
    uncertainty : a standard deviation or half an interval, in the same unit; where it is
        zero or not finite three significant digits are kept
    """
    if value is None or not math.isfinite(value):
        return "–"
    if not (math.isfinite(uncertainty) and uncertainty > 0):
        return significant(value)
    step = digit_step(uncertainty)
    if value:
        step = max(step, 10.0 ** (math.floor(math.log10(abs(value))) + 1 - _MOST_DIGITS))
        if abs(value) >= _LEAST_WRITTEN_OUT:
            step = max(step, 1e-6)
    decimals = -round(math.log10(step))
    if decimals > 6 or abs(value) >= 1e7:
        places = math.floor(math.log10(abs(value) or step)) - round(math.log10(step))
        return scientific(value, max(places, 0) + 1)
    return grouped(round(value / step) * step, decimals)


def significant(value: float | None, digits: int = 3) -> str:
    """Round a number to significant digits; an en dash for None or not finite."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    power = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if power < -4 or power >= 7:
        return scientific(value, digits)
    decimals = digits - 1 - power
    return grouped(round(value, decimals), decimals)


def interval(low: float, middle: float, high: float) -> tuple[str, str, str]:
    """Three quantiles to the digits that half the interval allows.

    Half of a long one can be more than its near end: where no end is past zero that end, if it is
    more than a hundredth of the far one, keeps a digit, as a stiffness of 0 is none. Nor do the
    middle and an end near it read alike that differ by a tenth of themselves: their own distance
    tells their digits.
    """
    uncertainty = (high - low) / 2.0
    worth = _LEAST_OF_FAR_END * max(abs(low), abs(high)) if low * high > 0 else math.inf

    def shown(value: float, uncertainty: float) -> str:
        text = rounded(value, uncertainty)
        gone = abs(value) >= worth and not text.strip("-0." + MINUS)
        return significant(value, 1) if gone else text

    levels = (low, middle, high)
    texts = [shown(value, uncertainty) for value in levels]
    for at, (near, far) in enumerate(pairwise(levels)):
        least = _LEAST_APART * max(abs(near), abs(far))
        if low * high <= 0:  # next to zero every number is far from every other
            least = _LEAST_OF_FAR_END * max(abs(low), abs(high))
        if far - near > least and texts[at] == texts[at + 1]:
            texts[at : at + 2] = (shown(value, far - near) for value in (near, far))
    return texts[0], texts[1], texts[2]


def hours(value: float, uncertainty: float | None = None) -> str:
    """Service hours with their unit, to the nearest hour or to a step of the uncertainty."""
    step = _hour_step(value, uncertainty)
    return grouped(round(value / step) * step, 0) + f"{THIN_SPACE}h"


def about_middle(middle: float, *ends: float | None) -> float | None:
    """Uncertainty with which a middle is rounded: the way to the nearer end that there is.

    Where an interval has a long late end, half of it would round the middle past the early one.
    """
    return min((abs(end - middle) for end in ends if end is not None), default=None)


def floored(value: float, uncertainty: float) -> float:
    """Hours rounded down to a step of their uncertainty: a date that must not be passed."""
    step = _hour_step(value, uncertainty)
    return math.floor(value / step + _SLACK) * step


def date_down(at: float, now: float, uncertainty: float) -> float:
    """Date in hours rounded down by its uncertainty, at most by a small part of the wait."""
    wait = max(at - now, 5.0)
    return max(floored(at, min(uncertainty, wait)), min(at, now))


def hours_up(value: float, uncertainty: float) -> str:
    """Hours rounded up, for the late end of an interval."""
    step = _hour_step(value, uncertainty)
    return grouped(math.ceil(value / step - _SLACK) * step, 0) + f"{THIN_SPACE}h"


def _hour_step(value: float, uncertainty: float | None) -> float:
    if uncertainty is None or not math.isfinite(uncertainty) or uncertainty <= 0:
        return 1.0
    return max(round_step(uncertainty), 1.0)


def percent(probability: float) -> str:
    """Probability in per cent; never 0 or 100 %, which no forecast can say."""
    if probability < 0.01:
        return f"less than 1{THIN_SPACE}%"
    if probability > 0.99:
        return f"more than 99{THIN_SPACE}%"
    return f"{100.0 * probability:.0f}{THIN_SPACE}%"


def percent_beside(probability: float, accepted: float) -> str:
    """Probability in per cent, to the digits that put it on its side of an accepted risk."""
    if probability < 0.001:
        return percent(probability) if accepted >= 0.01 else f"less than 0.1{THIN_SPACE}%"
    shown, wanted = 100.0 * probability, round(100.0 * accepted, 3)
    coarsest = 0 if max(probability, accepted) >= 0.01 else 1
    side = _side(round(shown, 3), wanted)
    decimals = next(d for d in range(coarsest, 4) if _side(round(shown, d), wanted) == side)
    return percent(probability) if decimals == 0 else f"{shown:.{decimals}f}{THIN_SPACE}%"


def _side(value: float, of: float) -> int:
    return (value > of) - (value < of)


def share(fraction: float) -> str:
    """Write an exact share (an acceptable risk, a counted part) in per cent."""
    return f"{100.0 * fraction:.3g}{THIN_SPACE}%"


def without_unit(text: str) -> str:
    """Hours without their unit, for the first of two: "1 450" in "between 1 450 and 2 300 h"."""
    return text.removesuffix(f"{THIN_SPACE}h")
