"""Effects that a record cannot tell apart, and the test that would."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from hdprog.discovery.forward_step import Step
from hdprog.discovery.pooling import THRESHOLD
from hdprog.discovery.sharing import gain_of_steps

_AS_GOOD = 3.0  # log evidence: odds of twenty to one
_ALIKE = 0.03  # of the explained error: less than an effect's shape is known to

_FOLLOW_RATE = frozenset({"viscous_friction", "stribeck_friction", "creep"})
_FOLLOW_TORQUE = frozenset({"coulomb_friction", "microslip"})
_SLOW = frozenset({"creep", "thermal_drift", "slip_jump"})
_SHAPES = frozenset({"backlash", "asymmetry", "cup_hardening", "tooth_damage", "torque_offset"})


def indistinguishable(steps: Sequence[Step], chosen: str) -> tuple[str, ...]:
    """Effects that would have done as well as the chosen one.

    Those within a log evidence of 3, and those whose error is within 3 % of what the chosen one
    explains: so well the true shape of a mechanism is hardly ever known. Over the records that can
    show both, where these by themselves show the chosen one: the others cannot tell them apart.

    Parameters
    ----------
    steps : the forward step that chose it, one a record
    chosen : its id

    Returns
    -------
    ids, the best first
    """
    steps = [step for step in steps if chosen in step.models]
    ahead: dict[str, float] = {}
    for name in {name for step in steps for name in step.models} - {chosen}:
        both = [step for step in steps if name in step.models]
        best, evidence = (gain_of_steps(one, both)[0] for one in (chosen, name))
        if len(both) < len(steps) and best < THRESHOLD:
            continue
        close = evidence > max(best - _AS_GOOD, 0.0)
        alike = evidence > _AS_GOOD and _drop(both, name) > (1 - _ALIKE) * _drop(both, chosen)
        if close or alike:
            ahead[name] = evidence - best
    return tuple(sorted(ahead, key=lambda name: -ahead[name]))


def _drop(steps: Sequence[Step], name: str) -> float:
    return sum(step.before.misfit - step.models[name].misfit for step in steps)


def separating_test(names: Collection[str]) -> str | None:
    """The test that would tell these effects apart; None for fewer than two."""
    together = set(names)
    if len(together) < 2:
        return None
    advice = []
    if together & _FOLLOW_RATE and not together <= _SLOW:
        advice.append(
            "Repeat the test at a second loading rate, at least three times as fast or as slow: "
            "viscous and Stribeck friction and creep change with it, friction that follows the "
            "torque alone does not."
        )
    if "creep" in together:
        advice.append(
            "Hold the largest torque for as long as a loading takes, unload and hold again: creep "
            "goes on and comes back, friction stands still and a drift does not come back."
        )
    elif together & _SLOW:
        advice.append(
            "Run the same cycle three times in a row: a drift goes on, a step happens once, what "
            "belongs to the drive repeats."
        )
    if "torque_sensor_hysteresis" in together:
        advice.append(
            "Repeat to half the torque, or beside a reference sensor: the sensor's own hysteresis "
            "shrinks with the swing."
        )
    elif together >= _FOLLOW_TORQUE:
        advice.append(
            "Add small cycles about a mean torque: micro-slip rounds them, Coulomb friction gives "
            "them its full width at once."
        )
    if {"kinematic_error", "angle_ripple"} & together:
        advice.append(
            "Repeat at another output position: a kinematic error moves along the torque axis, an "
            "encoder's ripple stays with the torsion angle, a tooth's bump with the torque."
        )
    elif together & _SHAPES:
        advice.append(
            "Read the torque sensor with the joint unloaded, and repeat to both signs of torque "
            "with more readings near zero torque and near the top."
        )
    return " ".join(advice) if advice else "Repeat the test with three equal cycles in a row."
