"""The empirical term: found over the coordinate that carries it, and not on clean loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg, optimize, stats

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.discovery.candidates import refits, without
from hdprog.discovery.empirical import with_unknown
from hdprog.discovery.found import _without as without_effect
from hdprog.discovery.model import Model, gain_of_curve
from hdprog.discovery.pooling import THRESHOLD
from hdprog.discovery.search import base_model
from hdprog.discovery.unknown import TERM_PENALTY, _Evidence, _Tangent, term_gains, with_term
from hdprog.inference.prepare import prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.smooth_term import LENGTHS, basis_of, spectrum
from hdprog.inference.starting_points import descend_all
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID
from hdprog.physics.parameters import FloatArray
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)
NOISE = 1e-5
TIME = np.linspace(0.0, 100.0, 193)
TORQUE = np.interp(TIME, [0, 12.5, 37.5, 62.5, 87.5, 100], [0, 80, -80, 80, -80, 0])
RISING = np.gradient(TORQUE) > 0

# Courses that no change of the drive's parameters can imitate.
CURVES: dict[str, FloatArray] = {
    "time": 6e-5 * np.sin(2 * np.pi * TIME / 20) * np.exp(-0.5 * ((TIME - 55) / 20) ** 2),
    "torque": 4e-5 * np.cos(2 * np.pi * TORQUE / 64),
    "branch": 5e-5 * np.sin(2 * np.pi * TORQUE / 70) * RISING,
}


def modelled(curve: FloatArray, seed: int) -> Model:
    rng = np.random.default_rng(seed)
    angle = predict(TORQUE, POST_TEST) + curve + NOISE * rng.standard_normal(TIME.size)
    prepared = prepare(Loop(TORQUE, angle, TIME), DRIVE, rng, prior=PRIOR)
    return base_model(prepared, rng)


def centred(values: FloatArray) -> FloatArray:
    return values - values.mean()


def fitted(model: Model) -> FloatArray:
    """What drive and empirical term make of the angle, its mean taken out."""
    likelihood = model.likelihood
    drive = likelihood.angle(model.start.point[None, :])[0]
    left = likelihood.reduced.angle - drive
    return centred(drive + likelihood.noise.smooth_part(left - likelihood.offset(left)))


@pytest.mark.parametrize("coordinate", CURVES)
def test_a_planted_curve_is_recovered(coordinate: str) -> None:
    """Over its own coordinate, and to less than the noise of a reading."""
    curve = CURVES[coordinate]
    model = modelled(curve, seed=4)
    gains = term_gains(model)
    best = max(gains, key=lambda name: gains[name].gain)
    assert best == coordinate
    assert gains[best].gain > 2 * THRESHOLD
    wider = with_term(model, gains[best], np.random.default_rng(1))
    assert wider.term is not None
    assert wider.term.coordinate == coordinate
    assert wider.log_evidence > model.log_evidence + THRESHOLD
    truth = centred(predict(TORQUE, POST_TEST) + curve)
    # Parameters and term share what both can imitate: together they must be right.
    assert np.std(fitted(wider) - truth) < 0.6 * NOISE
    assert np.std(fitted(model) - truth) > 1.5 * NOISE
    assert np.std(wider.residual) < 1.1 * NOISE


def test_a_curve_that_led_the_drive_model_astray_is_found_over_its_coordinate() -> None:
    """The fit without it lies far off: a descent from there stays behind by tens of log evidence.

    So does what the linearised model says of the term.
    """
    model = modelled(1e-4 * np.cos(2 * np.pi * TORQUE / 45 + 1.5), seed=5)
    gains = term_gains(model)
    assert gains["branch"].gain > gains["torque"].gain
    found = with_unknown([model], [model], [gains], [np.random.default_rng(1)], map)[0]
    assert found.term is not None
    assert found.term.coordinate == "torque"
    truth = coordinates_of(PRIOR, POST_TEST)
    nearby = descend_all(found.likelihood, [np.append(truth, 0.0)])
    from_truth = Model(found.likelihood, tuple(nearby)).log_evidence
    assert found.log_evidence > from_truth - 1.0
    stayed = descend_all(found.likelihood, [model.start.point])
    assert Model(found.likelihood, tuple(stayed)).log_evidence < from_truth - 10.0


def test_a_terms_covariance_is_averaged_over_sizes_and_lengths() -> None:
    """By their likelihoods from dense covariances of the readings, the noise's scale profiled."""
    model = modelled(CURVES["torque"] / 4, seed=4)
    sd = model.likelihood.noise.white_sd
    likelihood = replace(model.likelihood, noise=model.likelihood.noise.as_white)
    tangent = _Tangent.of(likelihood, model)
    ones = (1 / sd) / np.linalg.norm(1 / sd)
    outside = linalg.null_space(ones[None, :])  # the offset is integrated out
    basis = basis_of("torque", -80.0, 80.0, likelihood.reduced.course)
    drive = outside.T @ tangent.own
    data = outside.T @ tangent.data

    def seen(size: float, length: float) -> tuple[float, float]:
        shape = outside.T @ (basis / sd[:, None] * spectrum(length)) * np.median(sd)
        inner = np.eye(data.size) + np.exp(2 * size) * shape @ shape.T

        def deviance(log_variance: float) -> float:
            factor = linalg.cho_factor(np.exp(log_variance) * inner + drive @ drive.T)
            log_det = 2 * np.log(np.diag(factor[0])).sum()
            return float(data @ linalg.cho_solve(factor, data) + log_det)

        best = optimize.minimize_scalar(deviance, bounds=(-2.0, 3.0), method="bounded")
        return -0.5 * best.fun, float(np.exp(best.x))

    sizes = np.arange(-4.0, 7.6, 0.5)  # half as many as are averaged over
    marginal, variance = np.moveaxis(
        np.array([[seen(size, length) for size in sizes] for length in LENGTHS]), -1, 0
    )
    weight = np.exp(marginal - marginal.max()) * variance
    shapes = np.array([spectrum(length) ** 2 for length in LENGTHS])
    each = weight @ np.exp(2 * sizes) * np.median(sd) ** 2
    wanted = np.sqrt(each @ shapes / weight.sum())
    np.testing.assert_allclose(tangent.averaged(basis), wanted, rtol=0.03)
    # No one size and length has it all.
    assert weight.max() < 0.4 * weight.sum()


def test_a_gain_is_what_the_refit_gains_whichever_noise_it_is_held_against() -> None:
    """Correlated noise takes much of a slow drift and a line over; white noise leaves it bare."""
    line = 4e-5 * np.sin(2 * np.pi * TIME / 13) * (1 + 0.4 * np.cos(2 * np.pi * TIME / 6))
    model = modelled(line - 4e-4 * (1 - np.exp(-TIME / 50)), seed=4)
    assert model.likelihood.noise.log_ratio is not None
    gains = term_gains(model)
    best = max(gains, key=lambda name: gains[name].gain)
    assert best == "time"
    assert gains[best].white
    wider = with_term(model, gains[best], np.random.default_rng(1))
    gained = gain_of_curve(model, wider)
    assert model.doubt > wider.doubt
    assert gains[best].gain == pytest.approx(gained - TERM_PENALTY, abs=2.0)


def test_nothing_is_gained_on_clean_loops() -> None:
    """At most one clean loop in twenty may pass the threshold; 1e-3 to fail at that rate."""
    loops = 12
    best = []
    for seed in range(loops):
        gains = term_gains(modelled(np.zeros(TIME.size), seed=100 + seed))
        best.append(max(found.gain for found in gains.values()))
    assert sum(gain > THRESHOLD for gain in best) <= stats.binom.ppf(0.999, loops, 0.05)
    # Nor does a typical one come near it.
    assert np.median(best) < 0.0


def test_a_record_without_time_has_no_term_over_time() -> None:
    rng = np.random.default_rng(5)
    angle = predict(TORQUE, POST_TEST) + CURVES["time"] + NOISE * rng.standard_normal(TIME.size)
    prepared = prepare(Loop(TORQUE, angle), DRIVE, rng, prior=PRIOR)
    gains = term_gains(base_model(prepared, rng))
    # Its cycles repeat: a term over the order would explain how they differ from each other.
    assert not {"time", "order"} & set(gains)


@pytest.mark.parametrize("ratio", [0.0, 0.25, 1600.0])
def test_the_evidence_is_the_density_of_the_data(ratio: float) -> None:
    """Against the dense covariance, columns of very different strength included."""
    rng = np.random.default_rng(8)
    own = rng.standard_normal((60, 4)) * [1.0, 10.0, 100.0, 1000.0]
    smooth = rng.standard_normal((60, 7)) * np.logspace(0, -3, 7)
    data = own @ rng.standard_normal(4) + rng.standard_normal(60)

    def dense(variance: float) -> float:
        covariance = variance * (np.eye(60) + ratio * smooth @ smooth.T) + own @ own.T
        return float(stats.multivariate_normal(cov=covariance).logpdf(data))

    found, variance = _Evidence(own, smooth, data).at_best_noise(np.array([ratio]), 3.0)
    assert found[0] - 30 * np.log(2 * np.pi) == pytest.approx(dense(variance[0]), abs=1e-6)
    # No other noise is likelier.
    assert dense(variance[0]) > max(dense(0.98 * variance[0]), dense(1.02 * variance[0]))


def test_what_a_mechanism_gains_beside_a_curve_is_not_the_curve_again() -> None:
    model = modelled(CURVES["torque"] + 1e-4 * (TIME > 40.0), 5)
    rng = np.random.default_rng(5)
    jumping = refits(model, [BY_ID["slip_jump"]])["slip_jump"]
    final = with_term(jumping, term_gains(jumping)["torque"], rng)
    fewer = without_effect(final, "slip_jump", rng)
    assert fewer.ids == ()
    assert fewer.term is not None
    assert fewer.term.coordinate == "torque"
    neither = without(final, "slip_jump", rng)
    curve = final.log_evidence - jumping.log_evidence
    told = final.log_evidence - fewer.log_evidence
    assert curve > 10.0
    assert 10.0 < told < final.log_evidence - neither.log_evidence - 15.0
