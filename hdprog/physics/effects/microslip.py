"""Corners rounded after a reversal: contacts that begin to slip one after another."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import (
    Effect,
    EffectParameter,
    Values,
    angle_amplitude,
    initial_state,
)
from hdprog.physics.lag_elements import jenkins
from hdprog.physics.parameters import FloatArray

# Nodes and weights of slip limits, log-normal with standard deviation 0.7, weighted by the limit.
_NODES = np.array([-1.9, -1.0, -0.3, 0.3, 1.0, 1.9])
_WEIGHTS = np.exp(-0.5 * _NODES**2 + 0.7 * _NODES)
_LIMITS = np.exp(0.7 * _NODES)


class Microslip(Effect):
    """−(w/2)·Σ q_i z_i over Jenkins elements with spread slip limits, median T_m, Σ q_i = 1.

    Distributed Maxwell slip (Iwan 1966; Tjahjowidodo et al., J. Sound Vib. 2013, for harmonic
    drives).
    """

    id = "microslip"
    words = "corners rounded after each reversal"
    needs = frozenset({"reversal"})
    advice = (
        "Contacts slip before the teeth do: check the bolted joints and the wave generator's "
        "bearing seat for fretting."
    )
    lasting = True
    static = True
    divides_width = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """w in rad, T_m in Nm, initial state."""
        return (
            angle_amplitude("width", "angle that the contacts take from limit to limit", scales),
            EffectParameter(
                "slip_torque",
                "Nm",
                "median torque travelled until a contact slips",
                "log",
                0.1 * scales.torque,
                0.5,
                grid=(-1.0, 0.0, 1.0),
            ),
            initial_state("state at the first sample, −1 to 1"),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        draws, many = values["width"].shape[0], _LIMITS.size
        limits = (values["slip_torque"] * _LIMITS).reshape(-1, 1)
        initial = np.repeat(values["initial_state"], many, axis=0)
        states = jenkins(course, limits, initial).reshape(draws, many, -1)
        total = np.einsum("dkn,k->dn", states, _WEIGHTS / _WEIGHTS.sum())
        return np.asarray(-0.5 * values["width"] * total)
