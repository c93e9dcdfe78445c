"""Which parts of a record are left out in turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.synthetic import measured_loop, torque_history
from hdprog.discovery.heldout import held_out, sample_folds
from hdprog.discovery.model import Model
from hdprog.inference.prepare import prepare
from hdprog.inference.within_blocks import WithinBlocks
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
