"""A spring beside a friction torque that turns round gradually after each reversal.

T = f(θ) + F·s, with f an odd polynomial and s the state of the friction between −1 and 1. Along a
stretch that begins with state s0 the state is σ + (s0 − σ)(1 − w(x)), σ = ± 1 being the direction
and w(x) a function of the angle x travelled since the reversal that grows from 0 to 1. Torque being
given, x is found by a table and Newton's method.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hdprog.physics.other_models.odd_spring import OddSpring
from hdprog.physics.parameters import FloatArray
from hdprog.physics.torque_path import TorquePath

Turning = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""w and its derivative in 1/rad at angles x travelled since a reversal, (draws, samples) each."""

_NODES = np.linspace(0.0, 1.0, 97) ** 2  # denser behind the reversal, where friction turns round
_STEPS = 3


def angle_with_lag(
    path: TorquePath, spring: OddSpring, friction: FloatArray, turning: Turning, initial: FloatArray
) -> FloatArray:
    """Torsion angle along a torque path.

    Parameters
    ----------
    path : the torque history
    spring : f
    friction : (draws, 1) F in Nm
    turning : w
    initial : (draws, 1) state before the first sample, −1 to 1

    Returns
    -------
    (draws, samples) in rad
    """
    found = np.empty((friction.shape[0], path.torque.size))
    state = initial
    turned_at = path.torque[0]
    angle = spring.angle(turned_at - friction * state)
    for number, (start, end) in enumerate(zip(path.starts, path.ends, strict=True)):
        sign = 1.0 if path.rising[number] else -1.0
        reached = path.reached[number]
        torque = np.append(path.torque[start:end], reached)
        travel = np.maximum(sign * (torque - turned_at), 0.0)
        missing = friction * (1 - sign * state)
        way = _way(travel, spring, angle, sign, missing, turning)
        found[:, start:end] = angle + sign * way[:, :-1]
        last = way[:, -1:]
        state = sign + (state - sign) * (1 - turning(last)[0])
        angle = angle + sign * last
        # A stretch that noise has made turn back does not reach less than where it began.
        turned_at = turned_at + sign * max(sign * (reached - turned_at), 0.0)
    return found


def _way(
    travel: FloatArray,
    spring: OddSpring,
    begin: FloatArray,
    sign: float,
    missing: FloatArray,
    turning: Turning,
) -> FloatArray:
    """Angle (draws, samples) travelled since a reversal at `begin` (draws, 1), in rad."""
    torque_there = spring.torque(begin)
    farthest = sign * (spring.angle(torque_there + sign * travel.max()) - begin)

    def excess(way: FloatArray) -> tuple[FloatArray, FloatArray]:
        at = begin + sign * way
        share, growth = turning(way)
        torque = sign * (spring.torque(at) - torque_there) + missing * share
        return torque, spring.slope(at) + missing * growth

    nodes = farthest * _NODES
    table = excess(nodes)[0]
    way = np.stack([np.interp(travel, row, node) for row, node in zip(table, nodes, strict=True)])
    for _ in range(_STEPS):
        torque, slope = excess(way)
        way -= (torque - travel) / slope
        np.clip(way, 0.0, farthest, out=way)
    return way
