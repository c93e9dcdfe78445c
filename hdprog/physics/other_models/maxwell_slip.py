"""Distributed Maxwell slip: springs behind Coulomb sliders with spread limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hdprog.physics.drive_model import play
from hdprog.physics.other_models.base import ModelParameter, Setting
from hdprog.physics.other_models.nonnegative import NonnegativeModel, ramps, weight
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

_LIMITS = np.geomspace(0.005, 0.9, 10)  # of the largest torque
_PIECES = 12  # of the elastic part, from zero to the largest torque
_BEND = 1.5


@dataclass(frozen=True)
class MaxwellSlip(NonnegativeModel):
    """Δθ = Σ v_j·e_j(T) + Σ w_i·P_i[T], v, w ≥ 0, P_i the play of T with limit r_i.

    Elements in series, each a spring beside a Coulomb slider that gives way at r_i: what torque
    has as input and angle as output. Superposed plays are the inverse of superposed stops (springs
    behind sliders side by side, driven by the angle), which is how Maxwell slip is commonly drawn.
    e_j is the part of torque inside the j-th interval, mirrored: an elastic curve of any shape.
    """

    id = "maxwell_slip"
    words = "Maxwell slip (distributed)"
    source = (
        "introduction; Tjahjowidodo, Al-Bender & Van Brussel, Mechatronics 23 (2013) 497; inverse"
        " of superposed stops: Krejčí & Kuhnen, IEE Proc. Control Theory 148 (2001) 185"
    )
    where = "any record with a reversal; limits r_i up to half the swings that it makes"

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """Compliances v_j and w_i in rad/Nm."""
        soft = 1 / setting.stiffness
        elastic = [
            weight(f"v_{index + 1}", "rad/Nm", "elastic compliance of an interval", 3 * soft)
            for index in range(_PIECES)
        ]
        slipping = [
            weight(
                f"w_{index + 1}",
                "rad/Nm",
                f"compliance behind a slider of {limit * setting.torque:.3g} Nm",
                soft,
            )
            for index, limit in enumerate(_LIMITS)
        ]
        return (*elastic, *slipping)

    def features(self, path: TorquePath, setting: Setting) -> FloatArray:
        """See `NonnegativeModel.features`."""
        edges = setting.torque * np.linspace(0.0, 1.0, _PIECES + 1) ** _BEND
        elastic = ramps(path.magnitude, edges) * path.sign[:, None]
        limits = setting.torque * _LIMITS
        envelope, at_end, lower, upper = path.parted(path.pushing - limits[:, None])
        # After a rise the plays lie at their lower bounds, after a fall at their upper ones.
        first = np.clip(0.0, lower, upper) if self.history == 0 else lower
        first = upper if self.history == -1 else first
        plays = play(path, envelope, at_end, first)
        return np.hstack([elastic, plays.T])
