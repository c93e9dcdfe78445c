"""What a trend warns of, in words and in the reader's units."""

from __future__ import annotations

from collections.abc import Sequence

from hdprog.reporting.words import figure_interval, listed, quantity, with_unit
from hdprog.results import NotReproduced, TestResult, TrendSummary


def trend_warnings(trend: TrendSummary, tests: Sequence[TestResult]) -> list[str]:
    """All warnings of a trend over these tests, by service hours."""
    names = [test.test_id for test in tests]
    return [*trend.warnings, *(_not_reproduced(one, names) for one in trend.not_reproduced)]


def _not_reproduced(one: NotReproduced, names: Sequence[str]) -> str:
    figure = quantity(one.key)
    joint, alone = (figure_interval(one.key, *seen) for seen in (one.joint, one.alone))
    those = f"test{'' if len(one.tests) == 1 else 's'} {listed([names[at] for at in one.tests])}"
    return (
        f"The trend does not reproduce the {figure.name} of {those}: for {names[one.worst]} it has "
        f"{joint[0]} to {with_unit(joint[2], figure.unit)} (90 %), which by itself says "
        f"{alone[0]} to {with_unit(alone[2], figure.unit)}. Read the forecast of {figure.name} "
        "with care."
    )
