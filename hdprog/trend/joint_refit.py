"""What every test met, and the hyperparameters with it, by the loops' own likelihoods.

Draws of the Gaussian step are weighted (see `gaussian_step`). Where Pareto k of the weights is low
they are drawn again by these (Vehtari et al., Journal of Machine Learning Research 25 (2024) 72).
Where it is not, all loops and the trend are sampled together: elliptical slice sampling (Murray,
Adams & MacKay, AISTATS 2010) of the numbers z of the Gaussian step, which turns each chain as far
along an ellipse as its weight allows, first what is each test's own, test by test, then all states;
and Metropolis steps that take other hyperparameters under the same z, or another z, drawn as the
Gaussian step has them. Chains start from draws of that step, and the weight comes in by and by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hdprog.inference.diagnostics import diagnose
from hdprog.inference.lazy_arviz import arviz
from hdprog.physics.parameters import FloatArray
from hdprog.trend.elliptical_slice import between, turned
from hdprog.trend.exact_likelihood import Nuisances
from hdprog.trend.gaussian_step import GaussianStep, StepAt, Tangents, Test
from hdprog.trend.hyperparameters import HyperparameterDraws

HIGHEST_K = 0.5
"""Pareto k above which the weights have no variance. Up to 0.7 a mean may still be estimated, but
at 0.6 draws of these many dimensions were a third of a spread away from the posterior."""
_WEIGHTED = 4000
_GROUPS, _CHAINS = 4, 24  # chains are independent; R-hat is taken across groups of them
_WARM_UP = 20
_FIRST_SHARE = 0.05  # of the weight that counts in the first sweep
_LEARN = 5  # sweeps
_EVERY = 2  # sweeps between kept ones
_FRESH = 4  # sweeps from one offer of fresh numbers to the next
RHAT_LIMIT = 1.1
"""On a hundred effective draws R-hat itself scatters by some hundredths."""
_FEWEST_EFFECTIVE = 400.0  # weighted draws


@dataclass(frozen=True)
class Effort:
    """How long to sample: sweeps at first, the bound of sweeps, the ESS that ends them.

    They grow by half of the first ones. Draws at the bound are trusted with `least` effective ones.
    """

    sweeps: int
    largest_sweeps: int
    ess: float
    least: float


FULL = Effort(50, 100, 100.0, 60.0)
QUICK = Effort(40, 80, 80.0, 50.0)


@dataclass(frozen=True)
class Met:
    """Joint draws of the hyperparameters and of what every test met.

    Attributes
    ----------
    deviates : (draws, k) of the hyperparameters
    measured : (draws, tests, n) wear coordinates, scatter included
    pareto_k : of the Gaussian step's weights; None where the step is exact
    sampled : whether all loops and the trend were sampled together
    rhat, ess : worst of the joint sampling; None without it
    worth : effective draws of the hyperparameters; as many as the Gaussian step has if None
    converged : whether the draws may be trusted
    """

    deviates: FloatArray
    measured: FloatArray
    pareto_k: float | None = None
    sampled: bool = False
    rhat: float | None = None
    ess: float | None = None
    worth: float | None = None
    converged: bool = True

    def thinned(self, draws: int, rng: np.random.Generator) -> Met:
        """So many draws, without replacement where there are enough."""
        have = len(self.deviates)
        chosen = rng.choice(have, draws, replace=draws > have)
        return replace(self, deviates=self.deviates[chosen], measured=self.measured[chosen])


def met_by_tests(
    step: GaussianStep,
    draws: HyperparameterDraws,
    rng: np.random.Generator,
    effort: Effort,
) -> Met:
    """Draw hyperparameters and what every test met, given all loops as they are.

    Parameters
    ----------
    step : the Gaussian step
    draws : of the hyperparameters, by the Gaussian step
    rng : source of randomness
    effort : of the joint sampling
    """
    deviates = draws.thinned(_WEIGHTED, rng)
    numbers = rng.standard_normal((_WEIGHTED, step.numbers(deviates)))
    at = step.at(deviates)
    tangents = at.tangents(numbers)
    if step.gaussian:
        return Met(deviates, tangents.states)
    log_weight, met = at.log_weight(tangents)
    if not np.isfinite(log_weight).any():
        return Met(deviates, tangents.states, pareto_k=np.inf, converged=False)
    smoothed, pareto_k = _smoothed(log_weight)
    effective = float(1.0 / np.sum(smoothed**2))
    if pareto_k <= HIGHEST_K and effective > _FEWEST_EFFECTIVE:
        chosen = rng.choice(_WEIGHTED, _WEIGHTED, p=smoothed)
        return Met(deviates[chosen], met[chosen], pareto_k, worth=effective)
    # Draws by the Gaussian step as they are: wider than the posterior, and no two the same.
    start = np.resize(np.flatnonzero(np.isfinite(log_weight)), _GROUPS * _CHAINS)
    chains = _Chains(step, draws, deviates[start], numbers[start], rng)
    return _sampled(chains, pareto_k, effort)


def _smoothed(log_weight: FloatArray) -> tuple[FloatArray, float]:
    """Pareto-smoothed weights (draws,) that sum to one, and Pareto k."""
    finite = np.isfinite(log_weight)
    lowest = np.min(log_weight[finite], initial=0.0) - 700.0
    found, k = arviz().psislw(np.where(finite, log_weight, lowest))
    weight = np.exp(found - np.max(found))
    return weight / weight.sum(), float(k)


def _sampled(chains: _Chains, pareto_k: float, effort: Effort) -> Met:
    """Run until the draws may be trusted, or to the bound."""
    chains.warm_up()
    deviates: list[FloatArray] = []
    measured: list[FloatArray] = []
    sweeps = effort.sweeps
    while True:
        for number in range(len(deviates) * _EVERY, sweeps):
            chains.sweep()
            if number % _EVERY == _EVERY - 1:
                deviates.append(chains.deviates.copy())
                measured.append(chains.met.copy())
        found = _diagnosed(np.array(deviates), np.array(measured), pareto_k, effort)
        enough = found.converged and (found.ess or 0.0) >= effort.ess
        if enough or sweeps >= effort.largest_sweeps:
            return found
        sweeps = min(sweeps + effort.sweeps // 2, effort.largest_sweeps)


def _diagnosed(deviates: FloatArray, measured: FloatArray, pareto_k: float, effort: Effort) -> Met:
    """Put together (kept, chains, …), judged by hyperparameters and by what the last test met."""
    both = np.concatenate([deviates, measured[:, :, -1]], axis=-1)
    folded = both.reshape(len(both), _GROUPS, _CHAINS, -1).swapaxes(0, 1)
    found = diagnose(folded)
    rhat = float(found.rhat.max())
    effective = np.minimum(found.ess_bulk, found.ess_tail)
    ess, known = float(effective.min()), deviates.shape[-1]
    return Met(
        deviates.reshape(-1, deviates.shape[-1]),
        measured.reshape(-1, *measured.shape[2:]),
        pareto_k,
        sampled=True,
        rhat=rhat,
        ess=ess,
        worth=float(effective[:known].min()),
        converged=rhat < RHAT_LIMIT and ess >= effort.least,
    )


class _Chains:
    """Independent chains side by side; they are changed in place.

    Attributes
    ----------
    deviates : (chains, k) of the hyperparameters
    met : (chains, tests, n) what the tests met
    """

    def __init__(
        self,
        step: GaussianStep,
        draws: HyperparameterDraws,
        deviates: FloatArray,
        numbers: FloatArray,
        rng: np.random.Generator,
    ) -> None:
        self._step, self._draws, self._rng = step, draws, rng
        self._numbers, self._own = numbers, step.own_numbers(numbers.shape[1])
        self._sweeps, self._share = 0, 1.0
        self.deviates, self._at = deviates, step.at(deviates)
        self._tangents = self._at.tangents(numbers)
        self._weight, self.met = self._at.log_weight(self._tangents)

    def warm_up(self) -> None:
        """From the Gaussian step to the posterior: the weight comes in by and by.

        Meanwhile the Gaussians of the tests' own numbers are taken anew, as these are met.
        """
        lately: list[Tangents] = []
        for number in range(_WARM_UP):
            self._share = min(1.0, _FIRST_SHARE ** (1.0 - number / (0.6 * _WARM_UP)))
            self.sweep()
            lately.append(self._tangents)
            if number % _LEARN == _LEARN - 1:
                self._learn_own(lately[-_LEARN:])
        self._share = 1.0

    def sweep(self) -> None:
        """Turn what is each test's own, then the states; offer other hyperparameters."""
        self._turn_own()
        self._turn_states()
        deviates = self._draws.thinned(len(self.deviates), self._rng)
        self._offer(deviates, self._step.at(deviates), self._numbers)
        self._at = self._step.at(self.deviates)
        if self._sweeps % _FRESH == 0:
            # Tails that a turn hardly finds are entered, and left, by draws of their own.
            self._offer(self.deviates, self._at, self._rng.standard_normal(self._numbers.shape))
        self._sweeps += 1

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

    def _turn_own(self) -> None:
        """Every test by itself: for given states the weight is a product over the tests."""
        nuisances = list(self._tangents.nuisances)
        for place, test in enumerate(self._step.tests):
            if test.exact is not None and test.own.mean.size:
                nuisances[place] = self._own_turned(place, test)
        self._tangents = replace(self._tangents, nuisances=tuple(nuisances))

    def _own_turned(self, place: int, test: Test) -> FloatArray:
        own, state = self._own[place], self._tangents.states[:, place]
        old, nuisances = self._numbers[:, own], self._tangents.nuisances[place]
        other = self._rng.standard_normal(old.shape)

        def at_angles(rows: NDArray[np.intp], angle: FloatArray) -> tuple[FloatArray, FloatArray]:
            numbers = between(old[rows], other[rows], angle)
            drawn = test.own.draw(state[rows] - test.point, numbers)
            return test.log_ratio(state[rows], drawn)[0], drawn

        now, _ = test.log_ratio(state, nuisances)
        angle, new, drawn = turned(at_angles, now + self._room(), (now, nuisances), self._rng)
        self._numbers[:, own] = between(old, other, angle)
        self._weight = self._weight + (new - now)
        return drawn

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
            return at.rows(rows).log_weight(start.turned(middle, further, angle))

        height = self._weight + self._room()
        now = (self._weight, self.met)
        angle, self._weight, self.met = turned(at_angles, height, now, rng)
        self._numbers = still + between(self._numbers - still, fresh - still, angle)
        self._tangents = here.turned(centre, other, angle)

    def _room(self) -> FloatArray:
        """By how much the log weight (chains,) may fall, drawn for the share of it that counts."""
        return np.asarray(np.log(self._rng.uniform(size=len(self.deviates))) / self._share)

    def _offer(self, deviates: FloatArray, at: StepAt, numbers: FloatArray) -> None:
        """Take what is drawn as the Gaussian step has it, or stay, by the ratio of the weights."""
        tangents = at.tangents(numbers)
        weight, met = at.log_weight(tangents)
        taken = self._room() < weight - self._weight

        def chosen(new: FloatArray, old: FloatArray) -> FloatArray:
            return np.where(taken.reshape((-1,) + (1,) * (new.ndim - 1)), new, old)

        self.deviates = chosen(deviates, self.deviates)
        self._numbers = chosen(numbers, self._numbers)
        self._weight, self.met = chosen(weight, self._weight), chosen(met, self.met)
        each = zip(tangents.nuisances, self._tangents.nuisances, strict=True)
        self._tangents = Tangents(
            chosen(tangents.states, self._tangents.states),
            tuple(chosen(new, old) for new, old in each),
        )
