"""Effects that wear brings, followed as part of the drive's state."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from hdprog.inference.likelihood import COUNT
from hdprog.physics.figures import ARCMIN_PER_RAD, FigureRequest, figure
from hdprog.trend.figure_paths import figure_paths
from hdprog.trend.fitting import fit_trend
from hdprog.trend.followed_effects import FollowedEffects
from hdprog.trend.loop_evidence import FittedLoop, _with_all
from hdprog.trend.wear_prior import read_wear_prior
from tests.trend.friction_beside import (
    ALPHA,
    FRICTION,
    OPERATION,
    PRIOR,
    TRUTH,
    WIDEST,
    evidence,
    followed_by,
    likelihood,
)

WIDTH = FigureRequest("hysteresis_width_arcmin")


@pytest.mark.parametrize("own", [True, False])
def test_a_loop_from_another_process_has_a_followed_effect_once(own: bool) -> None:
    fitted = pickle.loads(pickle.dumps(likelihood(WIDEST, 1, with_friction=own)))
    shapes = [0.0] * (len(FRICTION.parameters(fitted.reduced.course.scales)) if own else 0)
    point = np.concatenate([TRUTH, [0.0], shapes])
    found, wider = _with_all(fitted, point, followed_by(likelihood(WIDEST, 1)))
    assert [effect.id for effect in found.effects] == ["coulomb_friction"]
    assert wider.size == found.size


@pytest.mark.parametrize("amplitude", [0.0, 0.05, 1.0])
def test_information_on_an_amplitude_is_that_of_the_exact_likelihood(amplitude: float) -> None:
    """Also where the effect is absent, which its own logarithmic coordinate cannot reach."""
    followed = followed_by(likelihood(0.0, 1))
    one = evidence(amplitude * WIDEST, 0.0, 3, followed)
    at = np.append(TRUTH, amplitude)
    found = one.linearise(at)
    near = np.append(TRUTH, amplitude + 0.1)
    gain = found.information @ (near - at) - 0.5 * (
        near @ found.precision @ near - at @ found.precision @ at
    )
    exact = one.linearise(near).log_likelihood - found.log_likelihood
    assert gain == pytest.approx(exact, rel=0.1, abs=0.5)
    assert np.linalg.eigvalsh(found.precision).min() > -1e-6


def test_the_likelihood_goes_on_below_an_amplitude_of_zero() -> None:
    """The residual is a straight line in the amplitude, so its square is a parabola."""
    one = evidence(0.3 * WIDEST, 0.0, 3, followed_by(likelihood(0.0, 1)))
    amplitudes = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    points = np.hstack([np.tile(TRUTH, (5, 1)), amplitudes[:, None]])
    own = np.tile(one.nuisances(points[2]).mean, (5, 1))
    squares = np.exp(-2 * one.log_likelihood(points, own) / one.likelihood.degrees)
    assert np.diff(squares, 2) == pytest.approx(np.diff(squares, 2)[0], rel=1e-6)
    assert squares[3] < squares[1]


def test_a_test_without_the_effect_says_that_its_amplitude_is_small() -> None:
    followed = followed_by(likelihood(0.0, 1))
    plain = likelihood(0.0, 5, with_friction=False)
    wider = evidence(0.0, 0.0, 5, followed)
    posterior = type("Posterior", (), {})()
    posterior.likelihood = plain
    posterior.points = np.append(TRUTH, 0.0)[None]
    posterior.coordinates = TRUTH[None]
    posterior.effect_values = {}
    posterior.noise_scale = np.ones(1)
    one = FittedLoop.of(posterior, 0.0, followed=followed)
    assert [effect.id for effect in one.likelihood.effects] == ["coulomb_friction"]
    assert one.posterior.shape == (1, COUNT + 1)
    at = np.append(TRUTH, 0.0)
    assert one.linearise(at).precision[-1, -1] == pytest.approx(
        wider.linearise(at).precision[-1, -1], rel=0.05
    )


def test_the_trend_follows_an_effect_that_grows_and_its_figures_hold_it() -> None:
    """A drive whose teeth do not wear, but whose friction grows in proportion to its hours."""
    followed = followed_by(likelihood(0.0, 1))
    hours = np.linspace(0, 1000, 6)
    tests = [
        evidence(WIDEST * hour / 1000, hour, number, followed) for number, hour in enumerate(hours)
    ]
    rng = np.random.default_rng(8)
    trend = fit_trend(
        tests, PRIOR, read_wear_prior(), rng, quick=True, alpha=ALPHA, followed=followed
    )
    paths = trend.paths(np.array([0.0, 500.0, 1000.0, 1500.0]), rng, 600)
    assert paths.shape[2] == COUNT + 1
    amplitude = paths[..., COUNT]
    low, high = np.quantile(amplitude, (0.05, 0.95), axis=0)
    true = np.array([0.0, 0.5, 1.0, 1.5])
    # Intervals are 90 %: a tenth of a unit of slack keeps this seed's draw inside.
    assert np.all(low - 0.1 < true)
    assert np.all(true < high + 0.1)
    own = float(figure(WIDTH, PRIOR.to_physical(TRUTH[None]), OPERATION)[0])
    widths = figure_paths(WIDTH, paths, PRIOR, OPERATION, followed)
    expected = own + ARCMIN_PER_RAD * WIDEST * true
    low, high = np.quantile(widths, (0.05, 0.95), axis=0)
    slack = 0.1 * ARCMIN_PER_RAD * WIDEST
    assert np.all(low - slack < expected)
    assert np.all(expected < high + slack)
    assert np.all(np.diff(np.median(widths, axis=0)) > 0.1)
    # Without it the same paths have a width that hardly moves.
    alone = np.median(figure_paths(WIDTH, paths, PRIOR, OPERATION), axis=0)
    assert np.ptp(alone[:3]) < 0.3 * np.ptp(np.median(widths, axis=0)[:3])


def test_a_positive_amplitude_stays_positive_in_figures() -> None:
    followed = followed_by(likelihood(0.0, 1))
    lasting = followed.lasting(np.array([[-0.5], [0.5]]))
    np.testing.assert_allclose(lasting.values["coulomb_friction"]["width"][:, 0], [0.0, 1e-4])


def test_units_are_the_largest_found_and_shapes_the_last() -> None:
    scales = likelihood(0.0, 1).reduced.course.scales

    def found(width: float, slip: float) -> dict[str, dict[str, np.ndarray]]:
        values = {"width": width, "slip_torque": slip, "initial_state": 0.0}
        return {"coulomb_friction": {key: np.array([[value]]) for key, value in values.items()}}

    tests = [
        (scales, {}),
        (scales, found(3e-4, 1.0)),
        (replace(scales, torque=50.0), found(2e-4, 2.0)),
        (scales, {}),
    ]
    followed = FollowedEffects.of((FRICTION,), tests)
    assert followed.units == {("coulomb_friction", "width"): 3e-4}
    assert followed.values["coulomb_friction", "slip_torque"] == 2.0
    assert followed.scales.torque == 50.0
