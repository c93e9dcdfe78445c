"""All tests of a drive, side by side in worker processes: fitted, or fitted and explained."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.config import Drive
from hdprog.data.drive_folder import DriveFolder, DriveTest
from hdprog.data.loop import Loop
from hdprog.discovery.explain import Closed, explain, sample_both
from hdprog.discovery.search import Traced, trace
from hdprog.inference.fit_loop import SamplingPlan, fit_loop
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare
from hdprog.inference.priors import Prior
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.parallel import process_executor
from hdprog.results import TestResult

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class FittedTest:
    """A test's posterior and what is reported of it."""

    posterior: Posterior
    result: TestResult

    @staticmethod
    def of(posterior: Posterior, test: DriveTest) -> FittedTest:
        """Sum a posterior up."""
        meta: Mapping[str, str | float | None] = {
            "service_hours": test.service_hours,
            "date": None if test.date is None else str(test.date),
            "note": test.note,
            "event": test.event,
        }
        requests = figure_requests(posterior.drive, posterior.operation)
        return FittedTest(posterior, summarise(posterior, requests, test.test_id, meta))


def fit_tests(
    folder: DriveFolder,
    loops: Sequence[Loop],
    prior: Prior,
    seeds: Sequence[np.random.SeedSequence],
    plan: SamplingPlan,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> list[FittedTest]:
    """Fit every test with the drive model alone.

    Parameters
    ----------
    folder : the drive
    loops : one a test
    prior : shared by the tests
    seeds : one a test, so that the result does not depend on the workers
    plan : how long to sample
    workers : processes; one a core if None
    progress : called with stage, done, total
    """
    count = len(loops)
    fitted: list[FittedTest] = []
    with process_executor(workers) as executor:
        spread = map if executor is None else executor.map
        jobs = (loops, folder.tests, [folder.drive] * count, [prior] * count, seeds)
        for done in spread(_fit, *jobs, [plan] * count):
            fitted.append(done)
            if progress is not None:
                progress("fits", len(fitted), count)
    return fitted


def close_tests(
    folder: DriveFolder,
    loops: Sequence[Loop],
    prior: Prior,
    seeds: Sequence[np.random.SeedSequence],
    plan: SamplingPlan,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> tuple[tuple[Traced, ...], list[Closed]]:
    """Look for effects in all tests together, then fit each test with what was found.

    Parameters as in `fit_tests`. Where effects were found, the drive model alone is sampled
    quickly: it serves to show the shift.
    """
    count = len(loops)
    spawned = [seed.spawn(3) for seed in seeds]
    closed: list[Closed] = []
    with process_executor(workers) as executor:
        spread = map if executor is None else executor.map
        if progress is not None:
            progress("effects", 0, 1)
        prepared: list[Prepared] = list(
            spread(
                _prepare, loops, [folder.drive] * count, [prior] * count, [s[0] for s in spawned]
            )
        )
        traced = trace(prepared, [s[1] for s in spawned], spread=spread)
        if progress is not None:
            progress("effects", 1, 1)
        for done in spread(_close, traced, folder.tests, [s[2] for s in spawned], [plan] * count):
            closed.append(done)
            if progress is not None:
                progress("fits", len(closed), count)
    return traced, closed


def _fit(
    loop: Loop,
    test: DriveTest,
    drive: Drive,
    prior: Prior,
    seed: np.random.SeedSequence,
    plan: SamplingPlan,
) -> FittedTest:
    posterior = fit_loop(loop, drive, np.random.default_rng(seed), prior=prior, plan=plan)
    return FittedTest.of(posterior, test)


def _prepare(loop: Loop, drive: Drive, prior: Prior, seed: np.random.SeedSequence) -> Prepared:
    return prepare(loop, drive, np.random.default_rng(seed), prior=prior)


def _close(
    traced: Traced, test: DriveTest, seed: np.random.SeedSequence, plan: SamplingPlan
) -> Closed:
    rng = np.random.default_rng(seed)
    posteriors = sample_both(traced, rng, plan=plan)
    return explain(
        traced,
        posteriors,
        rng,
        test_id=test.test_id,
        service_hours=test.service_hours,
        weigh_others=False,
    )
