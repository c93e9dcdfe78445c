"""All tests of a drive, side by side in worker processes: fitted, or fitted and explained."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from hdprog.config import Drive
from hdprog.data.drive_folder import DriveFolder, DriveTest
from hdprog.data.gross_errors import levelled
from hdprog.data.loop import Loop
from hdprog.discovery.explain import Closed, explain, sample_base, sample_final
from hdprog.discovery.search import Traced, trace
from hdprog.errors import BadInputError
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import Prepared, prepare
from hdprog.inference.priors import Prior
from hdprog.inference.sampling_plan import SamplingPlan
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.parallel import begin, spread_over
from hdprog.progress import Progress, untold
from hdprog.results import TestResult

Result = TypeVar("Result")


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


def with_rated_torque(folder: DriveFolder, loops: Sequence[Loop]) -> tuple[DriveFolder, str | None]:
    """Give a drive that declares no rated torque one that all its tests and forecasts refer to.

    It is the smallest of the tests' largest torques: at a larger one the figures of some test would
    be extrapolated.

    Parameters
    ----------
    folder : the drive
    loops : one a test

    Returns
    -------
    the folder to fit, and a remark for the report, None where the rated torque is declared

    Raises
    ------
    BadInputError
        where the tests' torque is more than any drive can have
    """
    drive = folder.drive
    if drive.rated_torque is not None:
        return folder, None
    largest = [float(np.abs(levelled(loop)[0].torque).max()) for loop in loops]
    rated = float(f"{min(largest):.3g}")
    which = "the test's largest torque"
    if len(loops) > 1:
        test = folder.tests[int(np.argmin(largest))].test_id
        which = (
            f"the smallest of the tests' largest torques (that of test {test}; the others reach up "
            f"to {max(largest):.3g} Nm)"
        )
    what = "figures of merit"
    if drive.reference_torque is not None:
        what = "lost motion and the stiffness at rated torque"
    remark = (
        f"The drive's rated torque is not given: {what} of every test and in forecasts refer to "
        f"{rated:g} Nm, {which}. Set rated_torque_Nm in drive.toml: without it a later test to "
        "less torque changes them all."
    )
    try:
        return replace(folder, drive=replace(drive, rated_torque=rated)), remark
    except BadInputError as error:
        raise BadInputError(
            f"a largest torque of {rated:g} Nm in every test or more, and no rated torque",
            str(folder.path),
            f"torques that a drive can have, for a rated torque: {error.expected}",
            "Check the unit of the torque.",
        ) from error


def fit_tests(
    folder: DriveFolder,
    loops: Sequence[Loop],
    prior: Prior,
    seeds: Sequence[np.random.SeedSequence],
    plan: SamplingPlan,
    executor: Executor | None,
    progress: Progress = untold,
) -> list[FittedTest]:
    """Fit every test with the drive model alone.

    Parameters
    ----------
    folder : the drive
    loops : one a test
    prior : shared by the tests
    seeds : one a test, so that the result does not depend on the workers
    plan : how long to sample
    executor : runs tests side by side; in this process if None
    progress : called with stage, done, total
    """
    count = len(loops)
    jobs = (loops, folder.tests, [folder.drive] * count, [prior] * count, seeds, [plan] * count)
    return list(_counted(spread_over(executor)(_fit, *jobs), "fits", count, progress))


def trace_tests(
    folder: DriveFolder,
    loops: Sequence[Loop],
    prior: Prior,
    seeds: Sequence[np.random.SeedSequence],
    executor: Executor | None,
    progress: Progress = untold,
) -> tuple[Traced, ...]:
    """Look for effects in all tests together; parameters as in `fit_tests`."""
    count, spread = len(loops), spread_over(executor)
    progress("effects", 0, 1)
    preparing, searching = zip(*(_children(seed)[:2] for seed in seeds), strict=True)
    prepared: list[Prepared] = list(
        spread(_prepare, loops, [folder.drive] * count, [prior] * count, preparing)
    )
    traced = trace(prepared, searching, spread=spread)
    progress("effects", 1, 1)
    return traced


def fit_and_close(
    folder: DriveFolder,
    traced: Sequence[Traced],
    seeds: Sequence[np.random.SeedSequence],
    plan: SamplingPlan,
    executor: Executor | None,
    progress: Progress = untold,
) -> tuple[list[FittedTest], Iterator[Closed]]:
    """Fit every test with what was found in it; parameters as in `fit_tests`.

    Each fit, once there, begins to be held against the drive model alone, which is waited for one
    by one: the trend goes on beside it, and is the last thing that is done of that stage.
    """
    count = len(traced)
    sampling, closing = zip(*(_children(seed)[2:] for seed in seeds), strict=True)
    fits = spread_over(executor)(_sample, traced, folder.tests, sampling, [plan] * count)
    fitted, closed = list[FittedTest](), list[Future[Closed]]()
    counted = _counted(fits, "fits", count, progress)
    for one, found, test, seed in zip(counted, traced, folder.tests, closing, strict=True):
        fitted.append(one)
        closed.append(begin(executor, _close, found, one.posterior, test, seed, count == 1))
    return fitted, _counted((one.result() for one in closed), "trend", count + 1, progress)


def _children(seed: np.random.SeedSequence) -> list[np.random.SeedSequence]:
    """Seeds of preparing, searching, sampling and closing; always the same ones."""
    entropy, key = seed.entropy, seed.spawn_key
    return [np.random.SeedSequence(entropy, spawn_key=(*key, number)) for number in range(4)]


def _counted(
    results: Iterable[Result], stage: str, total: int, progress: Progress
) -> Iterator[Result]:
    for number, one in enumerate(results, start=1):
        progress(stage, number, total)
        yield one


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


def _sample(
    traced: Traced, test: DriveTest, seed: np.random.SeedSequence, plan: SamplingPlan
) -> FittedTest:
    return FittedTest.of(sample_final(traced, np.random.default_rng(seed), plan), test)


def _close(
    traced: Traced,
    after: Posterior,
    test: DriveTest,
    seed: np.random.SeedSequence,
    alone: bool,
) -> Closed:
    rng = np.random.default_rng(seed)
    return explain(
        traced,
        sample_base(traced, rng),
        after,
        rng,
        test_id=test.test_id,
        service_hours=test.service_hours,
        weigh_others=alone,
    )
