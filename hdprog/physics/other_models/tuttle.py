"""Tuttle's basic model: spring, Stribeck friction and kinematic error side by side."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.course import Course
from hdprog.physics.effects.base import signed_amplitude
from hdprog.physics.other_models.base import ModelParameter, OtherModel, Setting, Values
from hdprog.physics.other_models.odd_spring import OddSpring, spring_parameters
from hdprog.physics.parameters import FloatArray

_SPRING = ("a1", "a3")
_LINES = 3  # "an n value of 3 is adequate" (the paper, below eq. 11)
_LEAST_CYCLES = 0.8  # over the sweep: slower lines are no lines but a bend
_MOST_CYCLES = 80.0


class Tuttle(OtherModel):
    """Δθ = f⁻¹(T − T_f) + θ_e, f the cubic (9), T_f of (10), θ_e of (11).

    T_f = [F_c + (F_s − F_c)·exp(−(|ω|/Ω)^δ) + F_v·|ω|]·sign(ω) with ω the speed of the output, at
    its side; the paper writes the wave generator's, N times as fast, for which Ω and F_v scale.
    θ_e = Σ A_i·sin(n_i·θ + Φ_i), three lines of free frequency n_i a turn, written as sines and
    cosines. Friction and torsion do not act on each other: the paper's objection to this model.
    """

    id = "tuttle"
    words = "Tuttle (basic model)"
    source = "eqs 6, 7, 9-11; Tuttle & Seering, IEEE Trans. Robotics and Automation 12 (1996) 368"
    where = "records with time and output position, the output moving"
    needs = ("time_s", "output_angle_rad")
    odd = False

    def parameters(self, setting: Setting) -> tuple[ModelParameter, ...]:
        """Spring, friction and lines; speeds in rad/s of the output."""
        sweep = setting.scales.sweep or 1.0
        duration = setting.scales.duration or 1.0
        friction, speed = 0.03 * setting.torque, sweep / duration
        turn = 2 * math.pi / sweep
        most = min(max(2.0, setting.scales.readings / 8), _MOST_CYCLES)
        first = ModelParameter(
            "n_1", "per turn", "first line", "between", _LEAST_CYCLES * turn, most * turn
        ).gridded(np.geomspace(1.0, 0.95 * most, 60) * turn)
        found = [
            *spring_parameters(_SPRING, setting),
            ModelParameter("F_c", "Nm", "Coulomb friction", "log", friction, 1.2),
            ModelParameter("F_s_F_c", "Nm", "static above Coulomb friction", "log", friction, 1.2),
            ModelParameter("Omega", "rad/s", "speed of Stribeck's fall", "log", speed, 1.2),
            ModelParameter("delta", "-", "its exponent", "between", 0.5, 3.0),
            ModelParameter(
                "F_v", "Nm s/rad", "viscous friction", "log", 0.3 * friction / speed, 1.2
            ),
            first,
        ]
        for line in range(2, _LINES + 1):
            name = f"ratio_{line}"
            found.append(ModelParameter(name, "-", "line over the first", "log", float(line), 0.3))
        for line in range(1, _LINES + 1):
            found += [
                signed_amplitude(f"{part}_{line}", f"of line {line}", setting.scales)
                for part in ("sine", "cosine")
            ]
        return tuple(found)

    def angle(self, course: Course, values: Values, setting: Setting) -> FloatArray:
        """See `OtherModel.angle`."""
        assert course.output_speed is not None
        assert course.output_angle is not None
        speed = np.abs(course.output_speed)
        fall = np.exp(-((speed / values["Omega"]) ** values["delta"]))
        friction = values["F_c"] + values["F_s_F_c"] * fall + values["F_v"] * speed
        torque = course.path.torque - friction * np.sign(course.output_speed)
        angle = OddSpring.of(values, _SPRING, setting).angle(torque)
        position = course.output_angle - (course.scales.output_middle or 0.0)
        for line in range(1, _LINES + 1):
            ratio = values[f"ratio_{line}"] if line > 1 else 1.0
            phase = values["n_1"] * ratio * position
            angle += values[f"sine_{line}"] * np.sin(phase)
            angle += values[f"cosine_{line}"] * np.cos(phase)
        return angle

    def inside(self, values: Values, setting: Setting) -> NDArray[np.bool_]:
        """The spring's torque grows with angle."""
        return OddSpring.of(values, _SPRING, setting).rises()

    def stiffness_curve(self, torque: FloatArray, values: Values, setting: Setting) -> FloatArray:
        """The cubic alone; see `OtherModel.stiffness_curve`."""
        return OddSpring.of(values, _SPRING, setting).angle(torque)

    def missing(self, course: Course) -> str | None:
        """Columns that lack, or an output that stands still."""
        lacking = super().missing(course)
        if lacking is None and not course.scales.sweep:
            return "needs output_angle_rad that changes: the output stands still"
        return lacking
