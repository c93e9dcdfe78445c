"""Effective draws and R-hat across independent ensembles."""

from __future__ import annotations

import numpy as np
from emcee.autocorr import integrated_time

from hdprog.inference.diagnostics import autocorrelation_time, diagnose, fold
from hdprog.inference.sampler import EnsembleState, fresh_random_state, sample_ensembles


def gaussian(points: np.ndarray) -> np.ndarray:
    return -0.5 * (points**2).sum(axis=1)


def chains(seed: int, steps: int = 1200) -> np.ndarray:
    rng = np.random.default_rng(seed)
    state = EnsembleState(rng.standard_normal((4, 12, 4)), fresh_random_state(rng))
    return sample_ensembles(gaussian, state, steps).chains


def test_effective_draws_match_the_scatter_of_repeated_runs() -> None:
    """The variance of a run's mean is var/ESS: counted from runs against as diagnosed."""
    runs = [chains(seed) for seed in range(12)]
    means = np.array([run.mean(axis=(0, 1, 2)) for run in runs])
    from_scatter = 1.0 / (means**2).mean()  # 48 values: known to 1 ± 0.2
    diagnosed = np.mean([diagnose(run).ess_bulk.mean() for run in runs])
    # 3.5 standard errors of the scatter (false alarm 5e-4).
    assert 1 / 2.0 < diagnosed / from_scatter < 2.0
    step_by_step = runs[0].reshape(4, -1, 4)
    from hdprog.inference.lazy_arviz import arviz

    wrong = arviz().ess(step_by_step[:, :, 0], method="bulk")
    assert wrong > 3 * diagnosed, "folding step by step should overstate the effective draws"


def test_an_ensemble_that_went_elsewhere_is_seen() -> None:
    good = chains(50)
    assert diagnose(good).passes(400)
    bad = good.copy()
    bad[2, :, :, 1] += 0.5
    diagnosis = diagnose(bad)
    assert diagnosis.rhat[1] > 1.01
    assert not diagnosis.passes(400)


def test_fold_lays_walkers_end_to_end() -> None:
    series = np.arange(2 * 3 * 4 * 1, dtype=float).reshape(2, 3, 4, 1)
    np.testing.assert_array_equal(fold(series)[0, :3, 0], series[0, :, 0, 0])


def test_a_walker_that_never_moved_counts_as_long_memory() -> None:
    stuck = chains(3, steps=200)
    stuck[0, :, 0, 0] = 0.3
    assert autocorrelation_time(stuck)[0] > autocorrelation_time(stuck)[1]


def test_the_autocorrelation_time_is_emcees() -> None:
    rng = np.random.default_rng(12)
    chains = rng.standard_normal((4, 300, 10, 3))
    for step in range(1, 300):
        chains[:, step] += np.array([0.0, 0.7, 0.95]) * chains[:, step - 1]
    each = [integrated_time(chain, tol=0, quiet=True) for chain in chains]
    np.testing.assert_allclose(autocorrelation_time(chains), np.mean(each, axis=0), rtol=1e-9)
