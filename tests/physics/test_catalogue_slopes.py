"""The maker's K1, K2 and K3: slopes of the stiffness curve between T1, T2 and the top torque."""

from __future__ import annotations

import math

import pytest

from hdprog.physics.figures import FigureRequest, Operation, figure

STATE = {
    "K_F": 5e4,
    "K_W": 1e5,
    "a": 1e3,
    "b": 1e4,
    "T_T": 15.0,
    "c": -1.2,
    "T_i": 80.0,
    "mu": 0.05,
}


@pytest.mark.parametrize(
    ("name", "stretch", "mrad"),
    [
        # Cup and wave generator give 0.03 mrad a Nm at 45°. Teeth stiffen by 1000 Nm/rad a Nm up
        # to 15 Nm, from 10 000 to 25 000 Nm/rad: their angle is a logarithm there, then straight.
        ("K1_Nm_per_rad", 10.0, 0.3 + math.log(20 / 10)),
        ("K2_Nm_per_rad", 10.0, 0.3 + math.log(25 / 20) + 5 / 25),
        ("K3_Nm_per_rad", 20.0, 0.6 + 20 / 25),
    ],
)
def test_slopes_between_the_catalogues_torques_by_hand(
    name: str, stretch: float, mrad: float
) -> None:
    operation = Operation(math.radians(45), 40.0, 40.0, catalogue_torques=(10.0, 20.0))
    (found,) = figure(FigureRequest(name), STATE, operation)
    assert found == pytest.approx(stretch / (1e-3 * mrad), rel=1e-9)
