"""Error of transmission: periodic in the absolute position of the output."""

from __future__ import annotations

import numpy as np

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, signed_amplitude
from hdprog.physics.parameters import FloatArray
from hdprog.physics.periodic import wave

_LEAST_CYCLES = 0.8  # over the sweep: slower lines are no lines but a bend


class KinematicError(Effect):
    """Σ s_i sin(n_i θ) + c_i cos(n_i θ) over two free lines n_1, n_2 a turn of the output (11)."""

    id = "kinematic_error"
    words = "an error periodic in the output's position"
    needs = frozenset({"output angle"})
    advice = "Test at one output position, or subtract the transmission error measured at no load."

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """Lines a turn, and amplitudes in rad."""
        sweep = scales.sweep if scales.sweep else 1.0
        turn = 2 * np.pi / sweep
        most = max(2.0, scales.readings / 8)
        first = EffectParameter(
            "lines",
            "per turn",
            "of the strongest line",
            "between",
            _LEAST_CYCLES * turn,
            most * turn,
        )
        cycles = np.arange(1.0, min(most, 80.0), 0.25)
        first = first.gridded(cycles * turn)
        second = EffectParameter(
            "second_ratio",
            "-",
            "second line over the first",
            "log",
            2.0,
            0.5,
            grid=(-1.4, 0.0, 0.8),
        )
        return (
            first,
            signed_amplitude("sine", "of the strongest line", scales),
            signed_amplitude("cosine", "of the strongest line", scales),
            second,
            signed_amplitude("second_sine", "of the second line", scales),
            signed_amplitude("second_cosine", "of the second line", scales),
        )

    def evaluate(self, course: Course, values: Values, angle: FloatArray) -> FloatArray:
        """See `Effect.evaluate`."""
        assert course.output_angle is not None
        lines = values["lines"] / (2 * np.pi)
        turns = lines * (course.output_angle - (course.scales.output_middle or 0.0))
        total = wave(turns, values["sine"], values["cosine"])
        turns *= values["second_ratio"]
        total += wave(turns, values["second_sine"], values["second_cosine"])
        return total
