"""Convergence of independent ensembles.

Walkers of one ensemble depend on each other, so R-hat is taken across ensembles only. Each
ensemble's walkers are laid end to end: then a walker's own memory is counted, which folding step by
step would hide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from hdprog.inference.lazy_arviz import arviz
from hdprog.physics.parameters import FloatArray

RHAT_LIMIT = 1.01
_WINDOW = 5.0
LENGTHS = 50.0  # chain length in autocorrelation times


@dataclass(frozen=True)
class Diagnostics:
    """Diagnostics of a set of quantities, each array (quantities,)."""

    rhat: FloatArray
    ess_bulk: FloatArray
    ess_tail: FloatArray

    def at_most(self, draws: float) -> Diagnostics:
        """The same of draws that are worth no more than so many."""
        bulk, tail = np.minimum(self.ess_bulk, draws), np.minimum(self.ess_tail, draws)
        return Diagnostics(self.rhat, bulk, tail)

    def passes(self, required_ess: float) -> bool:
        """Whether every quantity mixed and has enough effective draws."""
        return bool(
            (self.rhat < RHAT_LIMIT).all()
            and (self.ess_bulk >= required_ess).all()
            and (self.ess_tail >= required_ess).all()
        )


def autocorrelation_time(chains: FloatArray) -> FloatArray:
    """Integrated autocorrelation time in steps, (quantities,), mean over ensembles.

    Parameters
    ----------
    chains : (ensembles, steps, walkers, quantities)
    """
    steps = chains.shape[1]
    # All walkers at once: emcee's own function transforms one series a call.
    series = np.ascontiguousarray(chains.transpose(0, 3, 2, 1))
    series -= series.mean(axis=-1, keepdims=True)
    length = next_fast_len(2 * steps, real=True)
    power = np.abs(rfft(series, length)) ** 2
    with np.errstate(invalid="ignore"):
        correlation = irfft(power, length)[..., :steps]
        correlation /= correlation[..., :1]
        summed = 2 * np.cumsum(correlation.mean(axis=2), axis=-1) - 1
        # Sokal's window: the first lag that is five times the time summed up to it.
        beyond = np.arange(steps) >= _WINDOW * summed
    last = np.where(beyond.any(axis=-1), beyond.argmax(axis=-1), steps - 1)
    times = np.take_along_axis(summed, last[..., None], axis=-1)[..., 0]
    # A walker that never moved has no autocorrelation: its memory is as long as the chain.
    return np.asarray(np.mean(np.where(np.isfinite(times), times, steps), axis=0))


def fold(chains: FloatArray) -> FloatArray:
    """Lay each ensemble's walkers end to end.

    (ensembles, steps, walkers, quantities) → (ensembles, walkers·steps, quantities)
    """
    ensembles, steps, walkers, quantities = chains.shape
    return chains.transpose(0, 2, 1, 3).reshape(ensembles, walkers * steps, quantities)


def diagnose(chains: FloatArray) -> Diagnostics:
    """Rank-normalised split R-hat across ensembles, bulk and tail ESS, by ArviZ.

    Vehtari et al., Bayesian Analysis 16 (2021) 667.

    Parameters
    ----------
    chains : (ensembles, steps, walkers, quantities)
    """
    stats = arviz()
    folded = fold(chains)
    count = folded.shape[-1]
    rhat, bulk, tail = np.empty(count), np.empty(count), np.empty(count)
    for index in range(count):
        series = folded[:, :, index]
        rhat[index] = stats.rhat(series, method="rank")
        bulk[index] = stats.ess(series, method="bulk")
        tail[index] = stats.ess(series, method="tail", prob=0.9)
    return Diagnostics(rhat, bulk, tail)
