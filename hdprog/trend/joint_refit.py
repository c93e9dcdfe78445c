"""What every test met, and the hyperparameters with it, by the loops' own likelihoods.

Draws of the Gaussian step are weighted (see `gaussian_step`). Where Pareto k of the weights is low
they are drawn again by these (Vehtari et al., Journal of Machine Learning Research 25 (2024) 72).
Where it is not, all loops and the trend are sampled together (see `joint_chains`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hdprog.inference.diagnostics import diagnose
from hdprog.inference.pareto_weights import pareto_weights, worth
from hdprog.parallel import begin, spread_over
from hdprog.physics.parameters import FloatArray
from hdprog.trend.gaussian_step import GaussianStep
from hdprog.trend.hyperparameters import HyperparameterDraws
from hdprog.trend.joint_chains import Chains
from hdprog.trend.ridge_paths import ridge_paths

GROUPS = 4
"""Of chains that know nothing of each other; R-hat compares them."""
HIGHEST_K = 0.5
"""Pareto k above which the weights have no variance. Up to 0.7 a mean may still be estimated, but
at 0.6 draws of these many dimensions were a third of a spread away from the posterior."""
_WEIGHTED = 4000
RHAT_LIMIT = 1.1
"""On a hundred effective draws R-hat itself scatters by some hundredths."""
_MOST_REMEMBERED = 0.4
"""Correlation of where chains are with where they were at first. Of a hundred chains that have
forgotten it, the highest of twenty quantities is about 0.2."""
_FEWEST_EFFECTIVE = 1000.0  # weighted draws: k of 4 000 scatters by 0.15, and low ones are no proof


@dataclass(frozen=True)
class Effort:
    """How long to sample: sweeps at first, the bound of sweeps, the ESS that ends them.

    They grow by half of the first ones, until that is reached and chains have forgotten where
    they began; without any, nothing is sampled. Draws at the bound are trusted with `least`
    effective ones. There are four groups of `chains`, in `parts` that may run side by side,
    whatever the cores: the draws depend on it.
    """

    sweeps: int
    largest_sweeps: int
    ess: float
    least: float
    chains: int = 24
    parts: int = 2


FULL = Effort(12, 100, 120.0, 60.0)
QUICK = Effort(12, 80, 120.0, 50.0)
NONE = Effort(0, 0, 0.0, 0.0)
"""For a forecast that another one is compared with: draws of the Gaussian step, weighted or not."""


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


def begin_meeting(
    step: GaussianStep,
    draws: HyperparameterDraws,
    rng: np.random.Generator,
    effort: Effort,
    executor: Executor | None = None,
) -> Callable[[], Met]:
    """Begin to draw hyperparameters and what every test met, given all loops as they are.

    It is waited for only when what this returns is called.

    Parameters
    ----------
    step : the Gaussian step
    draws : of the hyperparameters, by the Gaussian step
    rng : source of randomness
    effort : of the joint sampling
    executor : runs the parts of the joint sampling side by side; in this process if None
    """
    deviates = draws.thinned(_WEIGHTED, rng)
    numbers = rng.standard_normal((_WEIGHTED, step.numbers(deviates)))
    at = step.at(deviates)
    tangents = at.tangents(numbers)
    if step.gaussian:
        return partial(Met, deviates, tangents.states)
    log_weight, met = at.log_weight(tangents)
    if not np.isfinite(log_weight).any():
        return partial(Met, deviates, tangents.states, pareto_k=np.inf, converged=False)
    smoothed, pareto_k = pareto_weights(log_weight)
    effective = worth(smoothed)
    if pareto_k <= HIGHEST_K and effective > _FEWEST_EFFECTIVE:
        chosen = rng.choice(_WEIGHTED, _WEIGHTED, p=smoothed)
        return partial(Met, deviates[chosen], met[chosen], pareto_k, worth=effective)
    # Draws by the Gaussian step as they are: wider than the posterior, and no two the same.
    possible = np.flatnonzero(np.isfinite(log_weight))
    if effort.sweeps == 0:
        return partial(Met, deviates[possible], met[possible], pareto_k, converged=False)
    start = np.resize(possible, GROUPS * effort.chains)
    groups = GROUPS // effort.parts
    paths = ridge_paths(step, draws.flat.mean(axis=0), spread_over(executor))
    parts = [
        begin(
            executor,
            _first_run,
            Chains(step, draws, deviates[rows], tangents.rows(rows), groups, own, paths),
            effort.sweeps,
        )
        for rows, own in zip(np.split(start, effort.parts), rng.spawn(effort.parts), strict=True)
    ]
    return partial(_sampled, parts, pareto_k, effort, executor)


@dataclass(frozen=True)
class _Run:
    """Some sweeps of a part of the chains.

    Attributes
    ----------
    chains : where they stand
    deviates, measured : (sweeps, chains, k) and (sweeps, chains, tests, n)
    """

    chains: Chains
    deviates: FloatArray
    measured: FloatArray


def _first_run(chains: Chains, sweeps: int) -> _Run:
    chains.warm_up()
    return _run_on(chains, sweeps)


def _run_on(chains: Chains, sweeps: int) -> _Run:
    deviates, measured = [], []
    for _ in range(sweeps):
        chains.sweep()
        deviates.append(chains.deviates.copy())
        measured.append(chains.met.copy())
    return _Run(chains, np.array(deviates), np.array(measured))


def _sampled(
    parts: Sequence[Future[_Run]], pareto_k: float, effort: Effort, executor: Executor | None
) -> Met:
    """Run until the draws may be trusted, or to the bound."""
    deviates: list[FloatArray] = []
    measured: list[FloatArray] = []
    sweeps = effort.sweeps
    while True:
        runs = [part.result() for part in parts]
        deviates.append(np.concatenate([run.deviates for run in runs], axis=1))
        measured.append(np.concatenate([run.measured for run in runs], axis=1))
        kept = np.concatenate(deviates), np.concatenate(measured)
        found = _diagnosed(*kept, pareto_k, effort)
        enough = found.converged and (found.ess or 0.0) >= effort.ess
        enough &= _remembered(*kept) < _MOST_REMEMBERED
        if enough or sweeps >= effort.largest_sweeps:
            return found
        further = min(effort.sweeps // 2, effort.largest_sweeps - sweeps)
        parts = [begin(executor, _run_on, run.chains, further) for run in runs]
        sweeps += further


def _remembered(deviates: FloatArray, measured: FloatArray) -> float:
    """Highest correlation, over all chains, of where they are with where they were at first.

    R-hat and effective draws hardly tell chains that stand still, for there are many. Parameters
    as in `_diagnosed`.
    """
    both = np.concatenate([deviates, measured[:, :, -1]], axis=-1)[[0, -1]]
    off = both - both.mean(axis=1, keepdims=True)
    size = np.sqrt(np.sum(off**2, axis=1))
    with np.errstate(invalid="ignore"):
        return float(np.nanmax(np.sum(off[0] * off[1], axis=0) / np.prod(size, axis=0)))


def _diagnosed(deviates: FloatArray, measured: FloatArray, pareto_k: float, effort: Effort) -> Met:
    """Put together (kept, chains, …), judged by hyperparameters and by what the last test met."""
    both = np.concatenate([deviates, measured[:, :, -1]], axis=-1)
    folded = both.reshape(len(both), GROUPS, effort.chains, -1).swapaxes(0, 1)
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
