"""The paper's own identification: five points of a loop (29-34), then least squares (37).

It is the point estimate that the posterior stands beside. It takes the torque where the curve turns
straight for T_T, reads five points off the loading branch and moves μ and c·T_i until the squared
errors of both branches at positive torque are least. The paper chooses the points by hand; here a
rule does, and the answers of other points are kept, to show what hangs on the choice.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.reduce import ReducedLoop
from hdprog.errors import BadInputError
from hdprog.inference.prepare import prepare
from hdprog.physics.drive_model import slip_envelope, torsion_angle
from hdprog.physics.parameters import NAMES, FloatArray, in_support
from hdprog.physics.tooth_mesh import mesh_angle
from hdprog.results import PaperIdentification

_WINDOW = 0.1  # of the largest torque: the stretch of branch that a point is read off
_VISIBLE = 2.0  # times the noise: what the eye sees a curve leave a ruler by
_MOST_STEPS = 60  # of each search
_STEPS = 101  # torques at which it looks
_NO_THRESHOLD = 0.04  # of the largest torque: a threshold below it is none (38)
_NO_GROWTH = 1e-6  # 1/rad: as good as none, and the logarithm of it exists
_HALVINGS = 25
_TOLERANCE = 1e-3  # of the noise
_THIRD = 0.5  # of the first threshold of (26): torque of A3
_FOURTH, _FIFTH = 0.55, 0.9  # of the largest torque: A4, A5
_OTHER_CHOICES = ((0.4, 0.9), (0.55, 0.75))
_OTHER_THRESHOLDS = (0.6, 1.7)  # times T_T, as one eye or another may read it
_FIRST_GUESSES = ((0.05, -60.0), (0.09, -110.0))  # μ0 and (cT_i)0 of the search
_RIGID = 1e3  # times the loop's stiffness: a search that runs to infinity, and no cup or tooth
_IMPOSSIBLE = 1e6  # times the record's own variance: criterion outside the support


@dataclass(frozen=True)
class Branches:
    """Steady branches of the record, all cycles together.

    Attributes
    ----------
    reduced : the record
    offset : the encoder's zero, the middle of both branches at no load
    rising, falling : (blocks,) the blocks of each branch
    noise : of a block's angle in rad
    """

    reduced: ReducedLoop
    offset: float
    rising: NDArray[np.bool_]
    falling: NDArray[np.bool_]
    noise: float

    @cached_property
    def top(self) -> float:
        """Largest torque in Nm."""
        return float(self.reduced.path.torque.max())

    @cached_property
    def second(self) -> float:
        """Torque in Nm at which the loading branch crosses zero angle (A2)."""
        low, high = 0.0, self.top
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.read(middle) < 0 else (low, middle)
        return 0.5 * (low + high)

    def read(self, torque: float, rising: bool = True) -> float:
        """Angle in rad of a branch at a torque, by a parabola through its neighbours."""
        chosen = self.rising if rising else self.falling
        at, angle = self.reduced.path.torque[chosen], self.reduced.angle[chosen]
        distance = np.abs(at - torque)
        near = distance <= max(0.5 * _WINDOW * self.top, float(np.sort(distance)[:6].max()))
        curve = np.polyfit(at[near] - torque, angle[near], 2)
        return float(curve[2]) - self.offset


@dataclass(frozen=True)
class _Choice:
    """Where the points are read: A4, A5 as shares of the largest torque, and T_T in Nm."""

    fourth: float
    fifth: float
    threshold: float


def identify_record(loop: Loop, drive: Drive) -> PaperIdentification:
    """The paper's identification of a record as it was read; see `identify`.

    Nothing in it is random but the starts of the search that finds the record's spikes.
    """
    prepared = prepare(loop, drive, np.random.default_rng(0))
    noise = float(np.median(prepared.likelihood.noise.white_sd))
    return identify(prepared.likelihood.reduced, drive.alpha, noise, loop.source)


def identify(
    reduced: ReducedLoop, alpha: float, noise: float, source: str = "the record"
) -> PaperIdentification:
    """Parameters of a record by the paper's identification.

    Parameters
    ----------
    reduced : the record
    alpha : gear-tooth angle in rad
    noise : standard deviation of a block's angle in rad
    source : name of the record, for messages

    Raises
    ------
    BadInputError
        for a record without a loading branch that comes from negative torque, or one whose
        loading branch shows no friction at no load
    """
    branches = _branches(reduced, noise, source)
    threshold = _threshold(branches)
    choices = [_Choice(_FOURTH, _FIFTH, threshold)]
    choices += [_Choice(*pair, threshold) for pair in _OTHER_CHOICES]
    choices += [_Choice(_FOURTH, _FIFTH, factor * threshold) for factor in _OTHER_THRESHOLDS]
    choices = list(dict.fromkeys(choices))  # other readings of a threshold at 0 are the same one
    solved: list[Solved] = []
    told_by: list[_Choice] = []
    for choice in choices:
        near = [(found["mu"][0], found["c"][0] * found["T_i"][0]) for found, *_ in solved[:1]]
        if (answer := _searched(branches, choice, alpha, near or _FIRST_GUESSES)) is not None:
            solved.append(answer)
            told_by.append(choice)
    if not solved:
        raise BadInputError(
            "five points that no parameters fit (29-34)",
            source,
            "a loading branch below the unloading one at every torque, and points on it that "
            "finite stiffnesses can meet",
            "Look at the record with `hdprog check`, or fit it with --method posterior.",
        )
    parameters, error, points = solved[0]  # of the rule's own points, where they have an answer
    ranges = {
        name: (
            min(float(found[0][name][0]) for found in solved),
            max(float(found[0][name][0]) for found in solved),
        )
        for name in NAMES
    }
    return PaperIdentification(
        points=points,
        parameters={name: float(parameters[name][0]) for name in NAMES},
        other_choices=ranges,
        choices_tried=len(choices),
        choices_solved=len(solved),
        threshold_read=told_by[0].threshold,
        by_rule=told_by[0] is choices[0],
        rmse_rad=error,
    )


def _branches(reduced: ReducedLoop, noise: float, source: str) -> Branches:
    path = reduced.path
    whole = 0.5 * path.largest
    member = np.repeat(np.arange(path.starts.size), path.lengths)
    up = (path.rising & (path.began < -whole) & (path.reached > whole))[member]
    down = (~path.rising & (path.began > whole))[member]
    if not up.any() or not down.any():
        raise BadInputError(
            "no loading branch that comes from negative torque",
            source,
            "a two-sided loop: A1 is the loading curve's angle at no load (29)",
            "Record the loop to both signs of torque, or fit it with --method posterior.",
        )
    found = Branches(reduced, 0.0, up, down, noise)
    middle = 0.5 * (found.read(0.0) + found.read(0.0, rising=False))
    return replace(found, offset=middle)


def _threshold(branches: Branches) -> float:
    """Torque in Nm below which the loading branch leaves the ruler laid on its upper half."""
    torque = branches.reduced.path.torque
    straight = branches.rising & (torque >= 0.5 * branches.top)
    line = np.polyfit(torque[straight], branches.reduced.angle[straight] - branches.offset, 1)
    steps = np.linspace(0.5, 0.0, _STEPS) * branches.top
    away = [abs(branches.read(float(at)) - np.polyval(line, at)) for at in steps]
    left = np.flatnonzero(np.array(away) > _VISIBLE * branches.noise)
    return float(steps[left[0]]) if left.size else 0.0


Solved = tuple[dict[str, FloatArray], float, dict[str, tuple[float, float]]]


def _searched(
    branches: Branches,
    choice: _Choice,
    alpha: float,
    guesses: Sequence[tuple[float, float]],
) -> Solved | None:
    """The five points' parameters under the μ0 and (cT_i)0 that make (37) least."""
    chosen = branches.rising | branches.falling
    torque = branches.reduced.path.torque
    angle = branches.reduced.angle - branches.offset
    worst = _IMPOSSIBLE * float(np.var(angle))

    def criterion(guess: FloatArray) -> float:
        found = _from_points(branches, choice, alpha, math.exp(guess[0]), -math.exp(guess[1]))
        if found is None:
            return worst
        parameters = found[0]
        modelled = torsion_angle(
            branches.reduced.path, parameters, alpha, initial_fraction=np.array([0.5])
        )[0]
        return float(np.mean((angle - modelled)[chosen & (torque >= 0)] ** 2))

    runs = [
        minimize(
            criterion,
            [math.log(mu), math.log(-preload)],
            method="Nelder-Mead",
            options={
                "xatol": 1e-3,
                "fatol": _TOLERANCE * branches.noise**2,
                "maxiter": _MOST_STEPS,
            },
        )
        for mu, preload in guesses
    ]
    best = min(runs, key=lambda run: float(run.fun))
    mu, preload = math.exp(best.x[0]), -math.exp(best.x[1])
    found = _from_points(branches, choice, alpha, mu, preload)
    if found is None or best.fun >= worst:
        return None
    return found[0], math.sqrt(float(best.fun)), found[1]


def _from_points(
    branches: Branches, choice: _Choice, alpha: float, mu: float, preload: float
) -> tuple[dict[str, FloatArray], dict[str, tuple[float, float]]] | None:
    """(29)-(34) for given μ0 and (cT_i)0; None where the points contradict the model."""
    s, k = math.sin(alpha), math.cos(alpha)
    tangent = math.tan(alpha)
    first = branches.read(0.0)
    if first >= 0 or not 0 < mu < min(tangent, 1 / tangent):
        return None
    K_W = mu * preload * tangent / (first * (k - mu * s))  # (29)
    third = _THIRD * mu * -preload / (s + mu * k)
    width = branches.read(third, rising=False) - branches.read(third)
    c = width * K_W * (k - mu * s) / (2 * mu * third * tangent) + preload / third  # (30)
    if c >= 0:
        return None
    friction = {
        "K_W": np.array([K_W]),
        "c": np.array([c]),
        "T_i": np.array([preload / c]),  # (31)
        "mu": np.array([mu]),
    }
    torques = np.array([branches.second, choice.fourth * branches.top, choice.fifth * branches.top])
    angles = np.array([0.0, *(branches.read(float(torque)) for torque in torques[1:])])
    elastic = angles - tangent * slip_envelope(torques, friction, alpha)[0]
    if (elastic <= 0).any():
        return None
    springs = _springs(torques, elastic, choice.threshold, branches.top)
    if springs is None:
        return None
    parameters = {**friction, **springs}
    if not in_support(parameters, alpha).all():
        return None
    points = {
        "A1": (0.0, first),
        "A2": (float(torques[0]), 0.0),
        "A3": (third, width),
        "A4": (float(torques[1]), float(angles[1])),
        "A5": (float(torques[2]), float(angles[2])),
    }
    return parameters, points


def _springs(
    torques: FloatArray, elastic: FloatArray, threshold: float, top: float
) -> dict[str, FloatArray] | None:
    """K_F, a, b from elastic angles (3,) in rad at torques (3,) (32-34), or one K (38).

    None where a part would have to be rigid: the search runs to infinity then.
    """
    if threshold < _NO_THRESHOLD * top:
        stiffness = float(torques @ torques / (torques @ elastic))
        parts = {"K_F": 2 * stiffness, "a": _NO_GROWTH, "b": 2 * stiffness, "T_T": 0.0}
        return {name: np.array([value]) for name, value in parts.items()}
    T_T = np.array([[threshold]])

    def missed(logs: FloatArray) -> FloatArray:
        K_F, a, b = np.exp(logs)
        mesh = mesh_angle(torques, np.array([[a]]), np.array([[b]]), T_T)[0]
        return np.asarray((torques / K_F + mesh - elastic) / elastic)

    overall = float(torques[2] / elastic[2])
    start = np.log([2 * overall, overall / threshold, overall])
    found = np.exp(least_squares(missed, start, method="lm", max_nfev=60).x)
    if max(found[0], found[2]) > _RIGID * overall:
        return None
    parts = {"K_F": found[0], "a": found[1], "b": found[2], "T_T": threshold}
    return {name: np.array([value]) for name, value in parts.items()}
