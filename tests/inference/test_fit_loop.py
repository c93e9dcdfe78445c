"""Posteriors of whole loops: known truth, an independent simulator, and measured records."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.readers import read_loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.posterior import Posterior
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import FULL, QUICK, SamplingPlan
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.physics.drive_model import predict
from hdprog.physics.parameters import NAMES
from tests.independent.loops import KINDS, random_loop
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)


def worn_loop(spike_share: float = 0.0, samples: int = 100) -> Loop:
    rng = np.random.default_rng(12)
    quarter = np.linspace(0, 80, samples)
    torque = np.concatenate([quarter, quarter[-2::-1], -quarter[1:], -quarter[-2::-1]])
    angle = predict(torque, POST_TEST) + 1e-5 * rng.standard_normal(torque.size)
    spiked = rng.random(torque.size) < spike_share
    angle[spiked] += 4e-4 * rng.choice([-1, 1], spiked.sum())
    return Loop(torque=torque, angle=angle)


def fitted(loop: Loop, plan: SamplingPlan = QUICK, seed: int = 0) -> Posterior:
    return fit_loop(loop, DRIVE, np.random.default_rng(seed), prior=PRIOR, plan=plan)


@pytest.fixture(scope="module")
def worn() -> Posterior:
    return fitted(worn_loop())


def test_table_2_is_recovered(worn: Posterior) -> None:
    assert worn.converged
    truth = {name: np.asarray(value) for name, value in POST_TEST.items()}
    deviation = worn.coordinates.mean(axis=0) - coordinates_of(PRIOR, truth)
    # 3.5 posterior standard deviations: false alarm 4e-3 over eight parameters.
    assert (np.abs(deviation) < 3.5 * worn.coordinates.std(axis=0)).all()
    assert worn.diagnostics.rhat.max() < 1.01
    assert min(worn.diagnostics.ess_bulk.min(), worn.diagnostics.ess_tail.min()) >= 400
    assert min(worn.contraction[name] for name in ("K_F", "K_W", "a", "b", "T_T")) > 0.9


def test_same_seed_same_draws(worn: Posterior) -> None:
    np.testing.assert_array_equal(fitted(worn_loop()).coordinates, worn.coordinates)


def test_a_few_draws_far_away_leave_the_error_of_the_fit_as_it_is(worn: Posterior) -> None:
    chains = worn.chains.copy()
    chains[:, :, ::5, 0] -= 2.0  # a cup of an eighth of the stiffness in a fifth of the draws
    spoilt = replace(worn, chains=chains)
    assert spoilt.parameters["K_F"].min() < 0.2 * worn.parameters["K_F"].min()
    before, after = (np.sqrt(np.mean(one.record_residual**2)) for one in (worn, spoilt))
    assert after == pytest.approx(before, rel=0.1)


def test_spikes_hardly_move_the_figures(worn: Posterior) -> None:
    spiked = fitted(worn_loop(spike_share=0.02))
    assert spiked.outlier_fraction == pytest.approx(0.02, abs=0.012)
    requests = figure_requests(DRIVE, worn.operation)
    clean, hit = worn.figures(requests), spiked.figures(requests)
    for key, values in clean.items():
        # 0.2 SD, and as much again for the readings that are missing and Monte-Carlo error.
        assert abs(hit[key].mean() - values.mean()) < 0.4 * values.std(), key


TOO_SHORT = replace(
    QUICK, warm_up_steps=(10, 10, 10), first_steps=10, most_steps=40, further_steps=0, refits=0
)


def test_a_bound_that_is_too_short_is_marked() -> None:
    posterior = fitted(worn_loop(), TOO_SHORT)
    assert not posterior.converged
    assert "did not converge" in posterior.warnings[0]


def test_further_steps_are_taken_where_the_bound_is_too_short() -> None:
    posterior = fitted(worn_loop(), replace(TOO_SHORT, further_steps=4000))
    assert posterior.converged
    assert posterior.sampling["warm_up_steps"] + posterior.sampling["steps"] > 40


def test_blind_loops_of_an_independent_simulator() -> None:
    """90 % intervals of the parameters over loops of every kind."""
    held = count = 0
    for number in range(10):
        rng = np.random.default_rng([21, number])
        record = random_loop(rng, KINDS[number % len(KINDS)], samples=400)
        posterior = fitted(Loop(torque=record.torque, angle=record.angle, time=record.time))
        for name in NAMES:
            share = (posterior.parameters[name] < record.truth["parameters"][name]).mean()
            held += 0.05 < share < 0.95
            count += 1
    # Parameters of one loop go together: as if about 40 were independent. One in a thousand.
    low = stats.binom.ppf(0.001, 40, 0.9) / 40
    assert held / count >= low


def test_long_record_gives_the_posterior_of_its_readings() -> None:
    """36 000 readings reduced: the truth is where it says, and tighter than from 400."""
    rng = np.random.default_rng(5)
    quarter = np.linspace(0, 80, 9000)
    torque = np.concatenate([quarter, quarter[-2::-1], -quarter[1:], -quarter[-2::-1]])
    angle = predict(torque, POST_TEST) + 1e-5 * rng.standard_normal(torque.size)
    noisy = torque + 0.03 * rng.standard_normal(torque.size)
    posterior = fitted(Loop(torque=noisy, angle=angle))
    assert posterior.likelihood.blocks <= 800  # however long it is
    truth = coordinates_of(PRIOR, POST_TEST)
    spread = posterior.coordinates.std(axis=0)
    assert (np.abs(posterior.coordinates.mean(axis=0) - truth) < 4 * spread).all()
    assert spread[3] < 0.01


MEASURED = {
    "torsion-spring/kt-4-7-55-5-09032023-142108.csv.gz": (
        {"torque": "torque_out:Nm", "angle": "displacement:deg", "time": "time:s"},
        None,
    ),
    "cycloidal-torque-ramps/base_runin1.csv.gz": (
        {"torque": "TORQUE:Nm", "angle": "POSITION:rev", "time": "TIME:s"},
        {"test_nr": ("100", "101", "102")},
    ),
}


@pytest.mark.measured
@pytest.mark.parametrize("name", MEASURED)
def test_measured_records(name: str, measured_data: Path) -> None:
    columns, select = MEASURED[name]
    loop = read_loop(measured_data / name, columns=columns, select=select)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        posterior = fit_loop(loop, Drive.default(), np.random.default_rng(0), plan=FULL)
    assert posterior.prior.name == "generic"
    assert any("centred on the record" in text for text in posterior.warnings)
    result = summarise(posterior, figure_requests(posterior.drive, posterior.operation), "x", {})
    assert posterior.converged
    # The base model leaves more than the noise: the white model must have been given up.
    assert result.rmse_rad > 1.5 * result.noise_floor_rad
    assert "Ornstein-Uhlenbeck" in result.noise_model
