"""Texts that differ in numbers alone become one, with ranges; names keep their digits."""

from __future__ import annotations

from hdprog.reporting.number_ranges import joined, shape_of

ROUGH = "This record bends it (Pareto k {}, at most 0.70 is trusted; {} effective draws)."


def test_numbers_that_differ_become_their_range() -> None:
    texts = [ROUGH.format("0.92", "80"), ROUGH.format("0.75", "120"), ROUGH.format("1.30", "9")]
    assert len({shape_of(text) for text in texts}) == 1
    assert joined(texts) == ROUGH.format("0.75 to 1.30", "9 to 120")


def test_one_text_and_equal_texts_stay_as_they_are() -> None:
    text = "K1 at 63 Nm (secant_stiffness@63Nm) rests on 12\u202f400 readings, 0.5 % set aside."
    assert joined([text]) == text
    assert joined([text, text]) == text


def test_thousands_are_one_number() -> None:
    texts = ["Within 4 000 steps.", "Within 12 000 steps."]
    assert joined(texts) == "Within 4 000 to 12 000 steps."


def test_a_minus_sign_is_the_numbers() -> None:
    texts = ["It moves by \u22123 %.", "It moves by 5 %.", "It moves by \u22127 %."]
    assert joined(texts) == "It moves by \u22127 to 5 %."


def test_names_with_digits_are_not_numbers() -> None:
    assert shape_of("K1 of t07 at secant@14Nm") == "K1 of t07 at secant@14Nm"
    assert shape_of("K1 is low") != shape_of("K2 is low")
