"""What a model does inside the blocks of a reduced record, and where shorter ones are wanted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from hdprog.data.reduce import FINE
from hdprog.inference.covariance_root import root_of
from hdprog.inference.likelihood import LoopLikelihood
from hdprog.inference.starting_points import StartingPoint
from hdprog.physics.parameters import FloatArray

_STEP = 1e-6  # of the finite differences, in unconstrained coordinates
_BLUR = FINE // 2 + 1  # points: a corner moves with the parameters


def bend(likelihood: LoopLikelihood, start: StartingPoint) -> FloatArray:
    """(blocks,) what a mode's mean angle over a block has beyond its angle at the mean torque.

    The slip starts and stops at corners. Where one falls inside a block the mean over the block
    is not the value in its middle; in a long record such a difference exceeds the blocks' noise.
    """
    angle = _inside(likelihood, start.point[None, :])[0].mean(axis=1)
    return np.asarray(angle - likelihood.angle(start.point[None, :])[0])


def detail(likelihood: LoopLikelihood, start: StartingPoint) -> FloatArray:
    """(samples,) share of the blocks that each reading is to have for the posterior's sake.

    A block of n readings hides Σ|J − mean J|² of the information, J being the sensitivities of a
    reading in units of its noise and of the posterior. The sum over a given number of blocks is
    least where each has its share of the integral of |dJ/dn|^(2/3).
    """
    reduced = likelihood.reduced
    size = likelihood.size
    both = np.vstack([_STEP * np.eye(size), -_STEP * np.eye(size)])
    angle = _inside(likelihood, start.point + both)
    derivative = (angle[:size] - angle[size:]) / (2 * _STEP)
    reading_sd = likelihood.noise.white_sd * np.sqrt(reduced.count)
    scaled = root_of(start.covariance).T @ (derivative / reading_sd[:, None]).reshape(size, -1)
    step = np.linalg.norm(np.gradient(scaled, axis=1), axis=0)
    # A jump from one stretch to the next lies between blocks anyway.
    edges = (reduced.path.starts[1:, None] * FINE + np.array([-1, 0])).ravel()
    inner = np.setdiff1d(np.arange(step.size), edges)
    step = np.interp(np.arange(step.size), inner, step[inner])
    apart = np.repeat(reduced.count / FINE, FINE)
    wanted = np.maximum(uniform_filter1d(step, _BLUR), 0.0) ** (2 / 3) * apart ** (1 / 3)
    at = reduced.position[:, None] + reduced.count[:, None] * ((np.arange(FINE) + 0.5) / FINE - 0.5)
    samples = reduced.block_of.size
    gathered = np.interp(np.arange(samples + 1) - 0.5, at.ravel(), np.cumsum(wanted))
    return np.asarray(np.diff(gathered) / (gathered[-1] - gathered[0]))


def _inside(likelihood: LoopLikelihood, points: FloatArray) -> FloatArray:
    """Angles (draws, blocks, FINE) in rad at points (draws, size), along the inside of blocks."""
    course = replace(likelihood.reduced.course, path=likelihood.reduced.inside)
    angle = likelihood.at_course(course).angle(points)
    return angle.reshape(len(points), likelihood.blocks, -1)
