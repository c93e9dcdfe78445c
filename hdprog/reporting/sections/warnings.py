"""Warnings of every stage, each said once, the gravest first."""

from __future__ import annotations

from hdprog.reporting.declared_words import declared_words
from hdprog.reporting.effect_words import found_words
from hdprog.reporting.fit_names import explanations, named_warnings
from hdprog.reporting.left_out import gone_sentences
from hdprog.reporting.left_structure import structure_warnings
from hdprog.reporting.number_ranges import joined, shape_of
from hdprog.reporting.read_off_words import missed_words
from hdprog.reporting.trend_words import trend_warnings
from hdprog.reporting.weak_words import OF_PARAMETERS, weak_words
from hdprog.reporting.words import listed
from hdprog.results import DriveResult


def warnings(result: DriveResult) -> list[str]:
    """Warnings of the whole, of the trend and of the tests; like ones name their tests."""
    lacking = None if result.explanation is None else found_words(result.explanation)
    found = [*([] if lacking is None else [lacking]), *gone_sentences(result), *result.warnings]
    if result.provenance.quick:
        found.append(
            "Quick run: fewer draws were made, so that the ends of the intervals are less exact. "
            "Run again without --quick before a decision that costs money."
        )
    found += declared_words(result)
    if result.trend is not None:
        found += trend_warnings(result.trend, result.tests)
    by_shape: dict[str, list[tuple[str, str]]] = {}
    by_test = explanations(result)
    for test in result.tests:
        explanation = by_test.get(test.test_id)
        missed = missed_words(test)
        own = [*missed, *named_warnings(test, explanation)]
        own += [*structure_warnings(test, explanation), *weak_words(test)]
        for text in dict.fromkeys(own):
            # An interval and the range of its ends would run into each other.
            shape = text if text in missed else shape_of(text)
            by_shape.setdefault(shape, []).append((test.test_id, text))
    alike = [
        ([test for test, _ in each], joined([text for _, text in each]))
        for each in by_shape.values()
    ]
    # What is for the reader of parameters comes after what is for everybody.
    for tests, text in sorted(alike, key=lambda each: each[1].startswith(OF_PARAMETERS)):
        if len(result.tests) == 1:
            found.append(text)
        elif len(tests) == len(result.tests):
            found.append(f"All tests: {text}")
        else:
            found.append(f"{'Test' if len(tests) == 1 else 'Tests'} {listed(tests)}: {text}")
    return list(dict.fromkeys(found))
