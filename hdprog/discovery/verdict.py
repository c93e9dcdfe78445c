"""The outcome of a search in one word."""

from __future__ import annotations

from collections.abc import Collection

from hdprog.explanation import UNKNOWN, Verdict

_ABOVE = 1.25  # times the noise, from which what is left is more than a slightly wrong shape
_MOST = 0.5  # of the mean square above the noise


def verdict_of(
    added: Collection[str], before: float, after: float, floor: float, *, left_over: bool
) -> Verdict:
    """Verdict on what was added and on what that did.

    Mechanisms explain in part where they come with a curve, and where more than noise is left of
    which the search knows more, or most of what was above the noise.

    Parameters
    ----------
    added : ids
    before, after : root mean square error without and with them, in rad
    floor : scatter of neighbouring residuals, in rad
    left_over : whether clear structure is left beside them
    """
    if not added:
        return "adequate"
    mechanisms = [name for name in added if name != UNKNOWN]
    if not mechanisms:
        return "unexplained"
    if UNKNOWN in added:
        return "partly_explained"
    above, left = before**2 - floor**2, after**2 - floor**2
    in_part = after > _ABOVE * floor and (left_over or left > _MOST * above)
    return "partly_explained" if in_part else "explained"
