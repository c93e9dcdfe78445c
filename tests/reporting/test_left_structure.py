"""Structure that nothing accounts for is said first of all, not only where pictures are."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hdprog.reporting.json_of_test import test_json as document
from hdprog.reporting.left_structure import SLOW_ERRORS, STRUCTURE, UNSOUGHT
from hdprog.reporting.verdict import verdict
from hdprog.results import DriveResult
from tests.reporting import drives, explanations
from tests.reporting.page import spaced


def structured(result: DriveResult, *places: int) -> DriveResult:
    """The result, some of its tests left with three times the noise, neighbours alike."""
    tests = [
        replace(test, residual_correlation=0.8, rmse_rad=3.0 * test.noise_floor_rad)
        if at in places
        else test
        for at, test in enumerate(result.tests)
    ]
    return replace(result, tests=tuple(tests))


def said(result: DriveResult) -> list[str]:
    sentences = [spaced(text) for text in verdict(result).sentences]
    return [text for text in sentences if "hangs together" in text]


def test_a_record_that_is_called_adequate_says_what_is_left() -> None:
    found = structured(explanations.single(explanations.adequate()), 0)
    assert said(found) == [
        "What the fit leaves hangs together and is 3.0 times the noise, and no effect or curve "
        "accounts for it: something acts that the model lacks, and what is said here may be "
        "biased by it."
    ]
    assert STRUCTURE in document(found.tests[0], found.explanation)["warnings"]


def test_tests_of_a_drive_are_named() -> None:
    (found,) = said(structured(drives.wearing(count=3), 0, 2))
    assert found.startswith(
        "What the fit leaves of tests t01 and t03 hangs together and is up to 3.0 times the noise: "
    )


@pytest.mark.parametrize(
    "result",
    [
        drives.wearing(count=3),
        explanations.single(explanations.adequate()),
        structured(explanations.single(explanations.record()), 0),
    ],
    ids=["noise", "adequate", "explained"],
)
def test_nothing_is_said_of_noise_or_of_what_is_explained(result: DriveResult) -> None:
    assert not said(result)


def test_what_a_search_explained_has_no_such_warning_and_what_was_asked_for_has() -> None:
    (test,) = structured(explanations.single(explanations.record()), 0).tests
    assert STRUCTURE not in document(test, explanations.record())["warnings"]
    assert STRUCTURE in document(test, None)["warnings"]


def test_slow_errors_that_a_search_took_for_noise_are_no_alarm() -> None:
    """The noise model stands for them; unsought, or of three times the noise, they may be more."""
    result = explanations.single(explanations.adequate())
    slow = {"residual_correlation": 0.6, "noise_model": "white noise and slow errors"}
    tests = [replace(test, rmse_rad=1.5 * test.noise_floor_rad, **slow) for test in result.tests]
    found = replace(result, tests=tuple(tests))
    assert not said(found)
    warned = document(found.tests[0], found.explanation)["warnings"]
    assert (SLOW_ERRORS in warned, STRUCTURE in warned) == (True, False)
    (unsought,) = said(replace(found, explanation=None))
    assert unsought.endswith(
        "is 1.5 times the noise: slow errors of the rig or its encoder, or something that acts and "
        "that the model lacks. Run `hdprog explain` before you rely on what is said here."
    )
    assert UNSOUGHT in document(found.tests[0], None)["warnings"]
