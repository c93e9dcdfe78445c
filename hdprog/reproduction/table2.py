"""Table 2 of the paper: a CSF-25-80 when new and after 100 h at rated load."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath
from hdprog.reproduction.results import BranchPair

ALPHA = math.radians(30.0)
"""The paper does not state the tooth angle; everything here takes 30°."""
TOP = 100.0
"""Torque in Nm to which the loops of the paper's figures seem to run; it is not stated either."""
COMBINED_STIFFNESS = 50_923.2

# When new, T_T = 0 and cup and teeth act as one stiffness K (38): any split of 1/K serves.
INITIAL: dict[str, float] = {
    "K_F": 2 * COMBINED_STIFFNESS,
    "K_W": 101_837.5,
    "a": 0.0,
    "b": 2 * COMBINED_STIFFNESS,
    "T_T": 0.0,
    "c": -1.177,
    "T_i": 115.5,
    "mu": 0.066,
}
POST_TEST: dict[str, float] = {
    "K_F": 78_197.8,
    "K_W": 98_548.7,
    "a": 1833.5,
    "b": 5729.6,
    "T_T": 30.0,
    "c": -1.152,
    "T_i": 70.2,
    "mu": 0.076,
}
_POINTS = 401


def as_draw(parameters: dict[str, float]) -> Parameters:
    """Parameters as arrays of one draw."""
    return {name: np.array([value]) for name, value in parameters.items()}


def steady_loop(parameters: dict[str, float], label: str, points: int = _POINTS) -> BranchPair:
    """Branches of the drive model's steady cycle to ± `TOP`."""
    return steady_cycle(
        lambda path: torsion_angle(path, as_draw(parameters), ALPHA)[0], label, points
    )


def steady_cycle(angle: Callable[[TorquePath], FloatArray], label: str, points: int) -> BranchPair:
    """Branches of a model's symmetric steady cycle to ± `TOP`.

    Parameters
    ----------
    angle : of the model along a path, (samples,) in rad
    label : which loop it is
    points : of each branch
    """
    torque = np.linspace(-TOP, TOP, points)
    history = np.concatenate([[0.0, TOP, -TOP], torque[1:], torque[-2::-1]])
    found = angle(TorquePath.exact(history))
    falling: FloatArray = found[-points:][::-1]
    return BranchPair(label, torque, found[2 : 2 + points], falling)
