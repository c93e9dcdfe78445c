"""The headline on what the model lacked: what explains it, and how far the error falls."""

from __future__ import annotations

from hdprog.explanation import DriveExplanation, Explanation
from hdprog.reporting.effect_words import (
    effect_words,
    left_over_words,
    mechanisms,
    place_of_unknown,
    unknown_term,
)
from hdprog.reporting.error_words import (
    above_noise,
    accounted_for,
    against_cycles,
    before_and_after,
    down_to_noise,
    errors,
    not_predicted,
    unexplained_alone,
)
from hdprog.reporting.words import agree, counted, listed


def lead(found: Explanation | DriveExplanation) -> str:
    """Verdict on one record or on a drive's tests, with the errors (of tests: pooled).

    The error is told on the data fitted and on data left out, and whether that grew.
    """
    reached = errors(found)
    several = isinstance(found, DriveExplanation) and len(found.tests) > 1
    said = [
        _nothing_added(found) if found.verdict == "adequate" else _found(found),
        f"Error {'over all tests ' if several else ''}{before_and_after(reached)}.",
        not_predicted(reached),
        None if found.left_over is None else left_over_words(found.left_over),
    ]
    return " ".join(text for text in said if text is not None)


def left(found: Explanation | DriveExplanation) -> str:
    """What is left, against how far the record's own cycles differ, else against the noise."""
    reached = errors(found)
    if found.left_over is not None and accounted_for(reached):
        return ""  # that nothing more can be explained would not be true
    return against_cycles(reached) or above_noise(reached) or ""


def _nothing_added(found: Explanation | DriveExplanation) -> str:
    count = len(found.tests) if isinstance(found, DriveExplanation) else 1
    tests = agree(count, "this record", f"all {count} tests")
    if down_to_noise(errors(found)):
        noise = agree(count, "its noise", "their noise")
        return f"The drive model explains {tests} down to {noise}: nothing was added."
    return (
        f"The drive model does not reach the noise on {tests}, but nothing that was tried "
        "explains it beyond doubt: nothing was added."
    )


def _where(found: Explanation | DriveExplanation) -> str:
    if isinstance(found, Explanation):
        return "this record"
    count, shown = len(found.tests), len(unexplained_alone(found.tests))
    if shown == 0:  # each by itself is down to its noise
        return agree(count, "this test", f"these {count} tests taken together")
    return f"{shown} of {counted(count, 'test')}"


def _found(found: Explanation | DriveExplanation) -> str:
    where = _where(found)
    known, unknown = mechanisms(found.effects), unknown_term(found.effects)
    named = listed(effect_words(effect) for effect in known)
    place = "" if unknown is None else place_of_unknown(found)
    does = agree(len(known), "does", "do")
    if unknown is None:
        part = "" if found.left_over is None and accounted_for(errors(found)) else " in part"
        return f"The drive model alone does not explain {where}; {named} {does}{part}."
    if known:
        return (
            f"The drive model alone does not explain {where}; {named} {does} in part, and "
            f"{effect_words(unknown)} remains {place}. Its shape is drawn below."
        )
    return (
        f"In {where} there is {effect_words(unknown)}: it acts {place}. Its shape is drawn below."
    )
