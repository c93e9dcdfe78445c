"""Limits that lie nowhere near what a drive has: slips of a unit or of the keyboard, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hdprog.config import Limit
from hdprog.reporting.rounding import significant
from hdprog.reporting.words import capital, quantity, threshold_words, with_unit
from hdprog.results import DriveResult

# Beyond the 90 % interval. An arc second is 1/60 of an arc minute, a Nm 1/1000 of a kNm.
_FAR = 30.0
_FAR_BY_QUANTITY = {
    "preload_Nm": 300.0,  # "all but gone" is a limit
    "hysteresis_loss_J": 300.0,  # grows from next to nothing
}


def far_limits(result: DriveResult, limits: Sequence[Limit]) -> list[str]:
    """Sentences on those of a drive's limits that are far off what every test of it shows."""
    said = []
    for limit in limits:
        seen = [test.figures[limit.key] for test in result.tests if limit.key in test.figures]
        if seen:
            low = min(levels[0.05] for levels in seen)
            high = max(levels[0.95] for levels in seen)
            tests = "test shows" if len(seen) == 1 else "tests show"
            said.append(far_words(limit, low, high, f"the {tests}"))
    return [text for text in said if text]


def far_from_prior(
    limits: tuple[Limit, ...], expected: Mapping[str, tuple[float, float]]
) -> list[str]:
    """The same before there is a fit.

    Parameters
    ----------
    limits : of the drive
    expected : figure's key → 5 % and 95 % quantile under the drive's prior
    """
    whose = "the drive's prior expects"
    said = [
        far_words(limit, *expected[limit.key], whose) for limit in limits if limit.key in expected
    ]
    return [text for text in said if text]


def far_words(limit: Limit, low: float, high: float, whose: str) -> str:
    """One sentence with what to do, empty for a limit that can be.

    Parameters
    ----------
    limit : the limit
    low, high : 90 % interval of its figure
    whose : "the tests show", say
    """
    if high == 0.0:
        return (
            f"{capital(quantity(limit.key).name)} is exactly 0 in all that {whose}: at the torque "
            "that it is taken at, the teeth never slip. Check the unit of the torque, and "
            "rated_torque_Nm or reference_torque_Nm in drive.toml; the limit means nothing before "
            "that."
        )
    far = _FAR_BY_QUANTITY.get(limit.quantity, _FAR)
    if limit.threshold > far * high:
        times, than = limit.threshold / high, "more"
    elif limit.threshold < low / far:
        times, than = low / limit.threshold, "less"
    else:
        return ""
    named, bound = quantity(limit.key), threshold_words(limit.key, limit.threshold)
    ends = [significant(named.factor * end) for end in (low, high)]
    return (
        f"The limit on {named.name}, {limit.direction} {bound}, is {significant(times, 2)} times "
        f"{than} than anything that {whose} "
        f"(90 %: {ends[0]} to {with_unit(ends[1], named.unit)}): check its number and unit in "
        "drive.toml. What is forecast of it means nothing before that."
    )
