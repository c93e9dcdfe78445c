"""Which parts of a record are left out in turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, null_space

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.synthetic import measured_loop, torque_history
from hdprog.discovery.heldout import _predictive_covariance, held_out, sample_folds
from hdprog.discovery.model import Model
from hdprog.inference.prepare import prepare
from hdprog.inference.starting_points import describe
from hdprog.inference.within_blocks import WithinBlocks
from tests.inference import test_likelihood
from tests.inference.test_likelihood import TRUTH
from tests.physics.table2 import POST_TEST


@pytest.mark.parametrize("one_sided", [False, True])
@pytest.mark.parametrize(("cycles", "folds"), [(2, 10), (3, 3), (4, 4)])
def test_whole_cycles_where_there_are_three(cycles: int, folds: int, one_sided: bool) -> None:
    """Also where a two-sided record begins at no torque, so that its first rise is half a swing."""
    rng = np.random.default_rng(1)
    torque = torque_history(60.0, 900, cycles, one_sided=one_sided)
    record = measured_loop(POST_TEST, torque, rng)
    loop = Loop(record["torque_Nm"], record["angle_rad"], record["time_s"])
    found = sample_folds(prepare(loop, Drive(), rng))
    assert len(np.unique(found)) == folds


def test_predicted_with_the_noise_of_the_blocks_themselves() -> None:
    """What widens the scale, or knows it from inside the blocks, is not the readings' noise."""
    rng = np.random.default_rng(2)
    torque = torque_history(60.0, 3000, 3, one_sided=False)
    record = measured_loop(POST_TEST, torque, rng)
    loop = Loop(record["torque_Nm"], record["angle_rad"], record["time_s"])
    prepared = prepare(loop, Drive(), rng)
    plain = Model(prepared.likelihood, tuple(prepared.starts))
    wider = replace(prepared.likelihood, effective=prepared.likelihood.blocks / 3)
    inside = replace(prepared.likelihood, within=WithinBlocks(4e3, 4e3))
    expected = held_out(prepared, plain).log_density
    for likelihood in (wider, inside):
        found = held_out(prepared, Model(likelihood, plain.starts)).log_density
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("cycles", [1, 3])
def test_a_clean_record_is_predicted_to_its_noise(cycles: int) -> None:
    """The slip before the first reading, which no other readings tell, had made half the error."""
    rng = np.random.default_rng(4)
    torque = torque_history(60.0, 900, cycles, one_sided=False)
    record = measured_loop(POST_TEST, torque, rng)
    loop = Loop(record["torque_Nm"], record["angle_rad"], record["time_s"])
    prepared = prepare(loop, Drive(), rng)
    found = held_out(prepared, Model(prepared.likelihood, tuple(prepared.starts)))
    assert 0 < np.isnan(found.residual).sum() < 0.2 * len(loop)
    assert found.rmse == pytest.approx(prepared.noise_floor, rel=0.1)


def test_a_part_is_predicted_as_widely_as_the_rest_leaves_it() -> None:
    """By the joint Gaussian of all blocks, of the linear model and its prior, given the others.

    In every direction but that of the offset: those that the noise alone moves, and those that the
    parameters move as much as it or more.
    """
    whole = test_likelihood.likelihood(1e-5, samples=241)
    out = np.arange(whole.blocks) % 12 < 5
    masked = replace(whole, noise=whole.noise.masking(out))
    start = describe(masked, np.append(TRUTH, 0.0))
    model = Model(whole, (start,))
    found = _predictive_covariance(model, int((~out).sum()), start)(out)
    left = whole.reduced.angle - whole.angle(start.point[None])[0]
    noise = np.var(left[~out], ddof=1)
    moved = np.stack(
        [
            whole.angle((start.point + step)[None])[0] - whole.angle((start.point - step)[None])[0]
            for step in 1e-5 * np.eye(start.point.size)
        ]
    )
    moved = moved.T / 2e-5 * whole.prior_sd
    joint = moved @ moved.T + noise * np.eye(whole.blocks) + 1.0  # angles begin anywhere
    seen = joint[np.ix_(~out, ~out)]
    across = joint[np.ix_(out, ~out)]
    given = joint[np.ix_(out, out)] - across @ np.linalg.solve(seen, across.T)
    beside_offset = null_space(np.ones((1, int(out.sum()))))
    found, given = (beside_offset.T @ one @ beside_offset for one in (found, given))
    # The share of the blocks that is seen stands for what they say: within an eighth.
    np.testing.assert_allclose(eigh(found, given, eigvals_only=True), 1.0, rtol=0.13)
    assert np.sum(np.linalg.eigvalsh(given) > 1.5 * noise) >= 4
