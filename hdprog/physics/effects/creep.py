"""The angle keeps growing under load and recovers: a Prony series of two elements."""

from __future__ import annotations

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, angle_amplitude
from hdprog.physics.first_order import follow_two
from hdprog.physics.parameters import FloatArray

_DOUBLINGS = 3  # of the quick time constant, to the slow one


class Creep(Effect):
    """C·(q x_1 + (1 − q) x_2), τ_i dx_i/dt = T/T_max − x_i, with τ and 8τ.

    Two Kelvin-Voigt elements in series (a Prony series; Ferry, Viscoelastic Properties of Polymers,
    1980), wide enough apart to stand for a spectrum of times; with q = 1 there is one alone. At the
    first sample they are in balance with the torque, but for a part h of C that earlier loads have
    left, which fades with 8τ.
    """

    id = "creep"
    words = "the angle keeps growing under load and recovers afterwards"
    needs = frozenset({"time"})
    advice = (
        "Run every test at the same rate and with the same holds, so that tests compare; bonded "
        "or polymer parts and thick grease films creep."
    )

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """C in rad, τ in s, and what earlier loads left."""
        duration = scales.duration if scales.duration is not None else 1.0
        return (
            angle_amplitude("amplitude", "angle added at the largest torque in the end", scales),
            EffectParameter(
                "time_constant",
                "s",
                "of the quick element; the slow one's is eight times as long",
                "log",
                0.05 * duration,
                1.1,
                grid=(-1.8, -0.9, 0.0, 0.9, 1.8),
            ),
            EffectParameter("quick_share", "-", "part of it in the quick element", "between", 0, 1),
            EffectParameter(
                "left_before", "-", "part of it left by earlier loads", "normal", 0.0, 0.4
            ),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        load = course.load[None, :]
        share = values["quick_share"]
        shape, fading = follow_two(course, load, values["time_constant"], _DOUBLINGS, share)
        fading *= values["left_before"]
        shape += fading
        shape *= values["amplitude"]
        return shape
