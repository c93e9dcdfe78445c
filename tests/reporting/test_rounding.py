from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hdprog.reporting.rounding import (
    THIN_SPACE,
    floored,
    grouped,
    hours,
    hours_up,
    interval,
    percent,
    percent_beside,
    plain,
    round_step,
    rounded,
    significant,
)
from tests.reporting.page import spaced


@pytest.mark.parametrize(
    ("value", "uncertainty", "text"),
    [
        (43567.3, 310.0, "43 600"),
        (0.41234, 0.008, "0.412"),
        (-1.1772, 0.02, "−1.18"),
        (1234567.0, 90_000.0, "1 230 000"),
        (0.0000123, 0.0000004, "1.23 × 10⁻⁵"),
        (-0.0004, 0.1, "0.00"),
        (float("nan"), 1.0, "–"),
        (None, 1.0, "–"),
        (2.0, 0.0, "2.00"),
    ],
)
def test_a_number_keeps_the_digits_that_its_uncertainty_allows(
    value: float | None, uncertainty: float, text: str
) -> None:
    assert spaced(rounded(value, uncertainty)) == text


@given(
    st.floats(-1e6, 1e6, allow_nan=False),
    st.floats(1e-4, 1e5),
)
def test_rounding_moves_a_number_by_a_quarter_of_its_uncertainty_at_most(
    value: float, uncertainty: float
) -> None:
    text = spaced(rounded(value, uncertainty)).replace(" ", "").replace("−", "-")
    if "×" not in text:
        # Or by half of its seventh digit.
        assert abs(float(text) - value) <= 0.2501 * uncertainty + 0.51e-6 * abs(value)


@given(st.floats(1.0, 1e5), st.floats(1.0, 1e4))
def test_hours_round_outwards_by_less_than_a_fifth_of_the_uncertainty(
    value: float, uncertainty: float
) -> None:
    def number(text: str) -> float:
        return float(text.replace("\u202f", "").removesuffix("h"))

    room = max(0.2 * uncertainty, 1.0) + 1e-6
    assert value - 1e-6 <= number(hours_up(value, uncertainty)) <= value + room
    assert value - room <= floored(value, uncertainty) <= value + 1e-6


def test_steps_are_one_two_or_five_times_a_power_of_ten() -> None:
    assert [round_step(u) for u in (5.0, 10.0, 25.0, 417.0, 2499.0)] == [1, 2, 5, 50, 200]


def test_the_words_of_numbers() -> None:
    assert spaced(grouped(-12345.678, 1)) == "−12 345.7"
    assert spaced(plain(12000.0)) == "12 000"
    assert plain(0.3) == "0.3"
    assert significant(9.96, 2) == "10"
    assert significant(0.0) == "0"
    assert spaced(hours(1499.6)) == "1 500 h"
    assert [spaced(part) for part in interval(0.401, 0.4123, 0.422)] == ["0.401", "0.412", "0.422"]


@pytest.mark.parametrize(
    ("probability", "text"),
    [(0.0, "less than 1 %"), (0.124, "12 %"), (0.997, "more than 99 %"), (1.0, "more than 99 %")],
)
def test_no_forecast_says_0_or_100_per_cent(probability: float, text: str) -> None:
    assert spaced(percent(probability)) == text
    assert not math.isnan(probability)


def test_next_to_no_uncertainty_does_not_make_endless_digits() -> None:
    assert rounded(1.0196134612, 1e-9) == "1.019613"
    assert rounded(35812.071234567, 1e-7) == f"35{THIN_SPACE}812.07"
    assert rounded(0.3004629123, 1e-9) == "0.300463"
    assert rounded(0.000123456789, 1e-13) == "1.234568 × 10⁻⁴"


@pytest.mark.parametrize(
    ("risk", "accepted", "text"),
    [
        (0.12, 0.05, "12 %"),
        (0.0537, 0.05, "5.4 %"),
        (0.0504, 0.05, "5.04 %"),
        (0.05, 0.05, "5 %"),
        (0.0, 0.05, "less than 1 %"),
        (0.006, 0.005, "0.6 %"),
        (0.0002, 0.005, "less than 0.1 %"),
        (0.0130, 0.012, "1.3 %"),
        (0.0530, 0.0525, "5.3 %"),
        (0.0124, 0.012, "1.24 %"),
        (0.012, 0.012, "1.2 %"),
        (0.001, 0.001, "0.1 %"),
    ],
)
def test_a_risk_is_told_from_the_accepted_one(risk: float, accepted: float, text: str) -> None:
    assert spaced(percent_beside(risk, accepted)) == text


def test_the_near_end_of_a_long_interval_is_not_said_to_be_zero() -> None:
    assert interval(37e3, 110e3, 710e3)[0] == "40\u202f000"
    assert interval(0.3, 5.2, 22.0)[0] == "0.3"
    assert interval(1e-3, 5.2, 22.0)[0] == "0"
    assert interval(-0.3, 5.2, 22.0)[0] == "0"


@pytest.mark.parametrize(
    ("levels", "texts"),
    [
        ((66e3, 142e3, 3e6), ("70 000", "140 000", "3 000 000")),
        ((10.0, 56.0, 64.0), ("10", "56", "64")),
        ((-64.0, -56.0, -10.0), ("−64", "−56", "−10")),
        ((0.0, 0.02, 1.0), ("0.00", "0.02", "1.0")),
        # Next to one number, or to zero: more digits would tell nothing.
        ((95e3, 105e3, 3e6), ("100 000", "100 000", "3 000 000")),
        ((-0.001, 0.0002, 10.0), ("0", "0", "10")),
    ],
)
def test_a_skewed_interval_tells_its_median_from_the_near_end(
    levels: tuple[float, float, float], texts: tuple[str, str, str]
) -> None:
    assert tuple(map(spaced, interval(*levels))) == texts


@given(st.floats(1e-3, 1e5), st.floats(0.12, 100.0), st.floats(0.12, 100.0))
def test_levels_that_differ_by_more_than_a_tenth_never_read_alike(
    low: float, first: float, second: float
) -> None:
    middle = low * (1.0 + first)
    texts = interval(low, middle, middle * (1.0 + second))
    assert len(set(texts)) == 3
