"""Whether effects have sizes that a record can carry.

Two large effects that nearly cancel can follow what neither of them is, as a zero and a lag of the
torque sensor follow a zero that drifts.
"""

from __future__ import annotations

import numpy as np

from hdprog.inference.likelihood import COUNT, LoopLikelihood
from hdprog.inference.starting_points import StartingPoint

_FARTHEST = 4.0  # prior standard deviations: what is farther is none of what the effect describes
_OF_ANGLE = 2.0  # of the angle's range: a hardening cup takes back what teeth yield, but not more
_OF_TORQUE = 0.5  # of the record's largest torque, which an error of the torque stays below


def within_reach(likelihood: LoopLikelihood, start: StartingPoint) -> bool:
    """Whether every effect of a mode is one that its prior and the record's swing allow.

    No coordinate may be where no prior is, no error of the torque above half the largest torque,
    and no effect may move the angle by more than twice the record's own range.
    """
    own, effects = start.point[COUNT + 1 :], likelihood.effect_set
    for (_, parameter), coordinate in zip(effects.parameters, own, strict=True):
        absent = parameter.amplitude and coordinate < 0.0 and parameter.transform == "log"
        bounded = parameter.transform == "between"
        if abs(coordinate) > _FARTHEST and not (absent or bounded):
            return False
    course, values = likelihood.reduced.course, likelihood.effect_values(start.point[None, :])
    whole = likelihood.angle(start.point[None, :])
    span = _OF_ANGLE * 2.0 * course.scales.angle
    for effect in effects.effects:
        if effect.acts_on == "torque":
            error, _ = effect.torque_error(course, values[effect.id])
            if np.abs(error).max() > _OF_TORQUE * course.scales.torque:
                return False
        elif effect.acts_on == "angle":
            seen = effects.course_of(effect, course, values)
            if np.ptp(effect.evaluate(seen, values[effect.id], whole)) > span:
                return False
    return True
