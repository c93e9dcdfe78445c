"""Effects that a measured loop may carry and the drive model lacks.

A new effect is one file and one name in `EFFECTS`.
"""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.physics.effects.angle_ripple import AngleRipple
from hdprog.physics.effects.asymmetry import Asymmetry
from hdprog.physics.effects.backlash import Backlash
from hdprog.physics.effects.base import Effect
from hdprog.physics.effects.coulomb_friction import CoulombFriction
from hdprog.physics.effects.creep import Creep
from hdprog.physics.effects.cup_hardening import CupHardening
from hdprog.physics.effects.kinematic_error import KinematicError
from hdprog.physics.effects.microslip import Microslip
from hdprog.physics.effects.slip_jump import SlipJump
from hdprog.physics.effects.stribeck_friction import StribeckFriction
from hdprog.physics.effects.thermal_drift import ThermalDrift
from hdprog.physics.effects.tooth_damage import ToothDamage
from hdprog.physics.effects.torque_offset import TorqueOffset
from hdprog.physics.effects.torque_sensor_hysteresis import TorqueSensorHysteresis
from hdprog.physics.effects.viscous_friction import ViscousFriction

EFFECTS: tuple[Effect, ...] = (
    TorqueOffset(),
    Backlash(),
    Asymmetry(),
    CupHardening(),
    CoulombFriction(),
    Microslip(),
    ViscousFriction(),
    StribeckFriction(),
    Creep(),
    ThermalDrift(),
    KinematicError(),
    AngleRipple(),
    TorqueSensorHysteresis(),
    ToothDamage(),
    SlipJump(),
)
BY_ID: Mapping[str, Effect] = {effect.id: effect for effect in EFFECTS}
