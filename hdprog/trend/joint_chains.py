"""Chains over all loops and the trend together.

The prior of a chain is the Gaussian step, its likelihood that step's weight. A sweep turns test
after test, given all others, and then all states by elliptical slices (Murray, Adams & MacKay,
AISTATS 2010); takes other hyperparameters under the same numbers z, or another z, as the Gaussian
step has them, and others under the same states, as the trend has them: where numbers hold one the
states let go (interweaving, Yu & Meng, J. Comput. Graph. Stat. 20 (2011) 531).

And it shifts tests by Metropolis steps: no loop knows where on its ridge it lies, and a slice in
all dimensions at once hardly moves there; chains without shifts agree with each other and are too
narrow. They go along paths of joint modes, and turn beside them (see `ridge_paths`); from a
threshold of the teeth to another (see `threshold_jump`); and by how far two other chains lie apart,
in the ridge coordinates of cup and teeth or of friction, test by test or in the mean of all, or in
everything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hdprog.physics.parameters import NAMES, FloatArray
from hdprog.trend.elliptical_slice import between, turned
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.gaussian_step import GaussianStep, Tangents
from hdprog.trend.hyperparameters import HyperparameterDraws
from hdprog.trend.ridge_frames import parts
from hdprog.trend.ridge_paths import RidgePath, Shift
from hdprog.trend.threshold_jump import jumped
from hdprog.trend.trend_density import believed
from hdprog.trend.written_out import WrittenOut, with_rows

_T_T = NAMES.index("T_T")
_WARM_UP, _WEIGHING = 15, 7  # sweeps, and those until all of the weight counts
_FIRST_SHARE = 0.05  # of the weight that counts in the first sweep
_LEARN = 5  # sweeps
_FRESH = 4  # sweeps from one offer of fresh numbers to the next
_LONG = np.array([0.5, 1.5, 5.0])  # strides along a path, in spreads of its place
_ANGLES = np.array([0.1, 0.3, 1.0])  # rad, of turns beside a path; each by half either way
_HEATED, _HEAT = 4, 0.15  # rounds in which only so much of the log density counts
_JUMPS = np.array([1.0, 3.0, 6.0])  # of a threshold, in its wear coordinate
_NEAR_NONE = 3.0  # spreads of the Gaussian step, from where a threshold is all but none
_FOLLOWED = 1  # how many shifts by other chains a sweep takes
_STEP = np.array([0.15, 0.4, 0.8])  # of two draws' difference; a Gaussian's best is 0.56
_ALONE = np.array([0.5, 1.5])  # the same of one hyperparameter alone, in its prior's spreads
_WRITTEN = 120  # numbers of all tests' states up to which all chains are offered others each sweep
_STRIDE = 2.4  # over the root of twice the dimensions: best for a Gaussian (ter Braak 2006)
_STRIDES = 0.7  # spread of the stride's logarithm
_ADAPT = 0.5  # of the stride's logarithm, by the share taken
_FOLLOWING = 0.25  # share of these moves that the stride is made for


class Chains:
    """Chains side by side; they are changed in place.

    Attributes
    ----------
    groups : of chains, of the same size and one after the other; those of different groups know
        nothing of where the others are
    sweeps : so far, the warm-up's included
    deviates : (chains, k) of the hyperparameters
    met : (chains, tests, n) what the tests met
    """

    def __init__(
        self,
        step: GaussianStep,
        draws: HyperparameterDraws,
        deviates: FloatArray,
        start: Tangents,
        groups: int,
        rng: np.random.Generator,
        paths: Sequence[RidgePath] = (),
    ) -> None:
        self._step, self._draws, self._rng, self._paths = step, draws, rng, paths
        self.groups, self.sweeps, self._share = groups, 0, 1.0
        self.deviates, self._at = deviates, WrittenOut.of(step, deviates)
        self._tangents, self._numbers = start, self._at.numbers_of(start)
        self._own = self._at.own
        self._weight, self.met = self._at.log_weight(start)
        maps, size = [test.ridge for test in step.tests], start.states.shape[-1]
        self._parts = parts(maps, size)
        low = self._at.centre - _NEAR_NONE * self._at.spread
        self._may_have_none = np.flatnonzero(np.median(low, axis=0)[_T_T::size] < 0.0).tolist()
        self._stride = np.full(len(self._parts), _STRIDE / np.sqrt(2.0 * start.states[0].size))

    def warm_up(self) -> None:
        """From the Gaussian step to the posterior: the weight comes in by and by.

        Meanwhile the Gaussians of the tests' own numbers are taken anew, as these are met.
        """
        lately: list[Tangents] = []
        for number in range(_WARM_UP):
            self._share = min(1.0, _FIRST_SHARE ** (1.0 - number / _WEIGHING))
            if number == _WEIGHING:
                self._spread_out()
            self.sweep()
            lately.append(self._tangents)
            if number % _LEARN == _LEARN - 1:
                self._learn_own(lately[-_LEARN:])
        self._share = 1.0

    def _spread_out(self) -> None:
        """Begin further apart than the posterior is along the paths.

        The Gaussian step is narrower there; chains that begin in it agree long before they are as
        wide as they should be.
        """
        for _ in range(_HEATED):
            for path in self._paths:
                self._go_along(path, _HEAT)

    def sweep(self) -> None:
        """Turn every test, then all; offer and vary hyperparameters; shift the tests."""
        for test in range(len(self._step.tests)):
            self._turn_test(test)
        self._turn_states()
        self._offer_others()
        if self.sweeps % _FRESH == 0:
            # Tails that a turn hardly finds are entered, and left, by draws of their own.
            fresh = self._rng.standard_normal(self._numbers.shape)
            self._offer(np.arange(len(fresh)), self.deviates, self._at, fresh)
        self._vary_hyperparameters()
        for path in self._paths:
            self._go_along(path)
            if path.turns:
                self._turn_beside(path)
        for test in self._may_have_none:
            self._jump(test)
        for place in self._rng.permutation(len(self._parts))[:_FOLLOWED]:
            taken = self._follow_others(place)
            if self.sweeps < _WARM_UP:
                self._stride[place] *= np.exp(_ADAPT * (taken - _FOLLOWING))
        self.sweeps += 1

    def _learn_own(self, lately: Sequence[Tangents]) -> None:
        """Take Gaussians of the tests' own numbers from draws; every chain stays where it is."""
        tests, here = [], self._tangents
        for place, test in enumerate(self._step.tests):
            if test.exact is not None and test.own.mean.size:
                departure = np.concatenate([one.states[:, place] - test.point for one in lately])
                met = np.concatenate([one.nuisances[place] for one in lately])
                test = replace(test, own=Nuisances.fitted(departure, met))
                now = here.states[:, place] - test.point
                self._numbers[:, self._own[place]] = test.own.deviates(now, here.nuisances[place])
            tests.append(test)
        self._step = replace(self._step, tests=tuple(tests))
        self._at = replace(self._at, step=self._step)
        self._weight, self.met = self._at.log_weight(here)

    def _turn_test(self, place: int) -> None:
        """One test's state and own numbers, which the Gaussian step has given all others."""
        rng, at, here, test = self._rng, self._at, self._tangents, self._step.tests[place]
        states, met, nuisances = here.states[:, place], self.met[:, place], here.nuisances[place]
        chains, count = states.shape
        block, own = slice(place * count, (place + 1) * count), self._own[place]
        centre, away = at.given_others(block, states, self._numbers[:, : at.size], rng)
        off = states - centre
        old, other = self._numbers[:, own], rng.standard_normal(nuisances.shape)
        trend = at.trend_of(block, np.stack([self.met, here.states]))

        def weighed(
            rows: NDArray[np.intp], there: FloatArray, nuisances: FloatArray
        ) -> tuple[FloatArray, FloatArray]:
            weight, found = self._step.log_weight_of(place, there, nuisances)
            with np.errstate(all="ignore"):
                bent, straight = trend(rows, np.stack([found - met[rows], there - states[rows]]))
                weight = weight + bent - straight
            weight = np.where(np.isnan(weight), -np.inf, weight)
            return weight, np.hstack([there, found, nuisances])

        def at_angles(rows: NDArray[np.intp], angle: FloatArray) -> tuple[FloatArray, FloatArray]:
            there = centre[rows] + between(off[rows], away[rows], angle)
            numbers = between(old[rows], other[rows], angle)
            return weighed(rows, there, test.own.draw(there - test.point, numbers))

        now = weighed(np.arange(chains), states, nuisances)
        angle, weight, found = turned(at_angles, now[0] + self._room(chains), now, rng)
        everywhere, owns = here.states.copy(), [*here.nuisances]
        everywhere[:, place], self.met[:, place], owns[place] = np.split(
            found, [count, 2 * count], axis=1
        )
        self._tangents = Tangents(everywhere, tuple(owns))
        self._weight = self._weight + (weight - now[0])
        self._numbers[:, own] = between(old, other, angle)
        self._numbers[:, : at.size] = at.numbers_of_states(everywhere)

    def _turn_states(self) -> None:
        """All states together; what is the tests' own follows as the Gaussian step has it."""
        rng, at, here = self._rng, self._at, self._tangents
        fresh, still = rng.standard_normal(self._numbers.shape), np.zeros_like(self._numbers)
        for own in self._own:
            fresh[:, own] = still[:, own] = self._numbers[:, own]
        centre, other = at.tangents(still), at.tangents(fresh)

        def at_angles(rows: NDArray[np.intp], angle: FloatArray) -> tuple[FloatArray, FloatArray]:
            three = (draws.rows(rows) for draws in (here, centre, other))
            start, middle, further = three
            return at.log_weight(start.turned(middle, further, angle), rows)

        height = self._weight + self._room(len(self._weight))
        now = (self._weight, self.met)
        angle, self._weight, self.met = turned(at_angles, height, now, rng)
        self._numbers = still + between(self._numbers - still, fresh - still, angle)
        self._tangents = here.turned(centre, other, angle)

    def _room(self, chains: int) -> FloatArray:
        """By how much the log weight (chains,) may fall, drawn for the share of it that counts."""
        return np.asarray(np.log(self._rng.uniform(size=chains)) / self._share)

    def _go_along(self, path: RidgePath, heat: float = 1.0) -> None:
        """Shift all tests along a path; `heat` as in `_go`."""
        rng, count = self._rng, len(self.deviates)
        by = path.spread * rng.choice(_LONG, count) * rng.standard_normal(count)
        self._go_by(path.along(self._tangents.states, by), heat)

    def _turn_beside(self, path: RidgePath) -> None:
        """Turn all tests about where they are on a path."""
        rng, count = self._rng, len(self.deviates)
        angle = rng.choice(_ANGLES, count) * rng.uniform(0.5, 1.5, count)
        fresh = rng.standard_normal((count, path.beside.shape[1]))
        self._go_by(path.turned(self._tangents.states, fresh, angle))

    def _go_by(self, shift: Shift, heat: float = 1.0) -> None:
        """Let all chains shift; how far they are from the modes, the tests' own numbers follow."""
        own = [
            at_mode + shift.beside[:, place] @ test.own.slope.T
            for place, (test, at_mode) in enumerate(zip(self._step.tests, shift.own, strict=True))
        ]
        self._go(np.arange(len(self.deviates)), shift.states, own, shift.log_volume, heat)

    def _jump(self, place: int) -> None:
        """Let one test's threshold jump."""
        rng, count, test = self._rng, len(self.deviates), self._step.tests[place]
        here = self._tangents
        by = rng.choice(_JUMPS, count) * rng.standard_normal(count)
        before, width = here.states[:, place], here.states.shape[2]
        there, volume = jumped(test.ridge, before, by)
        own = test.own.draw(there - test.point, self._numbers[:, self._own[place]])
        weight, found = self._step.log_weight_of(place, there, own)
        weight_before, _ = self._step.log_weight_of(place, before, here.nuisances[place])
        block = slice(place * width, (place + 1) * width)
        trend = self._at.trend_of(block, np.stack([self.met, here.states]))
        with np.errstate(all="ignore"):
            moved = np.stack([found - self.met[:, place], there - before])
            bent, straight = trend(np.arange(count), moved)
            change = weight - weight_before + bent - straight
        states, met = here.states.copy(), self.met.copy()
        states[:, place], met[:, place] = there, found
        numbers = self._numbers.copy()
        numbers[:, : self._at.size] = self._at.numbers_of_states(states)
        gained = self._share * change + volume + _log_normal(numbers) - _log_normal(self._numbers)
        rows = np.flatnonzero(np.log(rng.uniform(size=count)) < gained)
        nuisances = [*here.nuisances]
        nuisances[place] = own
        tangents = Tangents(states, tuple(nuisances)).rows(rows)
        self._take(rows, numbers[rows], tangents, (self._weight + change)[rows], met[rows])

    def _follow_others(self, place: int) -> float:
        """Shift all tests by a part of how far two other chains of the group lie apart.

        Half of a group after the other, by those that stay: what is likely is left as it is
        (ter Braak, Statistics and Computing 16 (2006) 239).
        """
        rng, count = self._rng, len(self.deviates)
        order = rng.permuted(np.arange(count).reshape(self.groups, -1), axis=1)
        taken = []
        for half in np.array_split(order, 2, axis=1):
            stay = np.setdiff1d(order, half).reshape(self.groups, -1)
            candidates = np.repeat(stay[:, None], half.shape[1], axis=1)
            one, other = np.moveaxis(rng.permuted(candidates, axis=2)[..., :2], -1, 0)
            apart = self._tangents.states[one.ravel()] - self._tangents.states[other.ravel()]
            stride = self._stride[place] * np.exp(_STRIDES * rng.standard_normal(half.size))
            shift = np.einsum("tisj,dsj->dti", self._parts[place], apart)
            taken.append(self._go(half.ravel(), stride[:, None, None] * shift))
        return float(np.mean(taken))

    def _go(
        self,
        rows: NDArray[np.intp],
        shift: FloatArray,
        own_shift: Sequence[FloatArray] | None = None,
        log_volume: FloatArray | float = 0.0,
        heat: float = 1.0,
    ) -> float:
        """Let some chains shift all tests' states (rows, tests, n); the share that does.

        The tests' own numbers are shifted by (tests) of (rows, k), or follow as the Gaussian step
        has them. A shift stretches volumes by `log_volume` (rows,). Of the log density `heat`
        counts.
        """
        states, at = self._tangents.states[rows] + shift, self._at
        if own_shift is None:
            tangents = self._step.own_drawn(states, [self._numbers[rows][:, n] for n in self._own])
        else:
            each = zip(self._tangents.nuisances, own_shift, strict=True)
            tangents = Tangents(states, tuple(own[rows] + more for own, more in each))
        numbers = at.numbers_of(tangents, rows)
        weight, met = at.log_weight(tangents, rows)
        gained = self._share * (weight - self._weight[rows])
        gained += _log_normal(numbers) - _log_normal(self._numbers[rows])
        height = heat * gained + log_volume
        taken = np.flatnonzero(np.log(self._rng.uniform(size=len(rows))) < height)
        self._take(rows[taken], numbers[taken], tangents.rows(taken), weight[taken], met[taken])
        return len(taken) / len(rows)

    def _offer_others(self) -> None:
        """Offer other hyperparameters, as the Gaussian step draws them."""
        rows = self._in_turn()
        deviates = self._draws.thinned(len(rows), self._rng)
        self._offer(rows, deviates, WrittenOut.of(self._step, deviates), self._numbers[rows])

    def _in_turn(self) -> NDArray[np.intp]:
        """Chains that take other hyperparameters now: all, or some where there are many tests.

        Writing the Gaussian step out costs the cube of all tests' numbers.
        """
        count = len(self.deviates)
        some = max(1, count * _WRITTEN // self._at.size)
        return np.arange(count) if some >= count else self._rng.permutation(count)[:some]

    def _vary_hyperparameters(self) -> None:
        """Vary the hyperparameters while the states stay; the loops have no say in it."""
        rng, rows = self._rng, self._in_turn()
        now = self.deviates[rows]
        deviates = now + self._variation(len(rows))
        inside = believed(deviates, self._step.steps_of(deviates)[0])
        rows, now, deviates = rows[inside], now[inside], deviates[inside]
        if not rows.size:
            return
        other = WrittenOut.of(self._step, deviates)
        courses = np.stack([self._tangents.states[rows], self.met[rows]])
        with np.errstate(all="ignore"):
            tangent, met = other.log_trend(courses) - self._at.having_only(rows).log_trend(courses)
            gained = tangent + self._share * (met - tangent)
            gained += _log_normal(deviates) - _log_normal(now)
            taken = np.log(rng.uniform(size=len(rows))) < gained
        taken &= np.isfinite(other.factor).all(axis=(1, 2))
        rows, deviates, change = rows[taken], deviates[taken], (met - tangent)[taken]
        self.deviates = with_rows(self.deviates, rows, deviates)
        self._at = self._at.having(rows, other, np.flatnonzero(taken))
        numbers = self._at.numbers_of_states(self._tangents.states[rows], rows)
        self._numbers[rows, : self._at.size] = numbers
        self._weight = with_rows(self._weight, rows, self._weight[rows] + change)

    def _variation(self, count: int) -> FloatArray:
        """(count, k): a part of how two draws differ, or one hyperparameter alone."""
        rng = self._rng
        one, other = np.split(self._draws.thinned(2 * count, rng), 2)
        together = rng.choice(_STEP, count)[:, None] * (one - other)
        alone = np.zeros_like(together)
        which = rng.integers(alone.shape[1], size=count)
        alone[np.arange(count), which] = rng.choice(_ALONE, count) * rng.standard_normal(count)
        return np.where(rng.uniform(size=(count, 1)) < 0.5, together, alone)

    def _offer(
        self, rows: NDArray[np.intp], deviates: FloatArray, at: WrittenOut, numbers: FloatArray
    ) -> None:
        """Let chains take what the Gaussian step draws, by the ratio of the weights."""
        tangents = at.tangents(numbers)
        weight, met = at.log_weight(tangents)
        taken = np.flatnonzero(self._room(len(rows)) < weight - self._weight[rows])
        self.deviates = with_rows(self.deviates, rows[taken], deviates[taken])
        if at is not self._at:
            self._at = self._at.having(rows[taken], at, taken)
        self._take(rows[taken], numbers[taken], tangents.rows(taken), weight[taken], met[taken])

    def _take(
        self,
        rows: NDArray[np.intp],
        numbers: FloatArray,
        tangents: Tangents,
        weight: FloatArray,
        met: FloatArray,
    ) -> None:
        """Put other numbers, and what belongs to them, in the place of some chains'."""
        self._numbers = with_rows(self._numbers, rows, numbers)
        self._weight = with_rows(self._weight, rows, weight)
        self.met = with_rows(self.met, rows, met)
        each = zip(self._tangents.nuisances, tangents.nuisances, strict=True)
        self._tangents = Tangents(
            with_rows(self._tangents.states, rows, tangents.states),
            tuple(with_rows(old, rows, new) for old, new in each),
        )


def _log_normal(numbers: FloatArray) -> FloatArray:
    """(chains,) of standard normal numbers (chains, k), up to a constant."""
    return np.asarray(-0.5 * np.sum(numbers**2, axis=1))
