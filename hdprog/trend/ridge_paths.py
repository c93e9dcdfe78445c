"""Paths along which all tests may go together, bent as the posterior of loops and trend is.

No loop tells how cup and teeth share the compliance, or preload and friction their product, and
the trend holds the tests together: what they leave open all tests have in common. Along it the
posterior is many spreads long and bent, and a straight shift of all tests soon leaves it. A path
is made of the joint modes of loops and trend given the mean of one coordinate over all tests, its
place: M(κ). Beside a mode tests have room, by Laplace's method of covariance C C' in the numbers of
the same part of the drive. It differs along the path: teeth that are all but rigid may have any
stiffness, softer ones are held tight.

A state at place κ is M(κ) + C(κ) w and something across. It goes to M(κ') + C(κ') w, with what is
across as it was; or w is turned where it is, about zero. Modes and C are joined by straight pieces.
The place is linear in the state, so volumes change by |C(κ')|/|C(κ)|. The tests' own numbers go
along, from their mode at M(κ) to that at M(κ'): where preload and friction share their product
otherwise, a record begins at another place between its branches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.linalg.lapack import dtrtri

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.elliptical_slice import between
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.gaussian_step import GaussianStep, Test
from hdprog.trend.relinearise import (
    JointMode,
    JointPrior,
    joint_mode,
    joint_precision,
    laplace_evidence,
)

_STIFFNESS, _FRICTION = ("K_F", "K_W", "a", "b", "T_T"), ("K_W", "c", "T_i", "mu")
_LEFT_OPEN = {
    "K_F": _STIFFNESS,
    "K_W": _STIFFNESS,
    "T_T": _STIFFNESS,
    "c": _FRICTION,
    "T_i": _FRICTION,
    "mu": _FRICTION,
}
"""Coordinates whose means are places, with those that have room beside."""
_TURNED = ("T_T", "mu")
"""One path of each part: room beside another is as well beside this one."""
_HELD = 100.0  # spreads of a place's own within one of which it is held
_STRIDE, _GROWTH = 0.8, 1.25  # from mode to mode, in spreads of the place by Laplace's method
_SHORTEST = 0.15  # of them, below which a stride is not halved any more
_MODES, _STRIDES = 16, 24  # on either side of the joint mode, and strides to find them at most
_STEPS, _FIRST_STEPS = 3, 10  # of each climb, and of the first
_FALL = 6.0  # of the log evidence, where a path ends
_DIFFERENCE = 1e-5
_RISE = 1e-3  # of the place from one mode to the next, in spreads: a path does not turn back


@dataclass(frozen=True)
class Shift:
    """From states to others.

    Attributes
    ----------
    states : (draws, tests, n) their change
    beside : (draws, tests, n) what of it is not the mode's
    own : (tests) of (draws, k) change of the tests' own numbers at the mode
    log_volume : (draws,) that a proposal owes beside the ratio of densities
    """

    states: FloatArray
    beside: FloatArray
    own: tuple[FloatArray, ...]
    log_volume: FloatArray


@dataclass(frozen=True)
class RidgePath:
    """Joint modes given their place; N = tests·n, and m numbers beside.

    Attributes
    ----------
    share : (N,) of each number in the place
    places : (modes,) ascending
    tangents : (modes, N) the modes, on the tangents of the loops' ridges
    own : (tests) of (modes, k) the tests' own numbers at the modes
    beside : (N, m) orthonormal directions in which there is room, none of which changes the place
    roots : (modes, m, m) C, upper triangular
    spread : of the place, by the modes' evidence
    turns : whether what is beside is to be turned
    """

    share: FloatArray
    places: FloatArray
    tangents: FloatArray
    own: tuple[FloatArray, ...]
    beside: FloatArray
    roots: FloatArray
    spread: float
    turns: bool

    def along(self, states: FloatArray, by: FloatArray) -> Shift:
        """Take states (draws, tests, n) on the tangents so far that places change by (draws,)."""
        flat = states.reshape(len(states), -1)
        places = flat @ self.share
        here, there = self._between(places), self._between(places + by)
        before, after = (each.held().of(self.roots) for each in (here, there))
        off = (flat - here.of(self.tangents)) @ self.beside
        beside = (_times(after, _solved(before, off)) - off) @ self.beside.T
        shift = there.of(self.tangents) - here.of(self.tangents) + beside
        return Shift(
            shift.reshape(states.shape),
            beside.reshape(states.shape),
            tuple(there.of(each) - here.of(each) for each in self.own),
            _log_sizes(after) - _log_sizes(before),
        )

    def turned(self, states: FloatArray, fresh: FloatArray, angle: FloatArray) -> Shift:
        """Turn w of states (draws, tests, n) towards fresh numbers (draws, m) by angles (draws,).

        Standard normal numbers it leaves standard normal.
        """
        flat = states.reshape(len(states), -1)
        here = self._between(flat @ self.share)
        root = here.held().of(self.roots)
        off = (flat - here.of(self.tangents)) @ self.beside
        before = _solved(root, off)
        after = between(before, fresh, angle)
        beside = ((_times(root, after) - off) @ self.beside.T).reshape(states.shape)
        still = tuple(np.zeros((len(states), each.shape[1])) for each in self.own)
        return Shift(beside, beside, still, 0.5 * np.sum(after**2 - before**2, axis=1))

    def _between(self, places: FloatArray) -> _Between:
        """Modes between which places (draws,) lie."""
        piece = np.clip(np.searchsorted(self.places, places) - 1, 0, len(self.places) - 2)
        start, end = self.places[piece], self.places[piece + 1]
        return _Between(piece, (places - start) / (end - start))


@dataclass(frozen=True)
class _Between:
    """Two modes each: the number (draws,) of the first, and how far it is to the second (draws,).

    Below zero and above one they lie straight on past the ends of the path.
    """

    piece: NDArray[np.intp]
    way: FloatArray

    def held(self) -> _Between:
        """At the ends what is past them."""
        return _Between(self.piece, np.clip(self.way, 0.0, 1.0))

    def of(self, modes: FloatArray) -> FloatArray:
        """(draws, ...) of what modes (modes, ...) have."""
        way = self.way.reshape(-1, *(1,) * (modes.ndim - 1))
        return np.asarray(modes[self.piece] + way * (modes[self.piece + 1] - modes[self.piece]))


def _solved(roots: FloatArray, numbers: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.solve(roots, numbers[..., None])[..., 0])


def _times(roots: FloatArray, numbers: FloatArray) -> FloatArray:
    return np.asarray(np.matmul(roots, numbers[..., None])[..., 0])


def _log_sizes(roots: FloatArray) -> FloatArray:
    return np.asarray(np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1))


def ridge_paths(
    step: GaussianStep, deviates: FloatArray, spread: Callable[..., Iterable[Any]] = map
) -> tuple[RidgePath, ...]:
    """Paths of what loops leave open, one after the other or side by side.

    Parameters
    ----------
    step : of all tests
    deviates : (k,) of the hyperparameters, which are held meanwhile
    spread : map over the paths, e.g. an executor's
    """
    tests = [test.evidence for test in step.tests]
    prior = step.joint_prior(deviates)
    mode = joint_mode(tests, np.stack([test.point for test in step.tests]), prior, _FIRST_STEPS)
    covariance = np.linalg.inv(joint_precision(mode, prior))
    held, wide = list[_Held](), list[float]()
    for name in _LEFT_OPEN:
        share = _share(name, prior.mean.shape)
        wide.append(float(np.sqrt(share @ covariance @ share)))
        held.append(_Held(prior, share, (_HELD / wide[-1]) ** 2))
    count = len(held)
    found = spread(_path, [step] * count, _LEFT_OPEN, held, [mode] * count, wide)
    return tuple(path for path in found if path is not None)


def _share(name: str, shape: tuple[int, ...]) -> FloatArray:
    """(N,) of all numbers, of shape (tests, n), in a coordinate's mean over the tests."""
    each = np.zeros(shape)
    each[:, NAMES.index(name)] = 1.0 / len(each)
    return each.ravel()


@dataclass(frozen=True)
class _Node:
    """A joint mode (tests, n) given its place, its log density, and the precision (N, N)."""

    place: float
    points: FloatArray
    height: float
    precision: FloatArray


@dataclass(frozen=True)
class _Held:
    """The trend's prior with the place held; `share` as in `RidgePath`."""

    prior: JointPrior
    share: FloatArray
    strength: float

    def node(self, mode: JointMode, place: float) -> _Node:
        """A mode that was climbed to with this place."""
        middle = self.share @ self.prior.mean.ravel()
        variance = self.share @ np.linalg.solve(self.prior.precision, self.share)
        height = laplace_evidence(mode, self.at(place)) - 0.5 * (place - middle) ** 2 / variance
        precision = joint_precision(mode, self.prior)
        return _Node(float(self.share @ mode.points.ravel()), mode.points, float(height), precision)

    def at(self, place: float) -> JointPrior:
        """The prior given the place."""
        prior, share = self.prior, self.share
        precision = prior.precision + self.strength * np.outer(share, share)
        pull = prior.precision @ prior.mean.ravel() + self.strength * place * share
        mean = np.asarray(np.linalg.solve(precision, pull)).reshape(prior.mean.shape)
        return JointPrior(mean, precision)


def _path(
    step: GaussianStep, name: str, held: _Held, mode: JointMode, spread: float
) -> RidgePath | None:
    """Path from the joint mode, its place so wide by Laplace's method; None where it does not go.

    Parameters
    ----------
    step : of all tests
    name : of the coordinate whose mean is the place
    held : the trend's prior by place
    mode : of loops and trend
    spread : of the place
    """
    share, tests = held.share, [test.evidence for test in step.tests]
    first = held.node(mode, float(share @ mode.points.ravel()))
    down, up = (_one_way(tests, held, first, way * spread) for way in (-1.0, 1.0))
    nodes = [*down[::-1], first, *up]
    tangents = np.stack([step.on_tangents(node.points).ravel() for node in nodes])
    beside = _beside(name, mode.points.shape)
    roots = np.stack([_root(step, node, beside) for node in nodes])
    told = np.isfinite(roots).all(axis=(1, 2))
    rising = _rising(np.where(told, tangents @ share, np.nan), len(down), _RISE * spread)
    if rising.stop - rising.start < 2:
        return None
    nodes, tangents, roots = nodes[rising], tangents[rising], roots[rising]
    heights = np.array([node.height for node in nodes])
    places = tangents @ share
    # Each mode stands for the places that are nearer to it than to another.
    weight = np.exp(heights - heights.max()) * np.gradient(places)
    middle = weight @ places / weight.sum()
    wide = float(np.sqrt(weight @ (places - middle) ** 2 / weight.sum()))
    own = tuple(
        np.stack([test.own_at(node.points[number]) for node in nodes])
        for number, test in enumerate(step.tests)
    )
    turns = name in _TURNED
    return RidgePath(share, places, tangents, own, beside, roots, max(wide, spread), turns)


def _beside(name: str, shape: tuple[int, ...]) -> FloatArray:
    """Directions (N, m) of states of shape (tests, n) beside a coordinate's mean."""
    has_room = np.zeros(shape, dtype=bool)
    has_room[:, [NAMES.index(other) for other in _LEFT_OPEN[name]]] = True
    rows = np.flatnonzero(has_room)
    _, _, directions = np.linalg.svd(_share(name, shape)[None, rows])
    beside = np.zeros((has_room.size, rows.size - 1))
    beside[rows] = directions[1:].T
    return beside


def _root(step: GaussianStep, node: _Node, beside: FloatArray) -> FloatArray:
    """C (m, m) of states on the tangents about a mode, given all that is not beside it.

    Not numbers where the mode lies on no ridge.
    """
    each = zip(step.tests, node.points, strict=True)
    tangents = block_diag(*(_by_what_is_met(test, point) for test, point in each))
    try:
        met = np.linalg.solve(tangents, beside)
        lower = np.linalg.cholesky(met.T @ node.precision @ met)
    except np.linalg.LinAlgError:
        return np.full((beside.shape[1],) * 2, np.nan)
    return np.asarray(dtrtri(lower, lower=1)[0].T)


def _by_what_is_met(test: Test, point: FloatArray) -> FloatArray:
    """Derivative (n, n) of a state on the tangent by what the test met (n,)."""
    if test.exact is None:
        return np.eye(point.size)
    shift = _DIFFERENCE * np.eye(point.size)
    ahead, behind = (test.ridge.tangents_of(point + way * shift) for way in (1.0, -1.0))
    return np.asarray((ahead - behind).T / (2.0 * _DIFFERENCE))


def _one_way(
    tests: Sequence[LoopEvidence], held: _Held, first: _Node, spread: float
) -> list[_Node]:
    """Modes from the first one outwards, each climbed to from where the last two point."""
    found, before, here, top = list[_Node](), first, first, first.height
    stride = _STRIDE * spread
    for _ in range(_STRIDES):
        place, start = here.place + stride, here.points
        if before is not here:
            further = (place - here.place) / (here.place - before.place)
            start = start + further * (start - before.points)
        there = held.node(joint_mode(tests, start, held.at(place), _STEPS), place)
        if there.height < here.height - _FALL and abs(stride) > _SHORTEST * abs(spread):
            stride /= 2  # it went astray, or the path ends before
            continue
        found.append(there)
        before, here, top = here, there, max(top, there.height)
        stride *= _GROWTH
        if there.height < top - _FALL or len(found) == _MODES:
            break
    return found


def _rising(places: FloatArray, middle: int, least: float) -> slice:
    """Stretch about the middle along which places rise; what is not finite does not."""
    with np.errstate(invalid="ignore"):
        rises = np.diff(places) > least
    first = last = middle
    while first > 0 and rises[first - 1]:
        first -= 1
    while last < len(rises) and rises[last]:
        last += 1
    return slice(first, last + 1)
