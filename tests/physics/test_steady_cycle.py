"""Figures of merit with lasting effects in them, against hand calculations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hdprog.physics.course import Scales
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.figures import FigureRequest, Operation, figure
from hdprog.physics.steady_cycle import QUANTITIES, LastingEffects, steady_branches, whole_figure

OPERATION = Operation(math.radians(30), 60.0, 40.0)
SCALES = Scales(60.0, 1e-3, None, None, None, 400)
DRIVE = {
    "K_F": 78198.0,
    "K_W": 98549.0,
    "a": 1833.0,
    "b": 5730.0,
    "T_T": 30.0,
    "c": -1.152,
    "T_i": 70.2,
    "mu": 0.076,
}
PARAMETERS = {name: np.array([value]) for name, value in DRIVE.items()}
ARCMIN = math.pi / 180 / 60


def lasting(name: str, **values: float) -> LastingEffects:
    columns = {key: np.array([[value]]) for key, value in values.items()}
    found = LastingEffects.of(EffectSet((BY_ID[name],), SCALES), {name: columns})
    assert found is not None
    return found


def base(quantity: str) -> float:
    return float(figure(FigureRequest(quantity), PARAMETERS, OPERATION)[0])


def whole(quantity: str, effect: LastingEffects) -> float:
    return float(whole_figure(quantity, PARAMETERS, OPERATION, effect)[0])


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_an_absent_effect_changes_no_figure(quantity: str) -> None:
    absent = lasting("coulomb_friction", width=0.0, slip_torque=0.5, initial_state=0.0)
    assert whole(quantity, absent) == pytest.approx(base(quantity), rel=1e-9)


def test_coulomb_friction_widens_the_loop_by_its_width() -> None:
    friction = lasting("coulomb_friction", width=2e-4, slip_torque=0.1, initial_state=0.3)
    width = "hysteresis_width_arcmin"
    assert whole(width, friction) - base(width) == pytest.approx(2e-4 / ARCMIN, rel=1e-9)
    # The area grows by width times span, less the corners where the slider is carried along.
    loss = "hysteresis_loss_J"
    assert whole(loss, friction) - base(loss) == pytest.approx(2e-4 * 120.0, rel=0.01)
    middle = "lost_motion_arcmin"
    assert whole(middle, friction) == pytest.approx(base(middle), abs=1e-6)


def test_play_is_lost_motion_and_no_hysteresis() -> None:
    play = lasting("backlash", play=3e-4, width=0.05, centre=0.0)
    moved = whole("lost_motion_arcmin", play) - base("lost_motion_arcmin")
    assert moved == pytest.approx(3e-4 / ARCMIN, rel=1e-6)
    width = "hysteresis_width_arcmin"
    assert whole(width, play) == pytest.approx(base(width), rel=1e-9)


def test_the_cycle_is_steady() -> None:
    """Both branches meet at the ends, whatever the element's state was at first."""
    torque = np.array([-59.999, 59.999])
    for state in (-1.0, 1.0):
        effect = lasting("microslip", width=2e-4, slip_torque=4.0, spread=0.7, initial_state=state)
        rising, falling = steady_branches(torque, PARAMETERS, OPERATION, effect)
        np.testing.assert_allclose(rising[0, 1], falling[0, 1], atol=1e-7)
        np.testing.assert_allclose(rising[0, 0], falling[0, 0], atol=1e-7)


def test_effects_of_the_rig_or_of_the_rate_are_no_part_of_it() -> None:
    others = tuple(BY_ID[name] for name in ("creep", "viscous_friction", "torque_offset"))
    assert LastingEffects.of(EffectSet(others, SCALES), {}) is None
    with pytest.raises(ValueError, match="no figure of the steady cycle"):
        whole("preload_Nm", lasting("backlash", play=1e-4, width=0.1, centre=0.0))


@pytest.mark.parametrize("rougher", [-0.2, 0.2])
def test_the_width_sees_the_friction_of_either_side(rougher: float) -> None:
    uneven = lasting("asymmetry", log_stiffness_ratio=0.0, log_friction_ratio=rougher)
    width = "hysteresis_width_arcmin"
    other = {**PARAMETERS, "mu": PARAMETERS["mu"] * math.exp(rougher)}
    there = float(figure(FigureRequest(width), other, OPERATION)[0])
    low, high = sorted([base(width), there])
    assert low < whole(width, uneven) < high
