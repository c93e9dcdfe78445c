"""Hysteresis of the torque sensor: its reading lags by a share of the swing."""

from __future__ import annotations

from hdprog.physics.course import Course, Scales
from hdprog.physics.effects.base import Effect, EffectParameter, Values, initial_state
from hdprog.physics.lag_elements import exponential_lag
from hdprog.physics.parameters import FloatArray


class TorqueSensorHysteresis(Effect):
    """T_true = T + T_h·z, z approaching ± 1 exponentially over a long travel T_l of T_true.

    The lag takes a large part of the swing to turn round, so a small swing leaves a small lag
    (Dahl's model of the strain-gauge body's own hysteresis).
    """

    id = "torque_sensor_hysteresis"
    words = "the torque reading lags by a share of the swing"
    acts_on = "torque"
    needs = frozenset({"reversal"})
    advice = "Check the torque sensor against a reference, up and down; calibrate or replace it."

    def parameters(self, scales: Scales) -> tuple[EffectParameter, ...]:
        """T_h and T_l in Nm, initial state."""
        lag = "largest lag of the reading"
        return (
            EffectParameter("lag", "Nm", lag, "log", 0.005 * scales.torque, 1.2, amplitude=True),
            EffectParameter(
                "travel",
                "Nm",
                "torque travelled until the lag has turned round (to 1/e)",
                "log",
                0.5 * scales.torque,
                0.35,
                grid=(-1.0, 1.0),
            ),
            initial_state("state at the first sample, −1 to 1"),
        )

    def torque_error(self, course: Course, values: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.torque_error`."""
        lag = values["lag"]
        along, ends = exponential_lag(course, values["travel"], values["initial_state"], lag)
        return -lag * along, -lag * ends
