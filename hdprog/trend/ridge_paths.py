"""Paths along which all tests may go together, bent as the posterior of loops and trend is.

No loop tells how cup and teeth share the compliance, or preload and friction their product, and
the trend holds the tests together: what they leave open all tests have in common. Along it the
posterior is many spreads long and bent, and a straight shift of all tests soon leaves it. A path
is made of the joint modes of loops and trend given the mean of one coordinate over all tests, its
place. From a state x with place κ to κ' the shift is M(κ') − M(κ), M the modes joined by straight
pieces. The place is linear in x and the shift hangs on nothing else: volumes stay as they are. The
tests' own numbers go along, from their mode at M(κ) to that at M(κ'): where preload and friction
share their product otherwise, a record begins at another place between its branches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.evidence import LoopEvidence
from hdprog.trend.gaussian_step import GaussianStep
from hdprog.trend.relinearise import (
    JointMode,
    JointPrior,
    joint_mode,
    joint_precision,
    laplace_evidence,
)

_LEFT_OPEN = ("K_F", "a", "T_T", "c", "T_i", "mu")
_HELD = 100.0  # spreads of a place's own within one of which it is held
_STRIDE, _GROWTH = 0.8, 1.25  # from mode to mode, in spreads of the place by Laplace's method
_SHORTEST = 0.15  # of them, below which a stride is not halved any more
_MODES, _STRIDES = 8, 12  # on either side of the joint mode, and strides to find them at most
_STEPS, _FIRST_STEPS = 3, 10  # of each climb, and of the first
_FALL = 6.0  # of the log evidence, where a path ends
_RISE = 1e-3  # of the place from one mode to the next, in spreads: a path does not turn back


@dataclass(frozen=True)
class RidgePath:
    """Joint modes given their place; N = tests·n.

    Attributes
    ----------
    share : (N,) of each number in the place
    places : (modes,) ascending
    tangents : (modes, N) the modes, on the tangents of the loops' ridges
    own : (tests) of (modes, k) the tests' own numbers at the modes
    spread : of the place, by the modes' evidence
    """

    share: FloatArray
    places: FloatArray
    tangents: FloatArray
    own: tuple[FloatArray, ...]
    spread: float

    def shifts(self, states: FloatArray, by: FloatArray) -> FloatArray:
        """Shifts (draws, tests, n) of states on the tangents that change places by (draws,)."""
        return self._gone(self.tangents, states, by).reshape(states.shape)

    def own_shifts(self, states: FloatArray, by: FloatArray) -> list[FloatArray]:
        """Shifts (tests) of (draws, k) of the tests' own numbers that go with `shifts`."""
        return [self._gone(numbers, states, by) for numbers in self.own]

    def _gone(self, modes: FloatArray, states: FloatArray, by: FloatArray) -> FloatArray:
        """What numbers (modes, m) change by (draws, m) where places of states do by (draws,)."""
        places = states.reshape(len(states), -1) @ self.share
        return np.asarray(self._at(modes, places + by) - self._at(modes, places))

    def _at(self, modes: FloatArray, places: FloatArray) -> FloatArray:
        """(draws, m) numbers (modes, m) at places (draws,); straight on past the ends."""
        piece = np.clip(np.searchsorted(self.places, places) - 1, 0, len(self.places) - 2)
        start, end = self.places[piece], self.places[piece + 1]
        along = ((places - start) / (end - start))[:, None]
        return np.asarray(modes[piece] + along * (modes[piece + 1] - modes[piece]))


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
    steps, scatter = step.steps_of(deviates[None])
    prior = JointPrior.of(steps, float(scatter[0]), step.wear_prior.scales)
    mode = joint_mode(tests, np.stack([test.point for test in step.tests]), prior, _FIRST_STEPS)
    covariance = np.linalg.inv(joint_precision(mode, prior))
    held, wide = list[_Held](), list[float]()
    for name in _LEFT_OPEN:
        each = np.zeros(prior.mean.shape)
        each[:, NAMES.index(name)] = 1.0 / len(each)
        share = each.ravel()
        wide.append(float(np.sqrt(share @ covariance @ share)))
        held.append(_Held(prior, share, (_HELD / wide[-1]) ** 2))
    count = len(held)
    found = spread(_path, [step] * count, held, [mode] * count, wide)
    return tuple(path for path in found if path is not None)


@dataclass(frozen=True)
class _Node:
    """A joint mode (tests, n) given its place, and the log density of that."""

    place: float
    points: FloatArray
    height: float


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
        return _Node(float(self.share @ mode.points.ravel()), mode.points, float(height))

    def at(self, place: float) -> JointPrior:
        """The prior given the place."""
        prior, share = self.prior, self.share
        precision = prior.precision + self.strength * np.outer(share, share)
        pull = prior.precision @ prior.mean.ravel() + self.strength * place * share
        mean = np.asarray(np.linalg.solve(precision, pull)).reshape(prior.mean.shape)
        return JointPrior(mean, precision)


def _path(step: GaussianStep, held: _Held, mode: JointMode, spread: float) -> RidgePath | None:
    """Path from the joint mode, its place so wide by Laplace's method; None where it does not go.

    Parameters
    ----------
    step : of all tests
    held : the trend's prior by place
    mode : of loops and trend
    spread : of the place
    """
    share, tests = held.share, [test.evidence for test in step.tests]
    first = held.node(mode, float(share @ mode.points.ravel()))
    down, up = (_one_way(tests, held, first, way * spread) for way in (-1.0, 1.0))
    nodes = [*down[::-1], first, *up]
    tangents = np.stack([step.on_tangents(node.points).ravel() for node in nodes])
    rising = _rising(tangents @ share, len(down), _RISE * spread)
    if rising.stop - rising.start < 2:
        return None
    nodes, tangents = nodes[rising], tangents[rising]
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
    return RidgePath(share, places, tangents, own, max(wide, spread))


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
