"""The stages joined: fit a loop, run a drive."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hdprog import __version__
from hdprog.atomic import atomic_directory
from hdprog.config import Drive
from hdprog.data.drive_folder import DriveFolder, DriveTest, read_drive_folder, read_test_loop
from hdprog.data.loop import Loop
from hdprog.errors import UsageError
from hdprog.inference.fit_loop import FULL, QUICK, fit_loop
from hdprog.inference.likelihood import Linearised
from hdprog.inference.posterior import Posterior
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import Prior, RecordScales
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.parallel import hold_blas_to_one_thread, process_executor
from hdprog.physics.parameters import FloatArray
from hdprog.results import DriveResult, Forecast, Provenance, TestResult, TrendSummary

if TYPE_CHECKING:
    from arviz import InferenceData

Progress = Callable[[str, int, int], None]
_PACKAGES = ("numpy", "scipy", "emcee", "arviz")


@dataclass(frozen=True)
class Outcome:
    """The result of a fit or a run, with its posteriors.

    Attributes
    ----------
    result : numbers ready to be written
    posteriors : one a test, in the order of `result.tests`
    single : a fit of one loop, not a drive's run
    """

    result: DriveResult
    posteriors: tuple[Posterior, ...]
    single: bool

    @property
    def tests(self) -> tuple[TestResult, ...]:
        """Results of the tests, by service hours."""
        return self.result.tests

    @property
    def trend(self) -> TrendSummary | None:
        """The trend over service hours; None for a single fit."""
        return self.result.trend

    @property
    def forecasts(self) -> tuple[Forecast, ...]:
        """First crossing of each limit, then of the first of them."""
        return self.result.forecasts

    @property
    def converged(self) -> bool:
        """Whether every fit and the trend converged."""
        return self.result.converged

    @property
    def verdict(self) -> str:
        """The outcome in plain words."""
        from hdprog.reporting.verdict import verdict

        return verdict(self.result).text

    @cached_property
    def idata(self) -> InferenceData:
        """Draws of a single fit as an ArviZ InferenceData.

        Raises
        ------
        UsageError
            for a run over several tests, where `idata_of` takes a test's name
        """
        if len(self.posteriors) != 1:
            raise UsageError("idata: this result has several tests; use idata_of(test_id)")
        return self.idata_of(self.tests[0].test_id)

    def idata_of(self, test_id: str) -> InferenceData:
        """Draws of one test as an ArviZ InferenceData."""
        from hdprog.inference.inference_data import inference_data

        names = [test.test_id for test in self.tests]
        if test_id not in names:
            raise UsageError(f"idata_of: found {test_id!r}, expected one of {', '.join(names)}")
        posterior = self.posteriors[names.index(test_id)]
        provenance = self.result.provenance
        attributes = {
            "hdprog_version": provenance.hdprog_version,
            "seed": "not recorded" if provenance.seed is None else provenance.seed,
            "command": provenance.command,
            "source_file": posterior.loop.source,
            "source_sha256": posterior.loop.sha256,
        }
        rng = np.random.default_rng(provenance.seed or 0)  # of prior and predictive draws only
        return inference_data(posterior, rng, attributes)

    def summary(self) -> dict[str, Any]:
        """Content of summary.json (schema hdprog.summary/1)."""
        from hdprog.reporting.summary import summary_json

        return summary_json(self.result)

    def write(self, out: str | Path, command: str = "Python API") -> None:
        """Write summary.json, report.html and the posteriors; files appear whole or not at all."""
        from dataclasses import replace

        from hdprog.reporting.build import build_report

        provenance = replace(self.result.provenance, command=command)
        stamped = replace(self, result=replace(self.result, provenance=provenance))
        with atomic_directory(Path(out)) as folder:
            summary = json.dumps(stamped.summary(), indent=1, allow_nan=False)
            (folder / "summary.json").write_text(summary + "\n", "utf-8")
            (folder / "report.html").write_text(
                build_report(stamped.result, self.posteriors[0].prior.catalogue), "utf-8"
            )
            if not self.single:
                (folder / "posteriors").mkdir()
            for test in self.tests:
                name = "posterior.nc" if self.single else f"posteriors/{test.test_id}.nc"
                stamped.idata_of(test.test_id).to_netcdf(
                    str(folder / name), engine="h5netcdf", compress=False
                )


@dataclass(frozen=True)
class _TestEvidence:
    """A fitted test as the trend takes it: its likelihood, relinearised wherever asked."""

    service_hours: float
    event: str | None
    load_hours: float | None
    temperature_C: float | None
    fitted: Posterior
    variance: float = field(init=False)
    logit: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "variance", float(np.mean(self.fitted.noise_scale**2)))
        object.__setattr__(self, "logit", float(np.mean(self.fitted.chains[..., -1])))

    @property
    def posterior(self) -> FloatArray:
        """(draws, 8) unconstrained coordinates."""
        return self.fitted.coordinates

    def linearise(self, coordinates: FloatArray) -> Linearised:
        """Information form of the likelihood at coordinates (8,)."""
        return self.fitted.likelihood.linearise(coordinates, self.variance, self.logit)


def fit(
    loop: Loop,
    drive: Drive | None = None,
    *,
    effects: tuple[str, ...] = (),
    rng: np.random.Generator | None = None,
    seed: int = 0,
    quick: bool = False,
    progress: Progress | None = None,
) -> Outcome:
    """Posterior of one loop.

    Parameters
    ----------
    loop : the record
    drive : what is declared of the drive; nothing if None
    effects : ids of effects to fit beside the drive model
    rng : source of randomness; made from `seed` if None
    seed : of everything random where no `rng` is given; recorded as None where one is
    quick : fewer draws, marked as such
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        for effects, which this version does not fit
    BadInputError
        for a prior that does not exist
    """
    if effects:
        raise UsageError(
            f"effects: found {', '.join(effects)}; this version fits the drive model alone. "
            "Leave effects out."
        )
    started = time.perf_counter()
    hold_blas_to_one_thread()
    drive = Drive.default() if drive is None else drive
    recorded = seed if rng is None else None
    rng = np.random.default_rng(seed) if rng is None else rng
    with process_executor() as executor:
        posterior = fit_loop(
            loop, drive, rng, plan=QUICK if quick else FULL, executor=executor, progress=progress
        )
    requests = figure_requests(drive, posterior.operation)
    test = summarise(posterior, requests, Path(loop.source).name.split(".")[0], {})
    result = DriveResult(
        drive=drive,
        tests=(test,),
        trend=None,
        forecasts=(),
        warnings=(),
        provenance=_provenance(recorded, quick, [loop]),
        seconds={"fit": time.perf_counter() - started},
    )
    return Outcome(result, (posterior,), single=True)


def run(
    path: str | Path,
    *,
    seed: int = 0,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Outcome:
    """The main job: fit every test of a drive folder, follow the trend, forecast its limits.

    Parameters
    ----------
    path : folder with drive.toml, tests.csv and the loops
    seed : of everything random; the result does not depend on the number of workers
    quick : fewer draws, marked as such
    workers : processes; one a core if None
    progress : called with stage, done, total

    Raises
    ------
    BadInputError
        for anything in the folder that cannot be used
    """
    from hdprog.forecast.crossing import forecast, require_horizon_ahead
    from hdprog.trend.trend import fit_trend
    from hdprog.trend.wear_prior import read_wear_prior

    folder = read_drive_folder(Path(path))
    settings = folder.drive.forecast
    require_horizon_ahead(folder.tests[-1].service_hours, settings.horizon_hours)
    loops = [read_test_loop(folder, test) for test in folder.tests]
    seconds: dict[str, float] = {}
    started = time.perf_counter()
    hold_blas_to_one_thread()
    prior, remark = prior_of_drive(folder.drive, RecordScales.of(loops[0].torque, loops[0].angle))
    seeds = np.random.SeedSequence(seed).spawn(len(loops) + 2)
    fitted = _fit_tests(folder, loops, prior, seeds, quick, workers, progress)
    seconds["fits"] = time.perf_counter() - started
    posteriors = tuple(posterior for posterior, _ in fitted)
    tests = tuple(test for _, test in fitted)
    evidence = _evidence(folder, posteriors)
    if progress is not None:
        progress("trend", 0, 1)
    started = time.perf_counter()
    trend = fit_trend(
        evidence,
        prior,
        read_wear_prior(),
        np.random.default_rng(seeds[-2]),
        quick=quick,
        alpha=folder.drive.alpha,
    )
    seconds["trend"] = time.perf_counter() - started
    started = time.perf_counter()
    rng = np.random.default_rng(seeds[-1])
    forecasts = forecast(trend, folder.drive, posteriors[0].operation, rng)
    summary = trend.summary(folder.drive, posteriors[0].operation, rng)
    seconds["forecast"] = time.perf_counter() - started
    if progress is not None:
        progress("trend", 1, 1)
    result = DriveResult(
        drive=folder.drive,
        tests=tests,
        trend=summary,
        forecasts=forecasts,
        warnings=(remark,) if remark else (),
        provenance=_provenance(seed, quick, loops),
        seconds=seconds,
    )
    return Outcome(result, posteriors, single=False)


def _fit_test(
    loop: Loop,
    test: DriveTest,
    drive: Drive,
    prior: Prior,
    seed: np.random.SeedSequence,
    quick: bool,
) -> tuple[Posterior, TestResult]:
    """Fit one test of a drive; runs in a worker process."""
    plan = QUICK if quick else FULL
    posterior = fit_loop(loop, drive, np.random.default_rng(seed), prior=prior, plan=plan)
    meta: Mapping[str, str | float | None] = {
        "service_hours": test.service_hours,
        "date": None if test.date is None else str(test.date),
        "note": test.note,
        "event": test.event,
    }
    requests = figure_requests(drive, posterior.operation)
    return posterior, summarise(posterior, requests, test.test_id, meta)


def _fit_tests(
    folder: DriveFolder,
    loops: list[Loop],
    prior: Prior,
    seeds: list[np.random.SeedSequence],
    quick: bool,
    workers: int | None,
    progress: Progress | None,
) -> list[tuple[Posterior, TestResult]]:
    count = len(loops)
    jobs = (loops, folder.tests, [folder.drive] * count, [prior] * count, seeds[:count])
    fitted = []
    with process_executor(workers) as executor:
        spread = map if executor is None else executor.map
        for done in spread(_fit_test, *jobs, [quick] * count):
            fitted.append(done)
            if progress is not None:
                progress("fits", len(fitted), count)
    return fitted


def _evidence(folder: DriveFolder, posteriors: tuple[Posterior, ...]) -> tuple[_TestEvidence, ...]:
    return tuple(
        _TestEvidence(test.service_hours, test.event, None, test.temperature_C, posterior)
        for test, posterior in zip(folder.tests, posteriors, strict=True)
    )


def _provenance(seed: int | None, quick: bool, loops: list[Loop]) -> Provenance:
    return Provenance(
        hdprog_version=__version__,
        seed=seed,
        quick=quick,
        command="Python API",
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        versions={name: version(name) for name in _PACKAGES},
        files={loop.source: loop.sha256 for loop in loops},
    )
