"""Which parts of a record are left out in turn."""

from __future__ import annotations

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.synthetic import measured_loop, torque_history
from hdprog.discovery.heldout import sample_folds
from hdprog.inference.prepare import prepare
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
