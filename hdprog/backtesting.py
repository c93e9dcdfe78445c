"""Backtest: how good a drive's forecasts would have been, from every earlier test."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.arguments import as_path, checked_seed
from hdprog.data.drive_folder import DriveFolder, files_of, read_drive_folder, read_test_loops
from hdprog.data.loop import Loop
from hdprog.data.truth_file import Truth, read_truth
from hdprog.drive_folders import drive_folders
from hdprog.errors import BadInputError
from hdprog.forecast.backtest import score_origin
from hdprog.forecast.backtest_pool import BacktestResult, DriveScores
from hdprog.forecast.horizon import require_horizon
from hdprog.forecast.what_came import seen_test
from hdprog.inference.posterior import Posterior
from hdprog.inference.prepare import scales_of
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import Prior
from hdprog.inference.sampling_plan import FULL, QUICK, SamplingPlan
from hdprog.outcome import WithReport, in_a_line
from hdprog.parallel import prepare_numerics, process_executor, spread_over
from hdprog.progress import Progress, untold
from hdprog.results import Provenance
from hdprog.tests_of_drive import fit_tests, with_rated_torque
from hdprog.trend.loop_evidence import FittedLoop
from hdprog.trend.wear_clock import load_hours_of
from hdprog.trend.wear_prior import read_wear_prior

_PACKAGES = ("numpy", "scipy", "emcee")


@dataclass(frozen=True, repr=False)
class Backtest(WithReport):
    """What a backtest hands back: scores, and files to write."""

    result: BacktestResult
    file = "backtest.json"

    def __repr__(self) -> str:
        """Return what this is, for a notebook; all numbers would fill pages."""
        return in_a_line(
            self, (drive.drive_id for drive in self.result.drives), converged=self.converged
        )

    @property
    def sentence(self) -> str:
        """The outcome in plain words."""
        from hdprog.reporting.backtest_words import headline

        said = [" ".join(headline(self.result))]
        said += [f"Left out: {name}: {reason}" for name, reason in self.result.left_out]
        return "\n".join(said)

    def document(self) -> dict[str, Any]:
        """Content of backtest.json (schema hdprog.backtest/1)."""
        from hdprog.reporting.backtest_json import backtest_json

        return backtest_json(self.result)

    def report(self) -> str:
        """Content of report.html."""
        from hdprog.reporting.backtest import build_backtest_report

        return build_backtest_report(self.result)


def backtest(
    path: str | Path,
    *,
    seed: int = 0,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Backtest:
    """Forecast from every earlier test of a drive, or of each of a fleet, and score it.

    Every loop is fitted once with the drive model alone, as `run(explain=False)` does: effects
    found by pooling the tests would let an early forecast know of later ones. From each test but
    the last the trend is fitted to the tests up to there.

    Parameters
    ----------
    path : a drive folder, or a folder with drive folders below it
    seed : of everything random; the result does not depend on the number of workers
    quick : fewer draws, marked as such
    workers : processes; one a core if None
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        for what is no path or no seed
    BadInputError
        for a drive folder that cannot be used, or where none below a folder can
    """
    path = as_path(path, "path", "the path of a drive folder, or of a folder with some below it")
    seed = checked_seed(seed)
    started = time.perf_counter()
    prepare_numerics()
    read: list[_ReadDrive] = []
    left_out: list[tuple[str, str]] = []
    folders = _of_drives(path)
    for folder in folders:
        try:
            read.append(_read(folder, folder.relative_to(path).as_posix()))
        except (BadInputError, OSError) as error:
            if folders == [path]:
                raise
            left_out.append((folder.relative_to(path).as_posix(), str(error)))
    if not read:
        raise BadInputError(
            "no drive that can be backtested",
            str(path),
            "at least one drive folder with limits and two tests",
            " ".join(f"{name}: {reason}" for name, reason in left_out),
        )
    seconds = {"reading": time.perf_counter() - started}
    drives = []
    for number, one in enumerate(read):
        heading = "" if len(read) == 1 else f"{one.name}: "
        drives.append(
            _backtest(one, [seed, number], quick, workers, _named(progress or untold, heading))
        )
    seconds["fits and forecasts"] = time.perf_counter() - started - seconds["reading"]
    files = {name: digest for one in read for name, digest in one.files.items()}
    provenance = Provenance.of(files, seed, quick, _PACKAGES)
    return Backtest(
        BacktestResult(path.resolve().name, tuple(drives), tuple(left_out), provenance, seconds)
    )


@dataclass(frozen=True)
class _ReadDrive:
    name: str
    folder: DriveFolder
    loops: list[Loop]
    prior: Prior
    remarks: tuple[str, ...]
    truth: Truth | None

    @property
    def files(self) -> dict[str, str]:
        """Digests of what was read, by its path from the folder of all drives."""
        each = files_of(self.folder, self.loops)
        return {(Path(self.name) / name).as_posix(): digest for name, digest in each.items()}


def _of_drives(path: Path) -> list[Path]:
    """The drive folder itself, or all below a folder."""
    if (path / "drive.toml").is_file() or not path.is_dir():
        return [path]
    found = drive_folders(path)
    if not found:
        raise BadInputError(
            "no drive.toml in it or below it",
            str(path),
            "a drive folder, or a folder with drive folders below it",
            "Give the path of a folder with drive.toml and tests.csv in it.",
        )
    return found


def _read(path: Path, name: str) -> _ReadDrive:
    """Read a drive whole, so that what cannot be used is known before the first fit."""
    folder = read_drive_folder(path)
    if not folder.drive.limits:
        raise BadInputError(
            "no limit",
            str(path / "drive.toml"),
            "at least one [[limits]] to forecast",
            "Add a limit on one of the figures of merit.",
        )
    if len({test.service_hours for test in folder.tests}) < 2:
        raise BadInputError(
            "one service hour",
            str(path / "tests.csv"),
            "tests at two or more service hours: one to forecast from, one to compare with",
            "Come back after the next test.",
        )
    require_horizon(folder.drive, folder.tests)
    loops = read_test_loops(folder)
    prior, on_prior = prior_of_drive(folder.drive, scales_of(loops[0]))
    truth = read_truth(path / "truth.json", folder.drive)
    folder, on_torque = with_rated_torque(folder, loops)
    remarks = tuple(remark for remark in (on_prior, on_torque) if remark is not None)
    return _ReadDrive(name, folder, loops, prior, remarks, truth)


def _named(progress: Progress, heading: str) -> Progress:
    return lambda stage, done, total: progress(heading + stage, done, total)


def _backtest(
    read: _ReadDrive,
    entropy: Sequence[int],
    quick: bool,
    workers: int | None,
    progress: Progress,
) -> DriveScores:
    """Fit the loops of a drive once, then forecast from each test but the last."""
    folder, drive, prior, count = read.folder, read.folder.drive, read.prior, len(read.loops)
    seeds = np.random.SeedSequence(list(entropy)).spawn(2 * count)
    plan: SamplingPlan = QUICK if quick else FULL
    wear_prior, origins = read_wear_prior(), []
    with process_executor(workers) as executor:
        fitted = fit_tests(folder, read.loops, prior, seeds[:count], plan, executor, progress)
        posteriors = [one.posterior for one in fitted]
        operation = posteriors[0].operation
        evidence = _evidence(folder, posteriors)
        seen = [
            seen_test(test.test_id, one, drive.limits, prior, operation)
            for test, one in zip(folder.tests, evidence, strict=True)
        ]
        # A test at the hours of the last one has nothing after it.
        known = [n for n in range(1, count) if seen[n - 1].service_hours < seen[-1].service_hours]
        spread = spread_over(executor)
        same = [[one] * len(known) for one in (seen, drive, prior, wear_prior, operation)]
        for done in spread(
            score_origin,
            [_known(folder, evidence, number) for number in known],
            *same,
            [read.truth] * len(known),
            [seeds[count + number] for number in known],
            [quick] * len(known),
        ):
            origins.append(done)
            progress("forecasts", len(origins), len(known))
    unfitted = tuple(one.result.test_id for one in fitted if not one.result.converged)
    name = folder.path.resolve().name if read.name == "." else read.name
    horizon = drive.forecast.horizon_hours
    return DriveScores(drive.id, name, count, horizon, unfitted, tuple(origins), read.remarks)


def _evidence(folder: DriveFolder, posteriors: Sequence[Posterior]) -> list[FittedLoop]:
    return [
        FittedLoop.of(posterior, test.service_hours, test.event, test.temperature_C)
        for test, posterior in zip(folder.tests, posteriors, strict=True)
    ]


def _known(folder: DriveFolder, evidence: Sequence[FittedLoop], count: int) -> list[FittedLoop]:
    """Evidence of the first tests, its hours by load counted from these tests alone."""
    loads = load_hours_of(folder.tests[:count])
    return [
        replace(one, load_hours=load) for one, load in zip(evidence[:count], loads, strict=True)
    ]
