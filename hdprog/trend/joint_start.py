"""Where the climb to the joint mode begins.

The mean of a posterior with two modes, or of one that is bent, may lie where its loop hardly fits,
and a climb from there may end on a foothill. So the tests' draws themselves are starts, too: a few
of the last test that lie far apart, each with those of the earlier tests that are nearest to it.

No loop tells the cup's stiffness from that of the teeth, and the cup, which does not wear, is one
in all tests: where teeth and cup share the compliance otherwise, there may be another mode, which
none of the loops by itself shows. So the best of the climbs is begun anew with other cups,
everything that the loops fix left as it is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.relinearise import JointMode, JointPrior, joint_mode, laplace_evidence
from hdprog.trend.ridge_map import RidgeMap
from hdprog.trend.wear_coordinates import from_loop

_K_F = NAMES.index("K_F")
_APART = 4  # starts of draws, beside that of the means
_STEPS = 10  # of each climb; the best one goes on
_DRAWS = 400
_CUPS = (-0.8, -0.4, 0.4, 0.8)  # of the stiffness's logarithm; the prior's spread is 0.4


def best_start(
    tests: Sequence[LoopEvidence],
    means: FloatArray,
    prior: JointPrior,
    sd: FloatArray,
    alpha: float,
    softplus_scale: float,
) -> JointMode:
    """Climb some way from several starts and take the one with the most evidence.

    Parameters
    ----------
    tests : in order
    means : (tests, n) wear coordinates, means of the tests' posteriors
    prior : of the coordinates, from the trend
    sd : (n,) by which distances count
    alpha : gear-tooth angle in rad
    softplus_scale : scale in Nm of the loops' coordinate of T_T
    """
    starts = [means]
    if all(test.exact is None for test in tests):
        return joint_mode(tests, means, prior, _STEPS)
    starts += _starts_of_draws([from_loop(test.posterior) for test in tests], sd)

    def best_of(starts: Sequence[FloatArray]) -> JointMode:
        climbed = [joint_mode(tests, start, prior, _STEPS) for start in starts]
        return max(climbed, key=lambda mode: laplace_evidence(mode, prior))

    best = best_of(starts)
    cup = best.points[:, _K_F].mean()
    ridges = [RidgeMap(point, alpha, softplus_scale) for point in best.points]
    other = best_of([np.array([one.with_cup(cup + more) for one in ridges]) for more in _CUPS])
    return max((best, other), key=lambda mode: laplace_evidence(mode, prior))


def _starts_of_draws(posteriors: Sequence[FloatArray], sd: FloatArray) -> list[FloatArray]:
    """(tests, n) each; neighbours in time lie close to each other."""
    thinned = [draws[:: max(1, len(draws) // _DRAWS)] for draws in posteriors]
    *earlier, last = thinned
    chosen: list[FloatArray] = [_nearest(last, last.mean(axis=0), sd)]
    while len(chosen) < _APART:
        away = np.min([_distances(last, one, sd) for one in chosen], axis=0)
        chosen.append(last[away.argmax()])
    starts = []
    for one in chosen:
        path = [one]
        for draws in reversed(earlier):
            path.append(_nearest(draws, path[-1], sd))
        starts.append(np.array(path[::-1]))
    return starts


def _distances(draws: FloatArray, point: FloatArray, sd: FloatArray) -> FloatArray:
    return np.asarray(np.sum(((draws - point) / sd) ** 2, axis=1))


def _nearest(draws: FloatArray, point: FloatArray, sd: FloatArray) -> FloatArray:
    return np.asarray(draws[_distances(draws, point, sd).argmin()])
