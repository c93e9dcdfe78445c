"""Corners rounded after a reversal: contacts that begin to slip one after another."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

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

_ELEMENTS = 8
# Middles of as many equal parts of a standard Gaussian.
_DEVIATES = ndtri((np.arange(_ELEMENTS) + 0.5) / _ELEMENTS)


class Microslip(Effect):
    """−(w/2)·Σ z_i/n over n Jenkins elements with slip limits T_i = T_m·exp(σ ζ_i + σ²).

    Distributed Maxwell slip (Iwan 1966; Tjahjowidodo et al., J. Sound Vib. 2013, for harmonic
    drives): equally stiff contacts with log-normal limits, median T_m, standard deviation σ, give
    way in proportion to their limits. Counted by what they give way, limits are log-normal, too,
    about T_m·exp(σ²); ζ_i are the middles of n equal parts of it.
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
        """w in rad, T_m in Nm, σ, initial state."""
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
            EffectParameter(
                "spread", "-", "standard deviation of the limits' logarithm", "log", 0.7, 0.2
            ),
            initial_state("state at the first sample, −1 to 1"),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        spread, width = values["spread"], values["width"]
        limits = values["slip_torque"] * np.exp(spread * (_DEVIATES + spread))
        initial = np.repeat(values["initial_state"], _ELEMENTS, axis=0)
        states = jenkins(course, limits.reshape(-1, 1), initial)
        return np.asarray(-0.5 * width * states.reshape(len(width), _ELEMENTS, -1).mean(axis=1))
