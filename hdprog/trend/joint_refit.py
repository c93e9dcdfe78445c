"""What every test met, and the hyperparameters with it, by the loops' own likelihoods.

Draws of the Gaussian step are weighted (see `gaussian_step`). Where Pareto k of the weights is low
they are drawn again by these (Vehtari et al., Journal of Machine Learning Research 25 (2024) 72).
Where it is not, all loops and the trend are sampled together: elliptical slice sampling (Murray,
Adams & MacKay, AISTATS 2010) of the numbers z of the Gaussian step, which turns each chain as far
along an ellipse as its weight allows, and Metropolis steps that take other hyperparameters under
the same z, or another z, drawn as the Gaussian step has them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hdprog.inference.diagnostics import diagnose
from hdprog.inference.lazy_arviz import arviz
from hdprog.physics.parameters import FloatArray
from hdprog.trend.gaussian_step import GaussianStep, StepAt, Tangents
from hdprog.trend.hyperparameters import HyperparameterDraws

HIGHEST_K = 0.5
"""Pareto k above which the weights have no variance. Up to 0.7 a mean may still be estimated, but
at 0.6 draws of these many dimensions were a third of a spread away from the posterior."""
_WEIGHTED = 4000
_GROUPS, _CHAINS = 4, 24  # chains are independent; R-hat is taken across groups of them
_WARM_UP = 12
_EVERY = 2  # sweeps between kept ones
_BRACKET = 2.0  # rad, first bracket of a slice
_SHRINKS = 60
RHAT_LIMIT = 1.1
"""On a hundred effective draws R-hat itself scatters by some hundredths."""
_FEWEST_EFFECTIVE = 400.0  # weighted draws


@dataclass(frozen=True)
class Effort:
    """How long to sample: sweeps kept at first, the bound to which they grow, ESS that ends them.

    Draws at the bound are trusted with `least` effective ones.
    """

    sweeps: int
    largest_sweeps: int
    ess: float
    least: float


FULL = Effort(100, 200, 120.0, 60.0)
QUICK = Effort(50, 100, 80.0, 50.0)


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
    chosen = rng.choice(_WEIGHTED, _GROUPS * _CHAINS, p=smoothed)
    chains = _Chains(step, draws, deviates[chosen], numbers[chosen], rng)
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
    for _ in range(_WARM_UP):
        chains.sweep()
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
        if enough or 2 * sweeps > effort.largest_sweeps:
            return found
        sweeps *= 2


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
        self._numbers = numbers
        self._take(deviates, step.at(deviates))

    def sweep(self) -> None:
        """Turn every chain along an ellipse; offer it other hyperparameters, then a fresh draw."""
        self._turn()
        deviates = self._draws.thinned(len(self.deviates), self._rng)
        self._offer(deviates, self._step.at(deviates), self._numbers)
        self._at = self._step.at(self.deviates)
        # Tails that a turn hardly finds are entered, and left, by draws of their own.
        self._offer(self.deviates, self._at, self._rng.standard_normal(self._numbers.shape))

    def _take(self, deviates: FloatArray, at: StepAt) -> None:
        self.deviates, self._at = deviates, at
        self._tangents = at.tangents(self._numbers)
        self._weight, self.met = at.log_weight(self._tangents)

    def _turn(self) -> None:
        rng, count = self._rng, len(self.deviates)
        fresh = rng.standard_normal(self._numbers.shape)
        centre = self._at.tangents(np.zeros_like(fresh))
        other = self._at.tangents(fresh)
        height = self._weight + np.log(rng.uniform(size=count))
        low = -_BRACKET * rng.uniform(size=count)
        high = low + _BRACKET
        angle, turning = rng.uniform(low, high), np.arange(count)
        for _ in range(_SHRINKS):
            if not turning.size:
                break
            at = self._at.rows(turning)
            some = (draws.rows(turning) for draws in (self._tangents, centre, other))
            here, middle, further = some
            weight, met = at.log_weight(here.turned(middle, further, angle[turning]))
            inside = weight > height[turning]
            there = turning[inside]
            self._weight[there], self.met[there] = weight[inside], met[inside]
            turning = turning[~inside]
            back = angle[turning] < 0
            low[turning] = np.where(back, angle[turning], low[turning])
            high[turning] = np.where(back, high[turning], angle[turning])
            angle[turning] = rng.uniform(low[turning], high[turning])
        angle[turning] = 0.0  # rounding alone keeps them out of a slice that holds where they are
        turned = np.cos(angle)[:, None] * self._numbers + np.sin(angle)[:, None] * fresh
        self._numbers = turned
        self._tangents = self._tangents.turned(centre, other, angle)

    def _offer(self, deviates: FloatArray, at: StepAt, numbers: FloatArray) -> None:
        """Take what is drawn as the Gaussian step has it, or stay, by the ratio of the weights."""
        tangents = at.tangents(numbers)
        weight, met = at.log_weight(tangents)
        taken = np.log(self._rng.uniform(size=len(deviates))) < weight - self._weight

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
