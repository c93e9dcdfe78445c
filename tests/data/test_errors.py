from __future__ import annotations

import pickle

from hdprog.errors import BadInputError, HdprogError, UsageError


def test_the_words_hold_all_four_parts_in_one_paragraph() -> None:
    error = BadInputError("'x'", "a.csv, row 3", "a number", "correct it")
    assert str(error) == "a.csv, row 3: found 'x'; expected a number. Correct it."
    assert (error.found, error.where, error.expected) == ("'x'", "a.csv, row 3", "a number")


def test_exit_codes() -> None:
    assert [kind.exit_code for kind in (HdprogError, UsageError, BadInputError)] == [1, 2, 3]


def test_it_comes_back_whole_from_another_process() -> None:
    error = BadInputError("a", "b", "c", "Do d.")
    back = pickle.loads(pickle.dumps(error))
    assert (str(back), back.where) == (str(error), "b")
