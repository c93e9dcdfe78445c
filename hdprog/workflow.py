"""The stages joined: fit a loop, close it with the data, run a drive."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from hdprog.arguments import as_path, checked_record, checked_seed, randomness, require_ids
from hdprog.config import Drive
from hdprog.data.drive_folder import files_of, read_drive_folder, read_test_loops
from hdprog.data.finished_runs import read_finished_runs
from hdprog.data.loop import Loop
from hdprog.data.record_name import record_name
from hdprog.discovery.drive import explain_drive
from hdprog.discovery.explain import Closed, sample_base, sample_final
from hdprog.discovery.explain import explain as explain_loop
from hdprog.discovery.search import trace
from hdprog.errors import UsageError
from hdprog.explanation import DriveExplanation
from hdprog.inference.fit_loop import fit_loop
from hdprog.inference.five_points import identify_record
from hdprog.inference.prepare import prepare, scales_of
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.sampling_plan import FULL, QUICK
from hdprog.inference.summarise import figure_requests, summarise
from hdprog.outcome import ExplainOutcome, Outcome, import_for_writing
from hdprog.parallel import (
    begin,
    prepare_numerics,
    process_executor,
    spread_over,
    while_waiting,
)
from hdprog.physics.effects import BY_ID
from hdprog.physics.effects.base import Effect
from hdprog.physics.figures import figures
from hdprog.progress import Progress, untold
from hdprog.results import DriveResult, Forecast, Provenance, TestResult, TrendSummary
from hdprog.tests_of_drive import fit_and_close, fit_tests, trace_tests, with_rated_torque

Method = Literal["posterior", "paper"]
METHODS: tuple[Method, ...] = ("posterior", "paper")
_PARTS = 2  # of the ensembles of a single record, whatever the cores: the draws depend on it
_LEAST_LOAD, _MOST_LOAD = 0.1, 3.0  # beyond, the makers' rule says nothing of this drive


def effects_named(ids: Sequence[str]) -> tuple[Effect, ...]:
    """Effects by their ids.

    Raises
    ------
    UsageError
        for an id that does not exist
    """
    wrong = [name for name in ids if name not in BY_ID]
    if wrong:
        raise UsageError(
            f"--effects: found {', '.join(wrong)}, expected ids out of {', '.join(BY_ID)}. "
            "Correct or leave out what is not among them."
        )
    return tuple(BY_ID[name] for name in dict.fromkeys(ids))


def fit(
    loop: Loop,
    drive: Drive | None = None,
    *,
    effects: tuple[str, ...] = (),
    method: Method = "posterior",
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
    method : "paper" puts the paper's own identification beside the posterior (29-37)
    rng : source of randomness; made from `seed` if None
    seed : of everything random where no `rng` is given; recorded as None where one is
    quick : fewer draws, marked as such
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        for an effect or a method that does not exist, effects beside the paper's method, a path
        where what was read of it belongs, or what is no generator or seed
    BadInputError
        for arrays that hold no loop, a prior that does not exist, an effect that the record
        cannot show, or a record that the paper's identification cannot be used on
    """
    require_ids(effects)
    chosen = effects_named(effects)
    _require_method(method, chosen)
    rng, recorded = randomness(rng, seed)
    loop, drive = checked_record(loop, drive)
    started = time.perf_counter()
    prepare_numerics()
    paper = identify_record(loop, drive) if method == "paper" else None
    with process_executor() as executor, while_waiting(executor, import_for_writing):
        posterior = fit_loop(
            loop,
            drive,
            rng,
            effects=chosen,
            plan=QUICK if quick else FULL,
            parts=_PARTS,
            executor=executor,
            progress=progress or untold,
        )
    requests = figure_requests(drive, posterior.operation)
    test = summarise(posterior, requests, _stem(loop), {})
    if paper is not None:
        values = {name: np.array([value]) for name, value in paper.parameters.items()}
        found = figures(requests, values, posterior.operation)
        own = {key: float(value[0]) for key, value in found.items()}
        test = replace(test, paper=replace(paper, figures=own))
    result = DriveResult(
        drive=drive,
        tests=(test,),
        trend=None,
        forecasts=(),
        warnings=(),
        provenance=Provenance.of({loop.source: loop.sha256}, recorded, quick),
        seconds={"fit": time.perf_counter() - started},
    )
    return Outcome(result, (posterior,), single=True)


def _require_method(method: str, effects: tuple[Effect, ...]) -> None:
    if method not in METHODS:
        raise UsageError(f"method: found {method!r}, expected one of {', '.join(METHODS)}")
    if method == "paper" and effects:
        raise UsageError(
            f"effects: found {', '.join(effect.id for effect in effects)} beside method 'paper', "
            "whose five points know of the drive model alone. Leave one of the two out."
        )


def explain(
    loop: Loop | str | Path,
    drive: Drive | None = None,
    *,
    rng: np.random.Generator | None = None,
    seed: int = 0,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> ExplainOutcome:
    """Close the loop: trace a record's residual to the effects that the drive model lacks.

    Parameters
    ----------
    loop : the record, or the path of a drive folder, whose tests are then pooled
    drive : what is declared of the drive of a record; nothing if None; a folder has its own
    rng : source of randomness for a record; made from `seed` if None; a folder takes `seed` alone
    seed : of everything random where no `rng` is given; recorded as None where one is
    quick : fewer draws, marked as such
    workers : processes for a drive folder; one a core if None
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        for a drive or a generator beside a drive folder, a path where what was read of it
        belongs, or what is no generator or seed
    BadInputError
        for anything that cannot be used
    """
    if not isinstance(loop, Loop):
        loop = as_path(loop, "loop", "a record that was read, or a drive folder's path")
    if isinstance(loop, Path) and (loop.is_dir() or (drive is None and not loop.is_file())):
        _require_folder_alone(drive, rng)
        whole = run(loop, seed=seed, quick=quick, workers=workers, progress=progress)
        return ExplainOutcome(whole.result, whole.posteriors, whole.single)
    rng, recorded = randomness(rng, seed)
    loop, drive = checked_record(loop, drive)
    started = time.perf_counter()
    prepare_numerics()
    plan = QUICK if quick else FULL
    prepared = prepare(loop, drive, rng)
    with process_executor(workers) as executor, while_waiting(executor, import_for_writing):
        entropy = np.random.SeedSequence(rng.integers(0, 2**32, size=4).tolist())
        spread = spread_over(executor)
        traced = trace([prepared], [entropy], spread=spread, inner=spread)[0]
        (progress or untold)("sampling", 0, 1)
        of_final, of_base = rng.spawn(2)
        after = begin(executor, sample_final, traced, of_final, plan)
        before = sample_base(traced, of_base)
        closed = explain_loop(traced, before, after.result(), rng, test_id=_stem(loop))
    requests = figure_requests(drive, prepared.operation)
    result = DriveResult(
        drive=drive,
        tests=(summarise(closed.after, requests, _stem(loop), {}),),
        trend=None,
        forecasts=(),
        warnings=(),
        provenance=Provenance.of({loop.source: loop.sha256}, recorded, quick),
        seconds={"explain": time.perf_counter() - started},
        explanation=closed.explanation,
    )
    return ExplainOutcome(result, (closed.after,), single=True)


def _require_folder_alone(drive: Drive | None, rng: np.random.Generator | None) -> None:
    if drive is not None:
        raise UsageError(
            "drive: found one beside a drive folder, whose drive.toml says these things. Leave it "
            "out, or give the loop that hdprog.read_loop reads."
        )
    if rng is not None:
        raise UsageError(
            "rng: found a generator beside a drive folder, whose tests draw from the seed, so that "
            "the result does not depend on the workers. Give seed instead."
        )


def run(
    path: str | Path,
    *,
    seed: int = 0,
    quick: bool = False,
    explain: bool = True,
    loads: Sequence[float] = (),
    fleet: str | Path | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Outcome:
    """The main job: fit every test of a drive folder, follow the trend, forecast its limits.

    Parameters
    ----------
    path : folder with drive.toml, tests.csv and the loops
    seed : of everything random; the result does not depend on the number of workers
    quick : fewer draws, marked as such
    explain : look for effects that the drive model lacks, and carry them where they are found
    loads : torques to come, as multiples of the torque so far, under each of which the limits are
        forecast too
    fleet : folder with finished runs of other drives below it, to learn pace, clock and scatter
        of wear from
    workers : processes; one a core if None
    progress : called with stage, done, total

    Raises
    ------
    UsageError
        for a load or a seed that cannot be
    BadInputError
        for anything in the folder that cannot be used, or a fleet without a finished run
    """
    from hdprog.forecast.horizon import require_horizon
    from hdprog.outlook_of_drive import begin_beside, begin_outlook, effects_to_follow
    from hdprog.trend.wear_prior import read_wear_prior

    loads, seed, progress = _checked_loads(loads), checked_seed(seed), progress or untold
    folder = read_drive_folder(as_path(path, "path", "a drive folder's path"))
    wear_prior, others = read_wear_prior(), None
    require_horizon(folder.drive, folder.tests)
    loops = read_test_loops(folder)
    if fleet is not None:
        others = read_finished_runs(
            Path(fleet),
            own_id=folder.drive.id,
            wear_prior=wear_prior.identity,
            own_records=files_of(folder, loops).values(),
        )
    seconds: dict[str, float] = {}
    started = time.perf_counter()
    prepare_numerics()
    declared = folder.drive
    prior, on_prior = prior_of_drive(declared, scales_of(loops[0]))
    folder, on_torque = with_rated_torque(folder, loops)
    seeds = np.random.SeedSequence(seed).spawn(len(loops) + 2)
    plan = QUICK if quick else FULL
    of_tests, explanation = seeds[:-2], None
    closing: Iterator[Closed] = iter(())
    with process_executor(workers) as executor, while_waiting(executor, import_for_writing):
        if explain:
            traced = trace_tests(folder, loops, prior, of_tests, executor, progress)
            fitted, closing = fit_and_close(folder, traced, of_tests, plan, executor, progress)
        else:
            fitted = fit_tests(folder, loops, prior, of_tests, plan, executor, progress)
        seconds["fits"] = time.perf_counter() - started
        posteriors = tuple(one.posterior for one in fitted)
        parts = len(folder.tests) + 1 if explain else 1
        progress("trend", 0, parts)
        started = time.perf_counter()
        lasting = effects_to_follow(folder, posteriors, wear_prior) if explain else ()
        shared = (wear_prior, others, seeds[-2:])
        # What is done here goes on beside the workers, which sample the trend behind the closing.
        ahead = begin_outlook(folder, posteriors, lasting, *shared, quick, executor)
        beside = None
        if explain:
            closed = list(closing)
            explanation = explain_drive(traced, closed, [test.event for test in folder.tests])
            if explanation.effects and folder.drive.limits:
                before = tuple(one.before for one in closed)
                beside = begin_beside(folder, before, *shared, executor)
        found = ahead.outlook(loads, beside)
        if explanation is not None:
            without = found.without_effects or found.forecasts
            explanation = _with_outlook(explanation, without, found.trend, found.forecasts)
    seconds["outlook"] = time.perf_counter() - started
    progress("trend", parts, parts)
    result = DriveResult(
        drive=declared,
        tests=tuple(one.result for one in fitted),
        trend=found.trend,
        forecasts=found.forecasts,
        warnings=tuple(remark for remark in (on_prior, on_torque) if remark is not None),
        provenance=Provenance.of(files_of(folder, loops), seed, quick),
        seconds=seconds,
        explanation=explanation,
        scenarios=found.scenarios,
    )
    return Outcome(result, posteriors, single=False)


def _checked_loads(loads: Sequence[float]) -> tuple[float, ...]:
    try:
        values = tuple(float(load) for load in loads)
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"loads: found {loads!r}, expected numbers in a tuple or a list. Write loads=(0.8,) "
            "for 80 %."
        ) from error
    wrong = [load for load in values if not _LEAST_LOAD <= load <= _MOST_LOAD]
    if wrong:
        raise UsageError(
            f"--load: found {', '.join(f'{load:g}' for load in wrong)}, expected torque to come "
            f"over torque so far, from {_LEAST_LOAD:g} to {_MOST_LOAD:g}. Give 0.8 for 80 %."
        )
    return values


def _with_outlook(
    explanation: DriveExplanation,
    without: tuple[Forecast, ...],
    trend: TrendSummary,
    forecasts: tuple[Forecast, ...],
) -> DriveExplanation:
    """What was found, with what the trend says of it, and forecasts without and with it."""
    came = {one.effect for one in trend.sudden}
    return replace(
        explanation,
        effects=tuple(
            replace(effect, origin="unclear") if effect.id in came else effect
            for effect in explanation.effects
        ),
        remaining_hours_before=_remaining(without),
        remaining_hours_after=_remaining(forecasts),
    )


def _remaining(forecasts: tuple[Forecast, ...]) -> dict[float, float | None] | None:
    """Hours to the first of all limits by level, or None without a limit."""
    return dict(forecasts[-1].remaining_hours) if forecasts else None


def _stem(loop: Loop) -> str:
    return record_name(Path(loop.source).name)


__all__ = ["Outcome", "TestResult", "explain", "fit", "run"]
