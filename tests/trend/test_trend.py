"""The trend as a whole on simulated loops."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.errors import BadInputError
from hdprog.forecast.crossing import forecast
from hdprog.physics.figures import FigureRequest, Operation
from hdprog.physics.parameters import NAMES
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.summary import not_reproduced, summarise
from hdprog.trend.trend import Trend
from hdprog.trend.wear_coordinates import from_loop, linearise, to_loop
from hdprog.trend.wear_prior import read_wear_prior
from tests.hasty import HASTY
from tests.trend.stand_in import ALPHA, NEW, PRIOR, WEAR, SimulatedLoop, wearing_drive

OPERATION = Operation(ALPHA, 63.0, 63.0)
SECANT = FigureRequest("secant_stiffness_Nm_per_rad", 14.0)
WIDTH = FigureRequest("hysteresis_width_arcmin")
LIMITS = (
    Limit("secant_stiffness_Nm_per_rad", 12_000.0, "below", 14.0),
    Limit("lost_motion_arcmin", 2.5, "above"),
)
HOURS = np.array([0.0, 700.0, 1500.0, 2200.0, 3000.0])
REACHED = (HOURS / 4000.0) ** 0.8
MU = NAMES.index("mu")


@pytest.fixture(scope="module")
def tests() -> list[SimulatedLoop]:
    return wearing_drive(np.random.default_rng(1), REACHED, HOURS)


@pytest.fixture(scope="module")
def trend(tests: list[SimulatedLoop]) -> Trend:
    return fit_trend(tests, PRIOR, read_wear_prior(), np.random.default_rng(2), quick=True)


def hasty_trend(tests: list[SimulatedLoop], seed: int) -> Trend:
    """For what the modes and the hyperparameters show before all loops are sampled together."""
    rng = np.random.default_rng(seed)
    return fit_trend(tests, PRIOR, read_wear_prior(), rng, quick=True, joint_effort=HASTY)


def test_it_converges_and_covers_the_true_course(trend: Trend) -> None:
    """Five figures inside their central 99.8 %: one false alarm in 100."""
    assert trend.converged
    truth = figure_paths(SECANT, NEW + WEAR * REACHED[:, None], PRIOR, OPERATION)
    paths = trend.paths(HOURS, np.random.default_rng(3), 4000)
    values = figure_paths(SECANT, paths, PRIOR, OPERATION)
    low, high = np.quantile(values, [0.001, 0.999], axis=0)
    assert np.all((low < truth) & (truth < high))
    # A hundredth of remounting scatter leaves a course known to a few per cent, not worse.
    assert np.all(values.std(axis=0) < 0.05 * truth)


def test_seed_and_tests_tell_every_number_and_not_their_order(tests: list[SimulatedLoop]) -> None:
    found = []
    for given, elsewhere in ((tests[:3], 0), (tests[2::-1], 123)):
        np.random.seed(elsewhere)  # noqa: NPY002 - emcee must not listen to it
        rng = np.random.default_rng(2)
        found.append(
            fit_trend(given, PRIOR, read_wear_prior(), rng, quick=True, joint_effort=HASTY)
        )
    first, again = found
    assert np.array_equal(again.draws.chains, first.draws.chains)
    later = np.array([1500.0, 4000.0])
    paths = [one.paths(later, np.random.default_rng(4), 50) for one in found]
    assert np.array_equal(*paths)


def test_a_gear_that_is_worn_out_does_not_heal(trend: Trend) -> None:
    """Far past the end of wear, friction does not grow until the loop is as wide as when new."""
    paths = trend.paths(np.array([3e3, 1e5, 1e6, 1e7, 1e8]), np.random.default_rng(9), 4000)
    width = np.median(figure_paths(WIDTH, paths, PRIOR, OPERATION), axis=0)
    mu = np.exp(np.median(paths[..., MU], axis=0))
    assert width[-1] == pytest.approx(width[-2], rel=0.05)
    assert np.all(width[1:] < width[0])
    assert mu[-1] < 1.5 * mu[0]


def test_the_summary_is_complete(trend: Trend) -> None:
    drive = Drive(rated_torque=63.0, limits=LIMITS, forecast=ForecastSettings(9000.0))
    summary = summarise(trend, drive, OPERATION, np.random.default_rng(5))
    assert {limit.key for limit in LIMITS} <= set(summary.figures)
    followed = summary.figures[SECANT.key]
    assert followed.hours[0] == 0.0
    assert followed.hours[-1] == 9000.0
    assert followed.quantiles.shape == (5, followed.hours.size)
    assert followed.test_quantiles.shape == (5, 5)
    assert np.all(np.diff(followed.quantiles, axis=0) >= 0)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_tests_give_a_wide_forecast_and_say_so(
    tests: list[SimulatedLoop], trend: Trend, count: int
) -> None:
    few = hasty_trend(tests[:count], 6)
    assert any("test" in warning for warning in few.warnings)
    drive = Drive(rated_torque=63.0, limits=LIMITS, forecast=ForecastSettings(60_000.0))
    narrow = forecast(trend, drive, OPERATION, np.random.default_rng(7))[0]
    wide = forecast(few, drive, OPERATION, np.random.default_rng(7))[0]
    assert wide.remaining_hours[0.5] is not None
    ratio = [
        (found.remaining_hours[0.5] or np.inf) / (found.remaining_hours[0.05] or 1.0)
        for found in (wide, narrow)
    ]
    assert ratio[0] > ratio[1]
    if count == 1:
        assert "wear_rate" in few.carried_by_prior()


def test_equal_hours_and_a_regreasing(tests: list[SimulatedLoop]) -> None:
    """A jump of friction goes to the break, all at once; without the event it would not."""
    jump = 0.4 * np.eye(8)[MU]
    changed = _with(REACHED[[2, 2, 4]], jump, np.random.default_rng(8))
    after = [
        dataclasses.replace(test, angle=other.angle, service_hours=hours)
        for test, other, hours in zip(tests[2:], changed, (1500.0, 1500.0, 3000.0), strict=True)
    ]
    after[0] = dataclasses.replace(after[0], event="regreased")
    both = [*tests[:2], *after]
    around, width = np.array([1499.9, 1500.0]), FigureRequest("hysteresis_width_arcmin")
    true = np.stack([NEW + WEAR * REACHED[2], NEW + WEAR * REACHED[2] + jump])
    truth = np.diff(np.log(figure_paths(width, true, PRIOR, OPERATION)))[0]
    found = []
    for event in ("regreased", None):
        both[2] = dataclasses.replace(both[2], event=event)
        fitted = hasty_trend(both, 9)
        paths = fitted.paths(around, np.random.default_rng(10), 1000)
        found.append(np.diff(np.log(figure_paths(width, paths, PRIOR, OPERATION))).mean())
    assert found[0] == pytest.approx(truth, abs=0.08)
    assert abs(found[1]) < 0.05


def _with(reached: np.ndarray, added: np.ndarray, rng: np.random.Generator) -> list[SimulatedLoop]:
    return [wearing_drive(rng, np.array([wear]), np.zeros(1), offset=added)[0] for wear in reached]


def test_a_replaced_drive_starts_anew(tests: list[SimulatedLoop]) -> None:
    """The forecast starts from the new drive's state, and its hours from the replacement."""
    rng = np.random.default_rng(12)
    new = wearing_drive(rng, np.array([0.0, 0.1]), np.array([3200.0, 3600.0]))
    new[0] = dataclasses.replace(new[0], event="replaced")
    trend = hasty_trend([*tests, *new], 13)
    stiff = figure_paths(
        SECANT, trend.paths(np.array([3000.0, 3600.0]), rng, 1000), PRIOR, OPERATION
    )
    truth = figure_paths(
        SECANT, np.stack([NEW + WEAR * REACHED[-1], NEW + WEAR * 0.1]), PRIOR, OPERATION
    )
    assert stiff.mean(axis=0) == pytest.approx(truth, rel=0.05)
    assert any("replaced" in warning for warning in trend.warnings)


@pytest.mark.parametrize(
    "broken", [{"service_hours": -1.0}, {"service_hours": float("nan")}, {"event": "painted"}]
)
def test_impossible_tests_are_refused(tests: list[SimulatedLoop], broken: dict) -> None:
    wrong = dataclasses.replace(tests[0], **broken)
    with pytest.raises(BadInputError):
        fit_trend([wrong], PRIOR, read_wear_prior(), np.random.default_rng(0))
    with pytest.raises(BadInputError):
        fit_trend([], PRIOR, read_wear_prior(), np.random.default_rng(0))


def test_wear_coordinates_are_one_to_one() -> None:
    points = PRIOR.sample(200, np.random.default_rng(14))
    assert np.allclose(to_loop(from_loop(points)), points, atol=1e-8)


def test_the_likelihood_in_wear_coordinates_has_the_slope_of_the_loops_own(
    tests: list[SimulatedLoop],
) -> None:
    point = from_loop(NEW + 0.5 * WEAR)
    found = linearise(tests[2], point)
    slope = found.information - found.precision @ point
    step = 1e-5
    for index in range(8):
        moved = step * np.eye(8)[index]
        ends = to_loop(np.stack([point + moved, point - moved]))
        numeric = -np.diff(tests[2].log_likelihood(ends))[0] / (2 * step)
        assert slope[index] == pytest.approx(numeric, rel=1e-3, abs=1.0)


def test_a_figure_that_the_trend_misses_is_named() -> None:
    rng = np.random.default_rng(15)
    own = [rng.normal(10.0, 1.0, 500), rng.normal(12.0, 1.0, 500)]
    right = np.column_stack([rng.normal(10.1, 0.7, 500), rng.normal(11.7, 0.7, 500)])
    assert not_reproduced("figure", own, right) == ()
    moved, wide = right + np.array([0.0, 5.0]), right.copy()
    wide[:, 0] = rng.normal(10.0, 5.0, 500)
    (found,) = not_reproduced("figure", own, moved)
    assert (found.tests, found.worst) == ((1,), 1)
    assert found.joint == pytest.approx(tuple(np.quantile(moved[:, 1], [0.05, 0.5, 0.95])))
    assert found.alone == pytest.approx(tuple(np.quantile(own[1], [0.05, 0.5, 0.95])))
    assert not_reproduced("figure", own, wide)[0].tests == (0,)
