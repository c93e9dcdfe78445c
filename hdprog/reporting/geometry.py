"""What the pictures of loops need to know of a record: its zero and its stretches."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.figures import ARCMIN_PER_RAD
from hdprog.physics.parameters import FloatArray
from hdprog.reporting.reader_units import loop_angle
from hdprog.results import LoopFit, TestResult

MICRORADIAN = 1e6
ARCMIN = ARCMIN_PER_RAD
MOST_STRETCHES = 24
MOST_MARKS = 1500


def angle_zero(fit: LoopFit) -> float:
    """Angle in rad that is drawn as zero: the mean of the fitted branches at zero torque.

    An encoder's zero is arbitrary. Where torque never crosses zero, the fitted angle at the
    smallest torque stands for it.
    """
    torque, angle = fit.torque, fit.fitted
    before = np.flatnonzero((torque[:-1] < 0) != (torque[1:] < 0))
    if before.size == 0:
        return float(angle[np.argmin(np.abs(torque))])
    part = torque[before] / (torque[before] - torque[before + 1])
    crossings = angle[before] + part * (angle[before + 1] - angle[before])
    rising = torque[before + 1] > torque[before]
    branches = [crossings[side].mean() for side in (rising, ~rising) if side.any()]
    return float(np.mean(branches))


def straight_slope(fit: LoopFit) -> float:
    """Slope in rad/Nm of the straight line between the loop's ends."""
    low, high = int(np.argmin(fit.torque)), int(np.argmax(fit.torque))
    return float((fit.fitted[high] - fit.fitted[low]) / (fit.torque[high] - fit.torque[low]))


def straightened(fit: LoopFit, angle: FloatArray, torque: FloatArray) -> FloatArray:
    """Angle less the straight line between the loop's ends, which shows its width.

    Parameters
    ----------
    fit : of the loop
    angle, torque : (n,) in rad and Nm

    Returns
    -------
    (n,) in the reader's unit
    """
    return loop_angle().factor * (angle - angle_zero(fit) - straight_slope(fit) * torque)


def stretches(fit: LoopFit) -> list[tuple[int, int, bool]]:
    """Stretches of rising and of falling torque as (first block, end block, rising).

    Blocks are averages along the path with reversals kept exact, so that a small backlash of
    one per cent of the torque span is enough to tell a reversal from noise.
    """
    torque = fit.torque
    need = 0.01 * float(np.ptp(torque))
    turns, extreme, direction = [0], 0, 0
    for index in range(1, torque.size):
        moved = torque[index] - torque[extreme]
        if direction == 0:
            if abs(moved) > need:
                direction, extreme = (1 if moved > 0 else -1), index
        elif moved * direction >= 0:
            extreme = index
        elif abs(moved) > need:
            turns.append(extreme)
            direction, extreme = -direction, index
    edges = [*turns, torque.size - 1]
    return [(a, b, bool(torque[b] > torque[a])) for a, b in pairwise(edges) if b > a]


def few(size: int, most: int = MOST_MARKS) -> NDArray[np.intp]:
    """Evenly spaced indices, at most so many: a picture shows no more marks than that."""
    if size <= most:
        return np.arange(size)
    return np.linspace(0, size - 1, most).astype(np.intp)


def residual_scale(tests: tuple[TestResult, ...]) -> float:
    """Half the height in µrad of all residual strips: the same for every test.

    The 99.5 % point of the residuals of the worst test, at least three times the noise.
    """
    largest = 0.0
    for test in tests:
        largest = max(largest, float(np.quantile(np.abs(test.fit.residual), 0.995)))
        largest = max(largest, 3.0 * float(np.median(test.fit.noise)))
    return 1.15 * largest * MICRORADIAN if largest > 0 else 1.0
