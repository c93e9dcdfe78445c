"""Interpolation error of the angle encoder: periodic in the torsion angle itself."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, signed_amplitude
from hdprog.physics.parameters import FloatArray
from hdprog.physics.periodic import wave

_FINEST = 0.4  # periods in a step of the encoder: rounding is a saw-tooth of one period a step


class AngleRipple(Effect):
    """Σ_k s_k sin(kφ) + c_k cos(kφ), k = 1, 2, φ = 2πν·Δθ with ν periods in a radian of torsion.

    The two-signal error of an incremental encoder (Heydemann, Appl. Opt. 20 (1981) 3382).

    A function of the model's angle: the measured one carries the ripple and its noise.
    """

    id = "angle_ripple"
    words = "an error of the angle encoder, periodic in the torsion angle"
    advice = (
        "Align or recalibrate the encoder (offset, gain and phase of its two signals); the drive "
        "is not at fault."
    )
    follows_angle = True

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """Period in rad, amplitudes in rad."""
        extent = 2 * scales.angle
        most = max(3.0, min(40.0, scales.readings / 10))
        if scales.angle_step is not None:
            # Nor may the second harmonic be the rounding.
            most = max(1.6, min(most, _FINEST * extent / scales.angle_step))
        cycles = EffectParameter(
            "cycles",
            "per rad",
            "periods in a radian of torsion",
            "between",
            1.2 / extent,
            most / extent,
        )
        return (
            cycles.gridded(np.arange(1.5, most, 0.25) / extent),
            signed_amplitude("sine", "of the ripple", scales),
            signed_amplitude("cosine", "of the ripple", scales),
            signed_amplitude("second_sine", "of the second harmonic", scales),
            signed_amplitude("second_cosine", "of the second harmonic", scales),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        turns = values["cycles"] * angle
        total = wave(turns, values["sine"], values["cosine"])
        turns *= 2
        total += wave(turns, values["second_sine"], values["second_cosine"])
        return total
