"""Which coordinate carries a residual, at what false-alarm rate, and how well a record repeats."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.discovery import residuals
from hdprog.discovery.residuals import carriers, contiguous_folds, repeatability
from hdprog.explanation import Carrier
from hdprog.physics.course import Course
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

TIME = np.linspace(0.0, 100.0, 161)
TORQUE = np.interp(TIME, [0, 10, 30, 55, 80, 90, 100], [0, 80, -80, 80, -80, 80, 0])
TEMPERATURE = 20 + 3 * np.sin(2 * np.pi * TIME / 73)
ANGLE = TORQUE / 1.5e4
COURSE: Course = record_course(
    Loop(TORQUE, ANGLE, TIME, TEMPERATURE), TorquePath.exact(TORQUE), 0.0
)
RISING = COURSE.path.direction > 0

# What a fit would have absorbed: stiffness, its change with load, width and zero.
SENSITIVITIES = np.column_stack(
    [TORQUE / 80, (TORQUE / 80) ** 3, COURSE.path.direction, np.ones(TIME.size)]
)
BASIS = np.linalg.qr(SENSITIVITIES)[0]


def left_by_a_fit(values: FloatArray) -> FloatArray:
    return values - BASIS @ (BASIS.T @ values)


def carried(curve: FloatArray, rng: np.random.Generator) -> tuple[Carrier, ...]:
    noisy = rng.standard_normal(TIME.size) + 1.5 * curve / np.std(curve)
    return carriers(left_by_a_fit(noisy), SENSITIVITIES, ANGLE, COURSE, rng)


CURVES = {
    "torque": np.cos(2 * np.pi * TORQUE / 45),
    "branch": np.sin(2 * np.pi * TORQUE / 50) * RISING,
    "temperature": np.sin(2 * np.pi * TEMPERATURE / 2.1),
    "distance_since_reversal": COURSE.path.direction * np.exp(-COURSE.travel / 12),
    "time": (TIME > 43).astype(float),
}


@pytest.mark.parametrize("name", CURVES)
def test_the_planted_coordinate_is_named(name: str) -> None:
    found = carried(CURVES[name], np.random.default_rng(3))
    fractions = [carrier.fraction for carrier in found]
    assert fractions == sorted(fractions, reverse=True)
    by_name = {carrier.coordinate: carrier for carrier in found}
    # On a stiff drive the angle says what the torque says.
    leading = found[0].coordinate
    assert leading in {name, "angle"} if name == "torque" else leading == name
    assert by_name[name].p_value < 0.05
    # Signal to noise is 1.5² : 1, less what the fit took and what folds cannot know.
    assert 0.25 < by_name[name].fraction < 1.5**2 / (1 + 1.5**2) + 0.1


def test_every_coordinate_is_asked() -> None:
    found = carried(CURVES["torque"], np.random.default_rng(4))
    wanted = {"torque", "branch", "distance_since_reversal", "time", "time_since_reversal"}
    assert {carrier.coordinate for carrier in found} == wanted | {"rate", "temperature", "angle"}
    assert all(0.0 <= carrier.fraction <= 1.0 for carrier in found)
    assert all(0.0 < carrier.p_value <= 1.0 for carrier in found)


def test_noise_is_carried_by_nothing_at_the_stated_rate() -> None:
    """One record of noise in twenty may name a coordinate: 1e-3 to fail at that rate."""
    records = 25
    smallest = []
    for seed in range(records):
        rng = np.random.default_rng([5, seed])
        noise = left_by_a_fit(rng.standard_normal(TIME.size))
        found = carriers(noise, SENSITIVITIES, ANGLE, COURSE, rng)
        smallest.append(min(carrier.p_value for carrier in found))
    assert np.sum(np.array(smallest) < 0.05) <= stats.binom.ppf(0.999, records, 0.05)


def test_temperature_carries_the_residual_of_a_rig_that_warms_up() -> None:
    """Each temperature is there once: it was said to carry nothing, with time carrying most."""
    warming = 20 + 5 * -np.expm1(-TIME / 30)
    loop = Loop(TORQUE, ANGLE, TIME, warming)
    course = record_course(loop, TorquePath.exact(TORQUE), 0.0)
    rng = np.random.default_rng(8)
    noisy = rng.standard_normal(TIME.size) + 1.5 * (warming - warming.mean()) / warming.std()
    found = carriers(left_by_a_fit(noisy), SENSITIVITIES, ANGLE, course, rng)
    by_name = {carrier.coordinate: carrier for carrier in found}
    assert by_name["temperature"].fraction > by_name["time"].fraction - 0.05 > 0.4
    assert by_name["temperature"].p_value < 0.05


@pytest.mark.parametrize("name", ["torque", "time", "temperature"])
def test_p_values_of_one_coordinate_are_as_rare_as_they_say(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On 50 records of noise, p at or below a rate no more often than that: 1e-3 a rate to fail."""
    features = residuals._features(COURSE, ANGLE)
    monkeypatch.setattr(residuals, "_features", lambda course, angle: {name: features[name]})
    found = []
    for seed in range(50):
        rng = np.random.default_rng([6, seed])
        noise = left_by_a_fit(rng.standard_normal(TIME.size))
        found += [one.p_value for one in carriers(noise, SENSITIVITIES, ANGLE, COURSE, rng)]
    for rate in (0.05, 0.2):
        assert np.sum(np.array(found) <= rate) <= stats.binom.ppf(0.999, 50, rate)


def test_short_serial_correlation_is_no_coordinate() -> None:
    """Noise with a memory of one reading: one record in twenty may name something, at most.

    1e-3 to fail at that rate over 20 records.
    """
    named = 0
    for seed in range(20):
        rng = np.random.default_rng([7, seed])
        noise, memory = rng.standard_normal(TIME.size), np.exp(-1.0)
        for index in range(1, TIME.size):
            noise[index] = memory * noise[index - 1] + np.sqrt(1 - memory**2) * noise[index]
        found = carriers(left_by_a_fit(noise), SENSITIVITIES, ANGLE, COURSE, rng)
        named += min(carrier.p_value for carrier in found) < 0.05
    assert named <= stats.binom.ppf(0.999, 20, 0.05)


def test_a_share_is_that_of_predictions_which_never_saw_the_fold() -> None:
    features = np.cos(np.pi * np.outer(np.linspace(0, 1, 47), np.arange(1, 6))) * 0.8
    residual = features @ np.array([1.0, -2.0, 0.5, 0.0, 1.0]) + np.sin(np.arange(47.0))
    folds, left = contiguous_folds(47), residual.copy()
    for fold in range(10):
        out, kept = folds == fold, folds != fold
        covariance = features[kept] @ features[kept].T + np.eye(int(kept.sum()))
        left[out] -= features[out] @ features[kept].T @ np.linalg.solve(covariance, residual[kept])
    expected = 1 - np.sum(left**2) / np.sum(residual**2)
    assert residuals._shares(features, folds, residual[None]) == pytest.approx(expected, rel=1e-12)
    assert expected > 0.5


def test_folds_are_contiguous_and_even() -> None:
    folds = contiguous_folds(47)
    assert (np.diff(folds) >= 0).all()
    assert np.bincount(folds).tolist() == [5, 5, 5, 4, 5, 5, 4, 5, 5, 4]
    assert contiguous_folds(30, 30).tolist() == list(range(30))


def cycles(count: int, density: int = 40) -> tuple[Course, FloatArray]:
    """Whole cycles to ± 50 Nm, and which stretch each reading is on."""
    corners = np.array([0.0, *(count * [50.0, -50.0]), 0.0])
    steps = np.linspace(0, corners.size - 1, density * (corners.size - 1) + 1)
    torque = np.interp(steps, np.arange(corners.size), corners)
    course = record_course(Loop(torque, torque), TorquePath.exact(torque), 0.0)
    stretch = np.repeat(np.arange(course.path.starts.size), course.path.ends - course.path.starts)
    return course, stretch


def test_repeatability_is_the_scatter_of_the_branches() -> None:
    course, stretch = cycles(4)
    torque = course.path.torque
    shifts = 1e-5 * np.array([0, 3.0, 1.0, 4.0, 1.5, 9.0, 2.0, 6.0, 0])
    # Whole falling branches are stretches 1, 3, 5 and 7, whole rising ones 2, 4 and 6.
    falling, rising = shifts[1:8:2], shifts[2:8:2]
    squares = np.sum((falling - falling.mean()) ** 2) + np.sum((rising - rising.mean()) ** 2)
    found = repeatability(course, torque / 1.5e4 + shifts[stretch], 0.0)
    assert found == pytest.approx(np.sqrt(squares / 5), rel=1e-9)


def test_a_record_that_repeats_exactly_and_one_that_does_not_repeat() -> None:
    course, _ = cycles(3)
    hysteresis = course.path.torque / 1.5e4 + 3e-5 * course.path.direction
    assert repeatability(course, hysteresis, 0.0) == pytest.approx(0.0, abs=1e-18)
    once, _ = cycles(1)
    assert repeatability(once, once.path.torque / 1.5e4, 0.0) is None
    # Small swings between are no whole branches.
    torque = np.concatenate(
        [np.linspace(0, 50, 41), np.linspace(49, 45, 15), np.linspace(46, 50, 15)]
    )
    minor = record_course(Loop(torque, torque), TorquePath.exact(torque), 0.0)
    assert repeatability(minor, torque / 1.5e4, 0.0) is None


def test_the_way_from_rest_is_no_cycle_that_fails_to_repeat() -> None:
    """A one-sided record begins on a whole branch that no later one takes."""
    torque = np.interp(np.linspace(0, 4, 401), np.arange(5), [0.0, 50.0, 0.0, 50.0, 0.0])
    course = record_course(Loop(torque, torque), TorquePath.exact(torque), 0.0)
    first = 5e-5 * (np.arange(401) < course.path.ends[0])
    assert repeatability(course, torque / 1.5e4 + first, 0.0) == pytest.approx(0.0, abs=1e-18)


@pytest.mark.parametrize("density", [40, 1200])
def test_repeatability_of_noise_is_its_size(density: int) -> None:
    """However densely the branches are read; 12 % are 4 standard errors at the least: 1e-4."""
    course, _ = cycles(6, density)
    rng = np.random.default_rng(8)
    noisy = course.path.torque / 1.5e4 + 1e-5 * rng.standard_normal(course.path.torque.size)
    assert repeatability(course, noisy, 1e-5) == pytest.approx(1e-5, rel=0.12)
