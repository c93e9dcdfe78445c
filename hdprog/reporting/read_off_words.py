"""Figures that the fit misses and the record shows, in words."""

from __future__ import annotations

from hdprog.explanation import UNKNOWN
from hdprog.reporting.rounding import rounded
from hdprog.reporting.words import capital, figure_interval, listed, quantity, with_unit
from hdprog.results import DriveResult, ReadOff, TestResult, since_replaced

_SEVERAL = 2  # tests: one of many may be missed by chance


def missed_words(test: TestResult) -> list[str]:
    """Sentences on a test's figures that its fit misses, each to stand alone."""
    return [_missed(test, key, found) for key, found in test.read_off.items() if found.differs]


def missed_sentences(result: DriveResult) -> list[str]:
    """The same for the verdict: figures with a limit; all where none has one.

    Those of the last test; else those that the fits of several tests miss, as the trend leans on
    all of them.
    """
    tests = since_replaced(result.tests)
    last, limited = tests[-1], [limit.key for limit in result.drive.limits]
    which = "" if len(result.tests) == 1 else f"Test {last.test_id}: "
    said = []
    # The last record may be one that does not show a figure, as a one-sided one.
    for key in dict.fromkeys(key for one in (last, *tests) for key in one.read_off):
        if limited and key not in limited:
            continue
        missed = [one.test_id for one in tests if key in one.read_off and one.read_off[key].differs]
        if last.test_id in missed:
            said.append(which + _missed(last, key, last.read_off[key]))
        elif len(missed) >= _SEVERAL:
            said.append(
                f"The fits of {len(missed)} of {len(tests)} tests ({listed(missed)}) miss the "
                f"{quantity(key).name} that their records show: read the warnings before you rely "
                "on a forecast of it."
            )
    return said


def record_words(key: str, found: ReadOff) -> str:
    """What is read off the record with its standard deviation, in the reader's unit."""
    factor = quantity(key).factor
    value, sd = factor * found.record, factor * found.record_sd
    return f"{rounded(value, sd)} ± {rounded(sd, sd)}"


def _missed(test: TestResult, key: str, found: ReadOff) -> str:
    named = quantity(key)
    low, middle, high = figure_interval(key, found.fit[0.05], found.fit[0.50], found.fit[0.95])
    fit = "the fit, its empirical curve left out," if UNKNOWN in test.effects else "the fit"
    return (
        f"{capital(named.name)} read off the record itself is "
        f"{with_unit(record_words(key, found), named.unit)}, where {fit} has {middle} over "
        f"the same readings (90 %: {low} to {with_unit(high, named.unit)}). The fit misses what "
        f"was measured: do not trust it, or a forecast of {named.name}, before that is explained."
    )
