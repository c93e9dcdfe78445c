"""Hours counted by load: how they are made, and that the tests themselves weigh them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.trend.fitting import fit_trend
from hdprog.trend.state_space import LOAD_SHARE, Timeline
from hdprog.trend.wear_clock import ServiceClock, hours_by_load
from hdprog.trend.wear_prior import read_wear_prior
from tests.hasty import HASTY
from tests.trend.stand_in import PRIOR, wearing_drive

HOURS = np.linspace(0.0, 3500.0, 8)
TORQUE = [None, 20.0, 60.0, 22.0, 55.0, 25.0, 60.0, 20.0]


def test_torque_counts_by_its_cube_and_speed_in_proportion() -> None:
    found = hours_by_load([0, 100, 200], [None, 10, 20], [None, 1000, 500])
    # Paces 1 and 8 · ½ = 4: of 200 hours the first stretch counts a fifth.
    assert found == pytest.approx((0.0, 40.0, 200.0))
    assert hours_by_load([0, 100, 200], [None, 10, 20], [None, 1000, None]) == pytest.approx(
        (0.0, 200 / 9, 200.0)
    )


@pytest.mark.parametrize(
    ("hours", "torque"),
    [([0, 100], [None, None]), ([50, 100], [None, 20]), ([0, 100], [None, 0.0]), ([0], [None])],
)
def test_a_stretch_without_load_leaves_the_hours_as_they_are(hours, torque) -> None:
    assert hours_by_load(hours, torque, [None] * len(hours)) is None


def test_a_drive_that_was_replaced_needs_no_load_for_that_of_the_next_to_count() -> None:
    """It dropped the load of the drive that runs now."""
    hours, torque, speed = [5000, 5300, 5600], [None, 10, 20], [None, 1000, 500]
    found = hours_by_load(hours, torque, speed, [True, False, False])
    assert found == pytest.approx((5000.0, 5120.0, 5600.0))
    assert hours_by_load(hours, torque, speed) is None
    hours, torque = [100, 200, 300, 400, 500], [None, 7.0, 7.0, 10.0, 20.0]
    replaced = [False, False, True, False, False]
    found = hours_by_load(hours, torque, [None] * 5, replaced)
    # The stretch up to the replacement was still of the drive before.
    assert found == pytest.approx((100.0, 200.0, 300.0, 300.0 + 200 / 9, 500.0))
    known = [5.0, *torque[1:]]
    assert hours_by_load(hours, known, [None] * 5, replaced) == hours_by_load(
        hours, known, [None] * 5
    )
    lacking = [5.0, 7.0, 7.0, 10.0, None]
    assert hours_by_load(hours, lacking, [None] * 5, replaced) is None


@pytest.mark.parametrize("follows", [True, False])
def test_the_tests_say_whether_wear_follows_the_load(follows: bool) -> None:
    by_load = hours_by_load(HOURS.tolist(), TORQUE, [None] * 8)
    assert by_load is not None
    wear = (np.array(by_load) if follows else HOURS) / 4000.0
    rng = np.random.default_rng(5)
    drive = [
        replace(test, load_hours=load)
        for test, load in zip(wearing_drive(rng, wear, HOURS), by_load, strict=True)
    ]
    trend = fit_trend(drive, PRIOR, read_wear_prior(), rng, quick=True, joint_effort=HASTY)
    share = np.quantile(trend.hyperparameters()[LOAD_SHARE], (0.1, 0.5, 0.9))
    # A priori: 0.39, 0.84, 0.99.
    if follows:
        assert share[0] > 0.7
    else:
        assert share[2] < 0.6


def test_without_loads_nothing_is_said_of_them() -> None:
    drive = wearing_drive(np.random.default_rng(1), HOURS[:2] / 4000, HOURS[:2])
    rng = np.random.default_rng(2)
    trend = fit_trend(drive, PRIOR, read_wear_prior(), rng, quick=True, joint_effort=HASTY)
    assert LOAD_SHARE not in trend.hyperparameters()
    assert LOAD_SHARE not in trend.carried_by_prior()


@pytest.mark.parametrize("torque", [TORQUE, [30.0] * 8, [None] * 8])
@pytest.mark.parametrize(("share", "counted"), [(0.0, 1000.0), (0.5, 750.0), (1.0, 500.0)])
def test_a_load_to_come_counts_as_far_as_wear_follows_the_load(
    torque: list[float | None], share: float, counted: float
) -> None:
    """Also of a drive whose own load is not told, which says no less of it than a steady one."""
    by_load = hours_by_load(HOURS.tolist(), torque, [None] * 8) or [None] * 8
    plain = wearing_drive(np.random.default_rng(1), HOURS / 4000, HOURS)
    drive = [replace(test, load_hours=load) for test, load in zip(plain, by_load, strict=True)]
    clock = ServiceClock.of(drive).slowed(0.5)
    timeline, _ = Timeline.of(drive, clock, read_wear_prior(), np.array([4500.0]))
    found = timeline.counted(np.array([share]))[0]
    assert found[-1] - found[-2] == pytest.approx(counted)


def test_hours_to_come_count_as_those_so_far_unless_a_load_is_asked_for() -> None:
    drive = wearing_drive(np.random.default_rng(1), HOURS / 4000, HOURS)
    clock = ServiceClock.of(drive)
    timeline, _ = Timeline.of(drive, clock.slowed(1.0), read_wear_prior(), np.array([4500.0]))
    assert timeline.age_by_load is None
    assert timeline.age[-1] == 4500.0


@pytest.mark.parametrize(
    ("events", "ages"),
    [
        ((None, None, None), (5000.0, 6000.0, 7500.0)),
        (("replaced", None, None), (0.0, 1000.0, 2500.0)),
        ((None, "replaced", None), (5000.0, 0.0, 1500.0)),
    ],
)
def test_a_drive_is_new_where_it_was_replaced(
    events: tuple[str | None, ...], ages: tuple[float, ...]
) -> None:
    hours = np.array([5000.0, 6000.0, 7500.0])
    plain = wearing_drive(np.random.default_rng(1), hours / 8000, hours)
    drive = [replace(test, event=event) for test, event in zip(plain, events, strict=True)]
    timeline, _ = Timeline.of(drive, ServiceClock.of(drive), read_wear_prior())
    assert timeline.age == pytest.approx(ages)


@pytest.mark.parametrize(
    ("torque", "pace"),
    [
        ([None, 20.0, None, 60.0, 60.0], 27.0),
        ([None, 60.0, None, 20.0, 20.0], 1 / 27),
        ([None, 20.0, None], 1.0),
    ],
)
def test_a_drive_that_replaced_another_goes_on_at_its_own_load(
    torque: list[float | None], pace: float
) -> None:
    """Over the pace of the drive before it; one that has not run yet has no load of its own."""
    count = len(torque)
    hours = np.array([0.0, 5000.0, 5000.0, 6000.0, 7000.0])[:count]
    by_load = hours_by_load(hours.tolist(), torque, [None] * count)
    assert by_load is not None
    drive = [
        replace(test, load_hours=load, event="replaced" if place == 2 else None)
        for place, (test, load) in enumerate(
            zip(wearing_drive(np.random.default_rng(1), hours / 8000, hours), by_load, strict=True)
        )
    ]
    clock, last = ServiceClock.of(drive), hours[-1]
    before, ahead = (
        np.diff(clock(np.array([4000.0, 5000.0]))),
        np.diff(clock(np.array([last, last + 1e3]))),
    )
    assert ahead == pytest.approx(pace * before)


def test_what_the_old_drive_ran_before_it_was_replaced_is_the_old_ones_load() -> None:
    """The new one was first tested 500 h after the old one's last test, and ran at a third."""
    hours = np.array([1000.0, 2000.0, 2500.0, 3000.0, 4000.0])
    counted = np.array([1000.0, 2000.0, 4000.0, 4150.0, 4450.0])
    events = (None, None, "replaced", None, None)
    tests = wearing_drive(np.random.default_rng(1), hours / 8000, hours)
    drive = [
        replace(test, load_hours=float(load), event=event)
        for test, load, event in zip(tests, counted, events, strict=True)
    ]
    clock = ServiceClock.of(drive)
    ahead = clock(np.array([4000.0, 5000.0]))
    # 450 of 1 500 h, not 2 450 of 2 000.
    assert ahead == pytest.approx((4450.0, 4750.0))
