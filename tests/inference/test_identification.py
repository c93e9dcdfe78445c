"""What a record leaves to the prior: a threshold at zero, a load below the preload torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.identification import (
    combined_stiffness,
    identification,
    no_load_friction,
    prior_points,
)
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import scales_of
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.physics.drive_model import predict
from hdprog.physics.parameters import NAMES
from hdprog.reporting.weak_words import weak_words
from hdprog.results import TestResult
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)
NEW = POST_TEST | {
    "b": 1 / (1 / 50923.2 - 1 / 78197.8),
    "T_T": 0.0,
    "K_W": 101837.5,
    "c": -1.177,
    "T_i": 115.5,
    "mu": 0.066,
}


def loop_to(largest: float, truth: dict[str, float], seed: int = 1) -> Loop:
    rng = np.random.default_rng(seed)
    quarter = np.linspace(0, largest, 100)
    torque = np.concatenate([quarter, quarter[-2::-1], -quarter[1:], -quarter[-2::-1], quarter[1:]])
    return Loop(torque=torque, angle=predict(torque, truth) + 1e-5 * rng.standard_normal(496))


def fitted(loop: Loop, **prior_sd: float) -> Posterior:
    """Posterior with some of the prior's standard deviations replaced."""
    sd = np.array([prior_sd.get(name, PRIOR.sd[index]) for index, name in enumerate(NAMES)])
    prior = replace(PRIOR, sd=sd)
    return fit_loop(loop, DRIVE, np.random.default_rng(0), prior=prior, plan=QUICK)


def summary(posterior: Posterior) -> TestResult:
    return summarise(posterior, figure_requests(DRIVE, posterior.operation), "t01", {})


def test_combined_stiffness_is_that_of_the_paper_where_the_threshold_is_zero() -> None:
    found = combined_stiffness({name: np.asarray(value) for name, value in NEW.items()})
    assert found == pytest.approx(50923.2)
    assert no_load_friction({n: np.asarray(v) for n, v in NEW.items()}) == pytest.approx(8.972271)


def test_points_of_a_prior_have_its_moments() -> None:
    found = coordinates_of(PRIOR, prior_points(PRIOR))
    np.testing.assert_allclose(found.mean(axis=0), PRIOR.mean, atol=0.02 * PRIOR.sd.max())
    np.testing.assert_allclose(found.std(axis=0), PRIOR.sd, rtol=0.02)


def test_a_new_drive_is_one_spring() -> None:
    posterior = fitted(loop_to(100.0, NEW))
    state, said = identification(posterior), weak_words(summary(posterior))
    assert state.one_spring
    assert posterior.contraction["a"] < 0.15
    # 90 % interval widened to 4 standard deviations: false alarm 6e-5.
    levels = state.combined_stiffness.quantiles
    spread = (levels[0.95] - levels[0.05]) / 3.29
    assert abs(levels[0.50] - 50923.2) < 4 * spread
    assert state.combined_stiffness.contraction > 0.999
    # Its parts are a hundred times wider.
    assert np.log(posterior.parameters["b"]).std() > 100 * spread / 50923.2
    assert any("one spring" in text for text in said)


def test_below_the_preload_torque_only_the_product_is_known() -> None:
    """With c and mu wide open in the prior, the product tells nothing of a narrow T_i."""
    posterior = fitted(loop_to(30.0, NEW), T_i=0.15, c=1.0, mu=1.0)
    state, result = identification(posterior), summary(posterior)
    assert state.beyond_record > 0.99
    assert abs(posterior.contraction["T_i"]) < 0.1
    assert state.no_load_friction.contraction > 0.99
    levels = state.no_load_friction.quantiles
    assert abs(levels[0.50] - 8.972271) < 4 * (levels[0.95] - levels[0.05]) / 3.29
    assert result.sensitivity["T_i"].diagnosis in ("prior", "shared")
    assert result.sensitivity["T_i"].prior > 0.05
    said = weak_words(result)
    assert any("says nothing of T_i" in text and "the prior's" in text for text in said)
    assert any("stayed below the preload torque" in text for text in said)


def test_a_worn_drive_loaded_past_its_preload_torque_leaves_nothing_to_the_prior() -> None:
    result = summary(fitted(loop_to(100.0, POST_TEST)))
    assert result.identification is not None
    assert not result.identification.one_spring
    assert result.identification.beyond_record < 0.01
    assert {found.diagnosis for found in result.sensitivity.values()} == {"record"}
    assert weak_words(result) == []


def test_one_wrong_reading_says_nothing_of_the_record() -> None:
    """Neither of its error, nor of its largest torque, nor where a generic prior lies."""
    clean = loop_to(70.0, POST_TEST)
    torque, angle = clean.torque.copy(), clean.angle.copy()
    torque[200], angle[320] = 600.0, 0.05
    spoilt = replace(clean, torque=torque, angle=angle)
    found, wanted = scales_of(spoilt), scales_of(clean)
    assert found.largest_torque == pytest.approx(wanted.largest_torque)
    assert found.secant_stiffness == pytest.approx(wanted.secant_stiffness, rel=1e-3)
    posterior = fitted(spoilt)
    assert identification(posterior).largest_torque == pytest.approx(70.0)
    assert summary(posterior).rmse_rad < 1.3 * posterior.noise_floor
