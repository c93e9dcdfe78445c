"""P-values of a drive's tests joined."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.reporting.pooled import joined_p_value


def test_equal_p_values_join_to_themselves() -> None:
    assert joined_p_value([0.007] * 8) == pytest.approx(0.007, rel=1e-6)
    assert joined_p_value([0.5, 0.5]) == pytest.approx(0.5)


def test_one_that_is_small_counts_among_the_others() -> None:
    assert joined_p_value([1e-4, 0.5, 0.5, 0.5]) == pytest.approx(4e-4, rel=0.02)


@pytest.mark.parametrize("alike", [0.0, 0.9])
def test_false_alarms_are_as_many_as_stated(alike: float) -> None:
    """At 5 %, of 4000 drives of eight tests, whether these hang together or not.

    Four standard errors are 1.4 %; tests that hang together may give fewer.
    """
    from scipy.special import ndtr

    rng = np.random.default_rng(2)
    common = np.sqrt(alike) * rng.standard_normal((4000, 1))
    own = np.sqrt(1.0 - alike) * rng.standard_normal((4000, 8))
    share = np.mean([joined_p_value(row) < 0.05 for row in ndtr(common + own)])
    assert 0.02 < share < 0.064


def test_a_test_that_tells_nothing_does_not_silence_clear_ones() -> None:
    assert joined_p_value([0.005] * 5 + [1.0]) < 0.01
    assert joined_p_value([0.007] * 3 + [1.0] * 5) < 0.05
    assert joined_p_value([1.0, 1.0]) == 1.0


def test_false_alarms_stay_few_where_most_tests_have_one() -> None:
    """Corrected p-values that stop at 1 in most tests: what is cut off adds no false alarms."""
    rng = np.random.default_rng(3)
    own = np.minimum(7.0 * rng.random((4000, 6)), 1.0)
    assert np.mean([joined_p_value(row) < 0.05 for row in own]) < 0.064
