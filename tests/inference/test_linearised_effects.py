"""Draws of linearised effects follow the exact density where their weights hold, and say if not."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from hdprog.config import Drive
from hdprog.data.coordinates import record_course
from hdprog.data.loop import Loop
from hdprog.inference import fit_loop, linearised_effects
from hdprog.inference.effect_starts import effect_starts
from hdprog.inference.fit_loop import sample_posterior
from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.linearised_effects import PARETO_K_LIMIT, EffectDraws, LinearisedEffects
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare
from hdprog.inference.prior_file import read_prior_file
from hdprog.inference.sampling_plan import QUICK
from hdprog.inference.starting_points import StartingPoint, describe
from hdprog.physics.course import Course, Scales
from hdprog.physics.drive_model import predict
from hdprog.physics.effects.backlash import Backlash
from hdprog.physics.effects.base import EffectParameter, Values
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath
from tests.inference.inverse import coordinates_of
from tests.physics.table2 import POST_TEST

DRIVE = replace(Drive.default(), model="CSF-25-80", rated_torque=63.0, alpha_declared=True)
PRIOR = read_prior_file("csf-25-80").prior(None)
NOISE = 1e-5
DRAWS, GROUPS = 8000, 4


class CentredPlay(Backlash):
    """Play about zero torque: two coordinates, which a grid can hold."""

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        return super().parameters(scales)[:2]

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        return super().evaluate(course, {**values, "centre": np.zeros((1, 1))}, angle)


BACKLASH = CentredPlay()


def likelihood_with(play: float) -> tuple[LoopLikelihood, FloatArray]:
    """Of a record with so much backlash in rad, and the true point but for the backlash."""
    rng = np.random.default_rng(2)
    torque = np.interp(np.linspace(0, 4, 121), range(5), (0.0, 80.0, -80.0, 80.0, -80.0))
    course = record_course(Loop(torque, torque / 1.5e4), TorquePath.exact(torque), 0.0)
    drive = {key: np.array([value]) for key, value in POST_TEST.items()}
    values = {"backlash": {"play": np.array([[play]]), "width": np.array([[0.7]])}}
    effects = EffectSet((BACKLASH,), course.scales)
    angle = effects.angle(course, drive, values, math.radians(30), np.array([0.5]))[0]
    loop = Loop(torque, angle + NOISE * rng.standard_normal(torque.size))
    likelihood = replace(prepare(loop, DRIVE, rng, prior=PRIOR).likelihood, effects=(BACKLASH,))
    exact = coordinates_of(PRIOR, POST_TEST)
    return likelihood, np.concatenate([exact, [0.0]])


def on_a_grid(
    likelihood: LoopLikelihood, drive: FloatArray, play: float, scale: float
) -> tuple[FloatArray, FloatArray]:
    """Coordinates (n, 2) of the backlash, and their log density (n,), the drive's given."""
    about = BACKLASH.parameters(likelihood.reduced.course.scales)[0].coordinate(play)
    plays, widths = np.linspace(about - 0.2, about + 0.2, 401), np.linspace(-4.5, 4.5, 121)
    grid = np.stack(np.meshgrid(plays, widths), axis=-1).reshape(-1, 2)
    points = np.hstack([np.tile(drive, (len(grid), 1)), grid])
    squares = np.empty(len(points))
    for part in np.array_split(np.arange(len(points)), 400):
        left = likelihood.reduced.angle - likelihood.angle(points[part])
        squares[part] = np.sum(likelihood.noise.whiten(left) ** 2, axis=1)
    return grid, -0.5 * squares / scale**2 - 0.5 * np.sum(grid**2, axis=1)


def conditional(
    likelihood: LoopLikelihood, drive: FloatArray, play: float, scale: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mode, mean and standard deviation of the backlash's coordinates, the drive's given."""
    grid, log_density = on_a_grid(likelihood, drive, play, scale)
    weight = np.exp(log_density - log_density.max())
    weight /= weight.sum()
    mean = weight @ grid
    return grid[np.argmax(weight)], mean, np.sqrt(weight @ (grid - mean) ** 2)


def evidence(likelihood: LoopLikelihood, drive: FloatArray, play: float) -> float:
    """Log of the same density summed over the backlash's coordinates, up to a constant."""
    return float(logsumexp(on_a_grid(likelihood, drive, play, 1.0)[1]))


def drawn(likelihood: LoopLikelihood, at: FloatArray, scale: float) -> EffectDraws:
    rng = np.random.default_rng(3)
    linearised = LinearisedEffects.about(likelihood, describe(likelihood, at))
    points = np.tile(at[: COUNT + 1], (DRAWS, 1))
    return linearised.draws(points, np.zeros(DRAWS), np.full(DRAWS, scale), GROUPS, rng)


def deviations(play: float, scale: float) -> tuple[EffectDraws, FloatArray]:
    """The draws, and the largest errors of means and standard deviations over their own errors."""
    likelihood, drive = likelihood_with(play)
    mode, mean, sd = conditional(likelihood, drive, play, scale)
    found = drawn(likelihood, np.concatenate([drive, mode]), scale)
    effects = found.points[:, COUNT + 1 :]
    off = [(effects.mean(axis=0) - mean) / sd, effects.std(axis=0) / sd - 1.0]
    return found, np.abs(off).max(axis=1) * np.sqrt(found.effective)


@pytest.mark.parametrize(("play", "scale"), [(3e-4, 1.0), (1.2e-4, 1.0), (1.2e-4, 1.5)])
def test_draws_follow_the_exact_density(play: float, scale: float) -> None:
    found, off = deviations(play, scale)
    assert found.exact
    assert found.pareto_k < PARETO_K_LIMIT
    assert off.max() < 4


def test_draws_do_not_hang_on_where_the_effects_are_linearised() -> None:
    likelihood, drive = likelihood_with(1.2e-4)
    mode, mean, sd = conditional(likelihood, drive, 1.2e-4, 1.0)
    found = drawn(likelihood, np.concatenate([drive, mode + np.array([-0.3, 1.2])]), 1.0)
    assert found.exact
    effects = found.points[:, COUNT + 1 :]
    off = np.abs([(effects.mean(axis=0) - mean) / sd, effects.std(axis=0) / sd - 1.0])
    assert off.max() * np.sqrt(found.effective) < 4
    assert found.effective > 0.5 * DRAWS


def test_tries_are_worth_draws_where_the_density_is_no_gaussian(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    several, off = deviations(1.2e-4, 1.5)
    assert off.max() < 4
    monkeypatch.setattr(linearised_effects, "_TRIES", (1,))
    one, _ = deviations(1.2e-4, 1.5)
    # All draws have the same parameters: what their weights still differ by is the tries' chance.
    assert DRAWS / several.effective - 1 < 0.3 * (DRAWS / one.effective - 1)


def test_rough_weights_are_said_and_useless_ones_are_not_used(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Of several tries the one that is taken makes up for most: only the weights of one are put off.
    monkeypatch.setattr(linearised_effects, "_TRIES", (1,))
    monkeypatch.setattr(linearised_effects, "PARETO_K_LIMIT", -10.0)
    found, off = deviations(1.2e-4, 1.0)
    assert not found.exact
    assert found.usable
    assert off.max() < 4
    monkeypatch.setattr(linearised_effects, "_FEWEST_EFFECTIVE", np.inf)
    found, off = deviations(1.2e-4, 1.0)
    assert not found.exact
    assert not found.usable
    assert len(np.unique(found.points, axis=0)) == DRAWS
    assert off.max() > 8  # so the comparison would notice


def test_more_tries_where_few_leave_weights_of_no_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linearised_effects, "_TRIES", (1,))
    one, _ = deviations(1.2e-4, 1.5)
    monkeypatch.setattr(linearised_effects, "_FEWEST_EFFECTIVE", one.effective + 100.0)
    assert not deviations(1.2e-4, 1.5)[0].usable
    monkeypatch.setattr(linearised_effects, "_TRIES", (1, 12))
    found, off = deviations(1.2e-4, 1.5)
    assert found.usable
    assert off.max() < 4


@lru_cache
def with_play() -> tuple[Prepared, LoopLikelihood, list[StartingPoint]]:
    rng = np.random.default_rng(7)
    torque: FloatArray = np.interp(np.linspace(0, 3, 121), range(4), (0.0, 80.0, -80.0, 80.0))
    angle = predict(torque, POST_TEST) + 1.5e-4 * np.tanh(torque / 0.7)
    loop = Loop(torque, angle + NOISE * rng.standard_normal(torque.size))
    prepared = prepare(loop, DRIVE, rng, prior=PRIOR)
    likelihood = replace(prepared.likelihood, effects=(BACKLASH,))
    return prepared, likelihood, effect_starts(likelihood, prepared.starts)


PLAN = replace(QUICK, required_ess=100.0)


def fit_with_play() -> Posterior:
    prepared, likelihood, starts = with_play()
    return sample_posterior(prepared, likelihood, starts, np.random.default_rng(4), plan=PLAN)


def without_weights(monkeypatch: pytest.MonkeyPatch) -> None:
    for limit in ("PARETO_K_LIMIT", "_WORST_PARETO_K"):
        monkeypatch.setattr(linearised_effects, limit, -10.0)


def test_where_weights_do_not_do_the_effects_are_sampled_with_all_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same posterior but for the tail of the play, in which weights of Pareto k 0.7 are rough.

    By two thousand effective draws a median errs by 4 % of its standard deviation, in both.
    """
    weighted = fit_with_play()
    without_weights(monkeypatch)
    exactly = fit_with_play()
    assert weighted.converged
    assert exactly.converged
    assert "pareto_k" in weighted.sampling
    assert "pareto_k" not in exactly.sampling
    assert not any("integrated out" in said for said in exactly.warnings)
    off = np.median(weighted.points, axis=0) - np.median(exactly.points, axis=0)
    assert np.abs(off / exactly.points.std(axis=0)).max() < 0.25


def test_where_weights_do_not_do_wider_draws_are_weighed_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A thousand effective draws: a spread errs by 2 %, and wider ones have 1.2 times as much."""
    straight = fit_with_play()
    really = LinearisedEffects.draws

    def only_wider(self: LinearisedEffects, *given: Any) -> EffectDraws:
        found = really(self, *given)
        return replace(found, pareto_k=2.0) if given[-1] == 1.0 else found

    monkeypatch.setattr(LinearisedEffects, "draws", only_wider)
    wider = fit_with_play()
    assert wider.converged
    assert wider.sampling["temperature"] > 1.0
    assert wider.sampling["weighted_draws_effective"] > 800
    low, middle, high = (np.quantile(straight.points, at, axis=0) for at in (0.16, 0.5, 0.84))
    again = np.quantile(wider.points, (0.16, 0.5, 0.84), axis=0)
    assert np.abs((again[1] - middle) / (high - low)).max() < 0.1
    spread = (again[2] - again[0]) / (high - low)
    assert np.abs(np.log(spread)).max() < 0.12
    assert abs(np.log(spread).mean()) < 0.04


def test_a_fit_whose_weights_have_no_mean_does_not_count_as_converged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    without_weights(monkeypatch)
    really = fit_loop._sample

    def never_at_once(exact: LoopLikelihood, linearised: Any, *others: Any) -> Any:
        found = really(exact, linearised, *others)
        return replace(found, settled=linearised is not None)

    monkeypatch.setattr(fit_loop, "_sample", never_at_once)
    found = fit_with_play()
    assert found.diagnostics.passes(PLAN.required_ess)
    assert not found.converged
    assert any("do not stand for the posterior" in said for said in found.warnings)


def test_a_group_keeps_its_own_draws() -> None:
    likelihood, drive = likelihood_with(3e-4)
    rng = np.random.default_rng(4)
    at = np.concatenate([drive, [1.43, 0.0]])
    linearised = LinearisedEffects.about(likelihood, describe(likelihood, at))
    offset = np.repeat(1e-7 * np.arange(GROUPS), DRAWS // GROUPS)
    points = np.tile(drive, (DRAWS, 1))
    found = linearised.draws(points, offset, np.ones(DRAWS), GROUPS, rng)
    assert found.exact
    assert np.array_equal(found.offset, offset)


def test_points_get_the_weight_that_the_exact_effects_give_them() -> None:
    """Of two points of the drive, one far off: evidence by quadrature over the linear model's.

    The linear model is a Gaussian, written out. 8 000 draws: four standard errors.
    """
    likelihood, drive = likelihood_with(3e-4)
    mode, _, _ = conditional(likelihood, drive, 3e-4, 1.0)
    linearised = LinearisedEffects.about(
        likelihood, describe(likelihood, np.concatenate([drive, mode]))
    )
    pair = np.stack([drive, drive])
    pair[1, 0] += 1.2e-2
    linear = likelihood.noise.covariance + linearised.features @ linearised.features.T
    of_linear = [
        multivariate_normal(mean, linear).logpdf(likelihood.fitted)
        for mean in linearised.sampled.angle(pair)
    ]
    ratio = [evidence(likelihood, one, 3e-4) for one in pair] - np.array(of_linear)
    assert abs(np.diff(of_linear)[0]) > 2.0  # which weights have to make up for
    at = np.repeat([0, 1], DRAWS // 2)
    found = linearised.draws(pair[at], np.zeros(DRAWS), np.ones(DRAWS), 1, np.random.default_rng(5))
    assert found.exact
    wanted = 1.0 / (1.0 + np.exp(ratio[0] - ratio[1]))
    share = np.mean(found.points[:, 0] == pair[1, 0])
    assert share == pytest.approx(wanted, abs=4 * np.sqrt(0.25 / found.effective))
