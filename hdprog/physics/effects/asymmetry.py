"""A negative side with its own stiffness and friction."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, either_sign
from hdprog.physics.parameters import Parameters


class Asymmetry(Effect):
    """For T < 0 all stiffnesses are multiplied by exp(s), the friction coefficient by exp(f).

    Wear in one direction of load breaks the odd symmetry of the drive model.
    """

    id = "asymmetry"
    words = "the two directions of torque differ in stiffness or friction"
    acts_on = "parameters"
    needs = frozenset({"both signs of torque"})
    advice = (
        "Check first that the torque sensor reads alike in both directions and that the fixture "
        "does not tilt. Else wear is one-sided: judge each direction by its own stiffness, and "
        "check whether the joint carries a constant load."
    )
    lasting = True
    static = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """Log ratios s and f."""
        stiffer = "log of the negative side's stiffness over the positive side's"
        rougher = "log of the negative side's friction over the positive side's"
        return (
            either_sign("log_stiffness_ratio", "-", stiffer, 0.01),
            either_sign("log_friction_ratio", "-", rougher, 0.03),
        )

    def negative_side(self, parameters: Parameters, values: Values) -> Parameters:
        """See `Effect.negative_side`."""
        # A search far off may ask for more than floats hold; no likelihood follows it there.
        with np.errstate(over="ignore"):
            stiffer = np.exp(values["log_stiffness_ratio"][:, 0])
            rougher = np.exp(values["log_friction_ratio"][:, 0])
        scaled = {name: parameters[name] * stiffer for name in ("K_F", "K_W", "a", "b")}
        return {**parameters, **scaled, "mu": parameters["mu"] * rougher}
