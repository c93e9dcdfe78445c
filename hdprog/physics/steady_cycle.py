"""The steady cycle of a drive together with the lasting effects found beside the drive model.

Width, loss and lost motion of the drive as it is: play or load-independent friction that wear has
brought is part of the loop that a user measures, though it is not in the eight parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hdprog.physics.course import Course
from hdprog.physics.effects.base import Values
from hdprog.physics.effects.model import EffectSet
from hdprog.physics.figures import (
    ARCMIN_PER_RAD,
    LOSS_POINTS,
    LOST_MOTION_SHARE,
    Operation,
    both_branches,
    steady_history,
)
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath

QUANTITIES = ("hysteresis_width_arcmin", "hysteresis_loss_J", "lost_motion_arcmin")
"""Figures of merit that a steady cycle has."""
_NEAR_ZERO = 1e-9  # of the reference torque


@dataclass(frozen=True)
class LastingEffects:
    """Effects of the steady cycle with their values.

    Attributes
    ----------
    effects : all static, see `Effect`
    values : physical values by effect and name, (draws, 1) each
    """

    effects: EffectSet
    values: Mapping[str, Values]

    @staticmethod
    def of(effects: EffectSet, values: Mapping[str, Values]) -> LastingEffects | None:
        """Those of a fit's effects that wear can bring and that are static; None without any."""
        kept = tuple(one for one in effects.effects if one.lasting and one.static)
        if not kept:
            return None
        return LastingEffects(
            EffectSet(kept, effects.scales), {one.id: values[one.id] for one in kept}
        )


def steady_branches(
    torque: FloatArray, parameters: Parameters, operation: Operation, lasting: LastingEffects
) -> tuple[FloatArray, FloatArray]:
    """Angle on the rising and on the falling branch of the steady cycle to ± reference torque.

    Parameters
    ----------
    torque : (samples,) rising torques in Nm, inside ± the reference torque
    parameters : by name, (draws,) each
    operation : the reference torque and the tooth angle
    lasting : effects beside the drive model

    Returns
    -------
    two (draws, samples) arrays in rad: rising branch, falling branch
    """
    path = TorquePath.exact(steady_history(torque, operation.reference_torque))
    course = Course.of_torque(path, lasting.effects.scales)
    draws = np.atleast_1d(parameters["mu"]).size
    angle = lasting.effects.angle(
        course, parameters, dict(lasting.values), operation.alpha, np.full(draws, 0.5)
    )
    return both_branches(angle, torque.size)


def whole_figure(
    quantity: str, parameters: Parameters, operation: Operation, lasting: LastingEffects
) -> FloatArray:
    """A figure of merit of the steady cycle, lasting effects included.

    Parameters
    ----------
    quantity : one of `QUANTITIES`
    parameters : by name, (draws,) each
    operation : what the figure refers to
    lasting : effects beside the drive model

    Returns
    -------
    (draws,) in the unit that the quantity's name ends with

    Raises
    ------
    ValueError
        for another quantity
    """
    if quantity == "hysteresis_width_arcmin":
        # Just to either side of no torque: where the sides differ, so does the width.
        near = _NEAR_ZERO * operation.reference_torque * np.array([-1.0, 1.0])
        rising, falling = steady_branches(near, parameters, operation, lasting)
        return np.asarray(ARCMIN_PER_RAD * (falling - rising).mean(axis=1))
    if quantity == "hysteresis_loss_J":
        top = operation.reference_torque
        torque = np.linspace(-top, top, LOSS_POINTS)
        rising, falling = steady_branches(torque, parameters, operation, lasting)
        return np.asarray(np.trapezoid(falling - rising, torque, axis=1))
    if quantity == "lost_motion_arcmin":
        at = LOST_MOTION_SHARE * operation.rated_torque
        rising, falling = steady_branches(np.array([-at, at]), parameters, operation, lasting)
        middle = 0.5 * (rising + falling)
        return np.asarray(ARCMIN_PER_RAD * (middle[:, 1] - middle[:, 0]))
    raise ValueError(f"{quantity} is no figure of the steady cycle")
