"""One word for what a search added and what that did."""

from __future__ import annotations

import pytest

from hdprog.discovery.verdict import verdict_of
from hdprog.explanation import UNKNOWN, Verdict

FLOOR = 8e-6


def verdict(added: list[str], before: float, after: float, *, left_over: bool = False) -> Verdict:
    """Verdict on errors in units of the noise."""
    return verdict_of(added, before * FLOOR, after * FLOOR, FLOOR, left_over=left_over)


@pytest.mark.parametrize(
    ("added", "expected"),
    [
        ([], "adequate"),
        ([UNKNOWN], "unexplained"),
        (["creep"], "explained"),
        (["creep", UNKNOWN], "partly_explained"),
    ],
)
def test_down_to_the_noise_it_is_what_was_added_that_counts(
    added: list[str], expected: Verdict
) -> None:
    assert verdict(added, 3.0, 1.05) == expected


def test_an_effect_that_takes_a_few_per_cent_of_the_error_explains_it_in_part() -> None:
    """Stick-slip of twice the noise, from which friction takes a fortieth."""
    assert verdict(["coulomb_friction"], 2.27, 2.22) == "partly_explained"


def test_most_of_the_error_taken_and_nothing_known_of_the_rest_is_explained() -> None:
    """What is left may be slow errors of an encoder."""
    assert verdict(["creep"], 5.0, 1.6) == "explained"
    assert verdict(["creep"], 5.0, 1.6, left_over=True) == "partly_explained"


def test_a_slightly_wrong_shape_within_the_noise_is_no_structure() -> None:
    assert verdict(["creep"], 5.0, 1.1, left_over=True) == "explained"
