"""The error in words: on data left out, against the noise, and against the record's own cycles."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.explanation import ErrorFigures, Explanation
from hdprog.reporting.error_words import (
    above_noise,
    accounted_for,
    against_cycles,
    errors,
    not_predicted,
)
from hdprog.reporting.verdict import verdict
from tests.reporting import explanations
from tests.reporting.effects_view import said, section
from tests.reporting.page import spaced


def reached(
    fitted: float,
    left_out: float,
    *,
    cycles: float | None = 9e-6,
    alike: float = 0.02,
    floor: float = 7e-6,
) -> Explanation:
    """A record that creep takes from 100 µrad, 120 on data left out, to these errors in rad."""
    return explanations.record(
        before=ErrorFigures(100e-6, 120e-6, None, 0.9),
        after=ErrorFigures(fitted, left_out, None, alike),
        repeatability_rad=cycles,
        noise_floor_rad=floor,
    )


@pytest.mark.parametrize(
    ("left_out", "words"),
    [
        (140e-6, "On data left out of the fit the error grew: "),
        (121e-6, "On data left out of the fit the error hardly fell: "),
        (119e-6, "On data left out of the fit the error hardly fell: "),
        (90e-6, None),
        (float("nan"), None),
    ],
)
def test_an_error_that_does_not_fall_on_data_left_out_is_said(
    left_out: float, words: str | None
) -> None:
    record = reached(8e-6, left_out)
    found = not_predicted(errors(record))
    assert (found is None) if words is None else (found or "").startswith(words)
    if words is not None:
        assert words in section(record).lead
        assert any(words in text for text in verdict(explanations.single(record)).sentences)


@pytest.mark.parametrize(
    ("left_out", "words"),
    [
        (
            119e-6,
            "On data left out of the fit the error hardly fell: one record by itself hardly tells "
            "what was added, but 2 of 3 tests show it.",
        ),
        (140e-6, "On data left out of the fit the error grew: what was added describes "),
    ],
)
def test_an_effect_that_several_tests_show_needs_no_further_record(
    left_out: float, words: str
) -> None:
    found = reached(8e-6, left_out)
    without = replace(found, effects=(), after=found.before)
    drive = explanations.drive_explanation(tests=(without, found, found), effects=found.effects)
    assert (not_predicted(errors(drive)) or "").startswith(words)
    once = replace(drive, tests=(without, without, replace(found, before=found.after)))
    said = not_predicted(errors(once))
    assert said is not None
    assert said.endswith("until another record shows it too.")


def test_nothing_added_predicts_nothing_worse() -> None:
    assert not_predicted(errors(explanations.adequate())) is None


@pytest.mark.parametrize(
    ("record", "words"),
    [
        (
            reached(7.2e-6, 7.6e-6),
            "The cycles of this record repeat to 9.0 µrad; 7.6 µrad is left, which the noise "
            "accounts for: nothing more can be explained.",
        ),
        (
            reached(20e-6, 24e-6, cycles=25e-6),
            "The cycles of this record repeat to 25 µrad; 24 µrad is left: nothing more that comes "
            "back in every cycle can be explained.",
        ),
        (
            reached(20e-6, 24e-6, cycles=25e-6, alike=0.8),
            "The cycles of this record repeat to 25 µrad; 24 µrad is left: nothing more that comes "
            "back in every cycle can be explained. Neighbouring readings are still alike: what is "
            "left differs by cycle.",
        ),
        (
            reached(8e-6, 13e-6, cycles=40e-6),
            "The cycles of this record repeat to 40 µrad; 13 µrad is left: the fit follows what "
            "differs between cycles, so that the noise of 7.0 µrad is the measure of what is left.",
        ),
        (
            reached(24e-6, 60e-6, cycles=25e-6),
            "The cycles of this record repeat to 25 µrad; the fit comes as close as that, but not "
            "on data left out of the fit.",
        ),
        (
            reached(60e-6, 70e-6, cycles=25e-6),
            "The cycles of this record repeat to 25 µrad; 60 µrad is left: part of it is still "
            "unexplained.",
        ),
    ],
)
def test_what_is_left_is_held_against_the_records_own_cycles(
    record: Explanation, words: str
) -> None:
    assert spaced(against_cycles(errors(record)) or "") == words
    assert words in said(record)


def test_without_cycles_that_repeat_the_noise_is_the_measure() -> None:
    record = reached(21e-6, 24e-6, cycles=None)
    assert against_cycles(errors(record)) is None
    assert section(record).left == (
        "What is left is still 3.0 times the noise: part of it is unexplained."
    )
    assert above_noise(errors(reached(7.5e-6, 8e-6, cycles=None))) is None


def test_what_is_far_above_noise_and_cycles_is_explained_in_part() -> None:
    assert "recovers) does. Error" in section(reached(7.5e-6, 8e-6)).lead
    assert "recovers) does in part. Error" in section(reached(60e-6, 70e-6)).lead
    assert accounted_for(errors(reached(24e-6, 25e-6, cycles=25e-6)))
    assert not accounted_for(errors(reached(24e-6, 25e-6, cycles=25e-6, alike=0.8)))


def test_a_drive_model_that_misses_the_noise_is_not_said_to_reach_it() -> None:
    same = ErrorFigures(40e-6, 44e-6, None, 0.6)
    lead = section(replace(explanations.adequate(), before=same, after=same)).lead
    assert "does not reach the noise on this record" in lead
    assert "nothing was added" in lead


def test_cycles_count_only_where_every_test_has_them() -> None:
    drive = explanations.drive_explanation()
    assert errors(drive).repeatability == pytest.approx(9e-6)
    bare = (replace(drive.tests[0], repeatability_rad=None), *drive.tests[1:])
    assert errors(replace(drive, tests=bare)).repeatability is None
