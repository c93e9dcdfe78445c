"""Whether an effect belongs to the rig or to wear, from its sizes in the tests of a drive."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.stats import norm

from hdprog.discovery.drive import _came_with, brought_by_wear, origin_of
from hdprog.inference.posterior import Posterior
from hdprog.physics.parameters import FloatArray

HOURS = np.linspace(0.0, 3600.0, 8)
NOTHING = [None] * 8  # was done to the drive
FEWEST_HELD = 0.97  # of 400 drives: the rule asks for three standard errors


def sizes(median: FloatArray, error: FloatArray) -> FloatArray:
    """(tests, 4) from medians and standard deviations in rad; zeros where the effect is absent."""
    found = np.column_stack([HOURS, median - 1.645 * error, median, median + 1.645 * error])
    found[median == 0.0, 1:] = 0.0
    return np.maximum(found, 0.0)


def drawn(course: FloatArray, error: float, seed: int) -> FloatArray:
    """Sizes of this course, as reliable as said, that scatter by 15 % from test to test."""
    rng = np.random.default_rng(seed)
    scattered = course * np.exp(0.15 * rng.standard_normal(course.size))
    return sizes(
        np.maximum(scattered + error * rng.standard_normal(course.size), 1e-7),
        np.full(course.size, error),
    )


@pytest.mark.parametrize("error", [3e-6, 1.5e-5])
def test_what_stays_as_it_is_is_hardly_ever_called_wear(error: float) -> None:
    origins = [origin_of(drawn(np.full(8, 6e-5), error, seed), NOTHING) for seed in range(400)]
    assert np.mean([origin != "wear" for origin in origins]) >= FEWEST_HELD
    assert np.mean([origin == "rig" for origin in origins]) > 0.9


@pytest.mark.parametrize("error", [3e-6, 1.2e-5])
def test_what_grows_with_service_is_called_wear(error: float) -> None:
    course = 1e-4 * (HOURS / HOURS[-1]) ** 1.3
    origins = [origin_of(drawn(course, error, seed), NOTHING) for seed in range(400)]
    assert np.mean([origin == "wear" for origin in origins]) > 0.95
    assert "rig" not in origins


def test_a_test_that_does_not_tell_does_not_say_that_the_effect_is_absent() -> None:
    """Measured on a simulated drive whose play grew from nothing to 104 µrad."""
    median = 1e-6 * np.array([0, 8, 26, 17, 0, 85, 82, 104])
    error = 1e-6 * np.array([0, 2, 3, 11, 0, 9, 22, 23])
    assert origin_of(sizes(median, error), NOTHING) == "wear"


def test_growth_of_few_tests_is_told_by_its_course() -> None:
    """At less than three standard errors; by a hair more or less it was wear or was not."""
    hours = np.array([0.0, 500.0, 1000.0, 1500.0])
    course = 1e-4 * np.array([0.0, 1.45, 3.0, 3.45])
    for scale, least in ((1.0, 2e-6), (1.15, 8e-5), (0.9, 8e-5)):
        last = np.array([1.0, 1.0, 1.0, scale])
        error = np.array([0.0, 4e-6, 1.3e-5, least])
        found = np.column_stack([hours, *(course * last + k * error for k in (-1.645, 0, 1.645))])
        assert origin_of(found, [None] * 4) == "wear"
    came = 1e-4 * np.array([0.0, 0.0, 3.0, 3.0])
    found = np.column_stack([hours, came - 1e-5, came, came + 1e-5])
    assert origin_of(found, [None] * 4) == "unclear"


def test_few_tests_tell_nothing() -> None:
    two = sizes(np.full(8, 6e-5), np.full(8, 3e-6))[:2]
    assert origin_of(two, NOTHING[:2]) == "unclear"


REPLACED = [None] * 4 + ["replaced"] + [None] * 3


def test_what_only_the_new_drive_has_did_not_grow() -> None:
    course = np.array([0.0] * 4 + [6e-5] * 4)
    error = np.full(8, 3e-6)
    assert origin_of(sizes(course, error), REPLACED) == "unclear"
    # The same sizes on one drive are told by their course over the hours.
    assert origin_of(sizes(course, error), NOTHING) == "wear"


@pytest.mark.parametrize(
    "course",
    [[0, 30, 60, 90, 0, 30, 60, 90], [0, 0, 0, 0, 0, 30, 60, 90], [0, 30, 60, 90, 0, 0, 5, 0]],
)
def test_what_grows_on_one_drive_is_wear_whatever_the_other_has(course: list[float]) -> None:
    """Also where all tests together do not show it, as the new drive begins anew."""
    found = sizes(1e-6 * np.array(course), np.full(8, 3e-6))
    assert origin_of(found, REPLACED) == "wear"


def test_a_rig_is_the_same_for_both_drives() -> None:
    assert origin_of(sizes(np.full(8, 6e-5), np.full(8, 3e-6)), REPLACED) == "rig"


def posterior(lowest: float, size: float) -> Posterior:
    """Of a record from this torque to 60 Nm, in which play moves the angle by so much, in rad."""
    torque = np.linspace(lowest, 60.0, 40)
    course = SimpleNamespace(
        path=SimpleNamespace(torque=torque, starts=np.array([0, 20])),
        scales=SimpleNamespace(torque=60.0, sweep=None),
        time=None,
        rate=None,
    )
    moved = size * np.sign(torque - torque.mean()) * np.ones((20, 1))
    return cast(
        Posterior,
        SimpleNamespace(
            effects=("backlash",) if size > 0 else (),
            likelihood=SimpleNamespace(reduced=SimpleNamespace(course=course)),
            without_effect=lambda name, draws: (moved, np.zeros_like(moved)),
        ),
    )


@pytest.mark.parametrize(("lowest", "worn"), [(0.0, False), (-60.0, True)])
def test_a_test_that_cannot_show_an_effect_does_not_say_that_it_came(
    lowest: float, worn: bool
) -> None:
    """Play of the rig, loaded to one side in the first four tests: it had begun with the fifth."""
    tests = [posterior(lowest, 0.0)] * 4 + [posterior(-60.0, 6e-5)] * 4
    found = [effect.id for effect in brought_by_wear(tests, HOURS.tolist(), NOTHING)]
    assert found == (["backlash"] if worn else [])


def test_what_cannot_be_shown_by_some_tests_is_judged_by_the_others() -> None:
    rig, grown = np.full(8, 6e-5), np.concatenate([np.zeros(4), [1e-5, 3e-5, 6e-5, 9e-5]])
    for course, origin in ((rig, "rig"), (grown, "wear")):
        found = sizes(course, np.full(8, 2e-6))
        found[:4, 1:] = np.nan
        assert origin_of(found, NOTHING) == origin
    found[:6, 1:] = np.nan
    assert origin_of(found, NOTHING) == "unclear"


@pytest.mark.parametrize("event", ["reassembled", "regreased"])
def test_what_came_as_the_drive_was_taken_apart_did_not_grow(event: str) -> None:
    """Of 400 drives each; one in ten may go wrong, as levels and lines are alike to the scatter."""
    events = [None] * 3 + [event] + [None] * 4
    came, grown = np.repeat([0.0, 8e-5], [3, 5]), 1e-4 * (HOURS / HOURS[-1]) ** 1.3
    for course, least, most in ((came, 0.0, 0.1), (grown, 0.9, 1.0)):
        origins = [origin_of(drawn(course, 3e-6, seed), events) for seed in range(400)]
        assert least <= np.mean([origin == "wear" for origin in origins]) <= most
        assert "rig" not in origins


def test_what_came_as_the_drive_was_taken_apart_is_followed_all_the_same() -> None:
    """The trend has a step at the event: left out, the forecast would be without the effect."""
    tests = [posterior(-60.0, 0.0)] * 4 + [posterior(-60.0, 6e-5)] * 4
    events = [None] * 4 + ["reassembled"] + [None] * 3
    found = [effect.id for effect in brought_by_wear(tests, HOURS.tolist(), events)]
    assert found == ["backlash"]


@pytest.mark.parametrize("seed", range(4))
def test_levels_between_events_pay_by_schwarz_s_criterion(seed: int) -> None:
    """Two events part three levels, one number more than a line has, and log n dearer.

    By the densities themselves, of courses between a line and levels.
    """
    rng = np.random.default_rng(seed)
    events = [None] * 3 + ["regreased"] + [None] * 3 + ["reassembled"] + [None] * 4
    hours, stretch = np.linspace(0.0, 3600.0, 12), np.repeat([0, 1, 2], [3, 4, 5])
    told, narrow = [], 0
    for _ in range(100):
        line = 1e-5 * (4.0 + 8.0 * hours / hours[-1])
        levels = np.array([line[stretch == one].mean() for one in range(3)])[stretch]
        share, error = rng.uniform(), 1.2e-5
        size = share * line + (1 - share) * levels + error * rng.standard_normal(12)
        size = np.maximum(size, 1e-6)
        found = np.column_stack([hours, size - 1.645 * error, size, size + 1.645 * error])
        sd = np.maximum(np.hypot(error, 0.15 * size), 0.3 * np.median(size))
        of_line = np.polyval(np.polyfit(hours, size, 1, w=1 / sd), hours)
        means = [
            np.average(size[stretch == one], weights=sd[stretch == one] ** -2) for one in (0, 1, 2)
        ]
        of_levels = np.array(means)[stretch]
        straight, stepped = (-2 * norm(one, sd).logpdf(size).sum() for one in (of_line, of_levels))
        told.append(
            _came_with(found, events) == (stepped + 3 * np.log(12) < straight + 2 * np.log(12))
        )
        narrow += 1.0 < straight - stepped < np.log(12)
    assert all(told)
    assert narrow >= 3  # where a penalty of one would choose otherwise
