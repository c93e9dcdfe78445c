"""The band of uniform ranks: exact where all cases can be counted, and what it catches."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import binom

from tests.benchmarks.calibration.ecdf_band import Uniformity


@pytest.mark.parametrize(("count", "highest"), [(1, 1), (3, 4), (5, 3), (4, 7)])
def test_p_value_is_the_share_of_samples_as_far_off(count: int, highest: int) -> None:
    test = Uniformity(count, highest)
    samples = [np.array(one) for one in product(range(highest + 1), repeat=count)]
    distances = np.array([test.distance(one) for one in samples])
    for one, distance in list(zip(samples, distances, strict=True))[::17]:
        counted = np.mean(distances <= distance * (1 + 1e-12))
        assert test.p_value(one) == pytest.approx(counted, abs=1e-12)


@pytest.mark.parametrize("rate", [0.05, 0.3])
def test_band_is_as_wide_as_it_must_be(rate: float) -> None:
    test = Uniformity(4, 7)
    samples = [np.array(one) for one in product(range(8), repeat=4)]
    least, largest = test.band(rate)
    counts = np.array([test.counts(one) for one in samples]) / 4
    outside = np.any((counts < least) | (counts > largest), axis=1)
    assert outside.mean() <= rate
    # Those outside are those whose p value says so: no band of this form is narrower.
    assert (outside[::9] == [test.p_value(one) <= rate for one in samples[::9]]).all()


def test_false_alarms_of_the_band() -> None:
    """At 5 %, of 4 000 sets of 150 uniform ranks; one in 10^4 would fail on either side."""
    rng = np.random.default_rng(3)
    test = Uniformity(150, 383)
    critical = test.critical(0.05)
    alarms = sum(test.distance(rng.integers(0, 384, 150)) <= critical for _ in range(4000))
    # The counts are whole numbers: the band's own rate lies a little below the one asked for.
    assert binom.ppf(1e-4, 4000, 0.045) <= alarms <= binom.ppf(1 - 1e-4, 4000, 0.05)


@pytest.mark.parametrize(("shift", "narrowed"), [(0.3, 1.0), (-0.3, 1.0), (0.0, 0.8), (0.0, 1.25)])
def test_wrong_place_and_width_leave_the_band(shift: float, narrowed: float) -> None:
    rng = np.random.default_rng(4)
    true = ndtr((rng.standard_normal(1000) + shift) / narrowed)
    ranks = np.minimum((true * 384).astype(int), 383)
    test = Uniformity(1000, 383)
    assert test.p_value(ranks) < 1e-4
    least, largest = test.band(0.01)
    ecdf = test.counts(ranks) / 1000
    assert ((ecdf < least) | (ecdf > largest)).any()


def test_places_divide_the_ranks_evenly() -> None:
    shares = Uniformity(10, 383).shares
    np.testing.assert_allclose(np.diff(shares), shares[0])
    assert shares.size == 127


@pytest.mark.parametrize("ranks", [[0, 1], [0, 1, 5], [-1, 0, 1]])
def test_other_ranks_are_refused(ranks: list[int]) -> None:
    with pytest.raises(ValueError, match="expected 3 ranks from 0 to 4"):
        Uniformity(3, 4).distance(np.array(ranks))
