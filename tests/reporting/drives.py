"""Synthetic results in every situation that a report must put into words.

Loops come from the project's own physics with noise; summaries are invented around the truth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hdprog.config import Drive, ForecastSettings, Limit
from hdprog.data.loop import Loop
from hdprog.inference.noise import WHITE
from hdprog.physics.drive_model import predict
from hdprog.physics.figures import FigureRequest, Operation, figures, standard_requests
from hdprog.results import (
    LEVELS,
    DriveResult,
    FigureTrend,
    Forecast,
    LoopFit,
    ParameterDraws,
    ParameterSummary,
    Provenance,
    ReadOff,
    TestResult,
    TrendSummary,
)

NEW = {
    "K_F": 78197.8,
    "K_W": 101837.5,
    "a": 1833.5,
    "b": 60000.0,
    "T_T": 1.0,
    "c": -1.177,
    "T_i": 115.5,
    "mu": 0.066,
}
WORN = {**NEW, "K_W": 98548.7, "b": 5729.6, "T_T": 30.0, "c": -1.152, "T_i": 70.2, "mu": 0.076}
OPERATION = Operation(math.radians(30.0), 63.0, 63.0, (14.0, 48.0))
LOST_MOTION = Limit("lost_motion_arcmin", 2.0, "above")
SECANT = Limit("secant_stiffness_Nm_per_rad", 12000.0, "below", 14.0)
WIDTH = Limit("hysteresis_width_arcmin", 0.30, "below")
SHUTDOWN = 1500.0


def drive(
    *limits: Limit, drive_id: str = "cell3-axis2", shutdown: float | None = SHUTDOWN
) -> Drive:
    return Drive(
        id=drive_id,
        model="CSF-25-80",
        ratio=80.0,
        alpha_declared=True,
        rated_torque=63.0,
        limits=limits,
        forecast=ForecastSettings(20_000.0, 0.05, shutdown),
    )


def worn_by(wear: float) -> dict[str, float]:
    """Parameters at a wear between 0 (new) and 1 (worn), along a straight line in the logs."""
    return {name: NEW[name] * (WORN[name] / NEW[name]) ** wear for name in NEW}


def cycle(amplitude: float, samples: int, cycles: int = 2) -> np.ndarray:
    """Triangular torque from zero, up first."""
    phase = np.linspace(0.0, cycles, samples, endpoint=False)
    return amplitude * 2 / math.pi * np.arcsin(np.sin(2 * math.pi * phase))


def loop_fit(
    loop: Loop, parameters: dict[str, float], blocks: int, residual_scale: float
) -> LoopFit:
    size = len(loop) // blocks
    whole = blocks * size
    reduce = lambda values: values[:whole].reshape(blocks, size).mean(axis=1)  # noqa: E731
    torque, angle = reduce(loop.torque), reduce(loop.angle)
    fitted = reduce(predict(loop.torque, parameters)) + 1e-3
    noise = np.full(blocks, residual_scale / math.sqrt(size))
    return LoopFit(
        torque=torque,
        angle=angle,
        count=np.full(blocks, float(size)),
        fitted=fitted,
        low=fitted - 0.4 * noise,
        high=fitted + 0.4 * noise,
        residual=angle - fitted,
        noise=noise,
        position=(np.arange(blocks) + 0.5) * size,
    )


def by_level(draws: np.ndarray) -> dict[float, float]:
    return {level: float(np.quantile(draws, level)) for level in LEVELS}


def one_test(
    number: int,
    hours: float | None,
    wear: float,
    owner: Drive,
    *,
    samples: int = 2400,
    converged: bool = True,
    **changes: object,
) -> TestResult:
    """One test of a drive with a given wear; `changes` replace fields of the result."""
    rng = np.random.default_rng(number)
    truth = worn_by(wear)
    torque = cycle(63.0, samples)
    angle = predict(torque, truth) + 1e-3 + 1e-5 * rng.standard_normal(samples)
    loop = Loop(torque, angle, source=f"t{number:02d}.csv", sha256=f"{number:064x}")
    fit = loop_fit(loop, truth, 240, 1e-5)
    spread = {name: abs(value) * 0.02 for name, value in truth.items()}
    draws = {name: value * np.exp(0.02 * rng.standard_normal(400)) for name, value in truth.items()}
    requests = [*standard_requests(OPERATION), FigureRequest("secant_stiffness_Nm_per_rad", 14.0)]
    told = figures(requests, draws, OPERATION)
    uninformed = ("a", "T_T") if wear < 0.2 else ()
    result = TestResult(
        test_id=f"t{number:02d}",
        service_hours=hours,
        date=None if hours is None else f"2026-0{1 + number % 9}-01",
        note=None,
        event=None,
        loop=loop,
        drive=owner,
        prior_name="csf-25-80",
        converged=converged,
        parameters={
            name: ParameterSummary(
                mean=float(draws[name].mean()),
                sd=spread[name],
                quantiles=by_level(draws[name]),
                rhat=1.003 if converged else 1.14,
                ess_bulk=1840.0 if converged else 61.0,
                ess_tail=1520.0 if converged else 48.0,
                contraction=0.04 if name in uninformed else 0.97,
            )
            for name in truth
        },
        figures={key: by_level(values) for key, values in told.items()},
        figures_with_effects={},
        effects=(),
        fit=fit,
        rmse_rad=float(np.std(angle - predict(torque, truth) - 1e-3)),
        noise_floor_rad=1e-5,
        outlier_fraction=0.0,
        residual_correlation=0.03,
        noise_model=WHITE,
        diagnostics={
            "ensembles": 4.0,
            "walkers": 32.0,
            "warm_up_steps": 500.0,
            "steps": 1200.0,
            "autocorrelation_time": 21.4,
            "acceptance": 0.31,
        },
        warnings=(),
        draws=ParameterDraws(
            draws,
            {name: value * np.exp(0.5 * rng.standard_normal(800)) for name, value in NEW.items()},
        ),
    )
    return replace(result, **changes)  # type: ignore[arg-type]


def read_off(test: TestResult, missed: str = "") -> TestResult:
    """The test with width, loss and lost motion read off its record, one of them missed by half."""
    found = {}
    for key in ("hysteresis_width_arcmin", "hysteresis_loss_J", "lost_motion_arcmin"):
        middle = test.figures[key][0.50]
        record = middle * (0.5 if key == missed else 1.005)
        found[key] = ReadOff(record, 0.01 * middle, test.figures[key], key == missed)
    return replace(test, read_off=found)


def forecast_of(
    limit: Limit | None,
    crossings: np.ndarray,
    now: float,
    *,
    risk: float = 0.05,
    horizon: float = 20_000.0,
    shutdown: float | None = SHUTDOWN,
) -> Forecast:
    """Forecast from draws of the service hour of the crossing (inf where it never comes)."""
    grid = np.linspace(now, horizon, 400)
    share = np.searchsorted(np.sort(crossings), grid, side="right") / crossings.size
    inside = np.sort(crossings)

    def quantile(level: float) -> float | None:
        at = float(inside[min(int(level * crossings.size), crossings.size - 1)])
        return None if at > horizon else max(at - now, 0.0)

    early = quantile(risk)
    return Forecast(
        limit=limit,
        now_hours=now,
        already_crossed=bool(share[0] > 0.5),
        acceptable_risk=risk,
        horizon_hours=horizon,
        inspect_before_hours=None if early is None else now + early,
        probability_crossed_by_shutdown=(
            None if shutdown is None else float(np.mean(crossings <= shutdown))
        ),
        probability_crossed_by_horizon=float(share[-1]),
        remaining_hours={level: quantile(level) for level in LEVELS},
        crossing_probability=np.column_stack([grid, share]),
    )


def trend_of(
    limit: Limit, tests: Sequence[TestResult], crossing_hours: float, spread: float
) -> FigureTrend:
    """Fan that runs from the first test's value and meets the limit about an hour."""
    first = tests[0].service_hours or 0.0
    now = tests[-1].service_hours or 0.0
    start = tests[0].figures[limit.key][0.50]
    hours = np.linspace(first, 20_000.0, 300)
    speed = (limit.threshold - start) / max(crossing_hours - first, 1.0)
    deviate = np.array([-1.645, -0.674, 0.0, 0.674, 1.645])
    width = abs(speed) * spread * np.maximum(hours - now, 0.0) / abs(crossing_hours - now)
    middle = start + speed * (hours - first)
    tight = 0.01 * abs(limit.threshold)
    quantiles = middle + deviate[:, None] * (tight + width)
    own = np.array([[test.figures[limit.key][level] for test in tests] for level in LEVELS])
    own += np.array([start + speed * ((t.service_hours or 0.0) - first) for t in tests]) - own[2]
    return FigureTrend(
        limit.key, hours, quantiles, np.array([t.service_hours or 0.0 for t in tests]), own
    )


def trend_summary(
    figures_: dict[str, FigureTrend], *, converged: bool = True, carried: tuple[str, ...] = ()
) -> TrendSummary:
    levels = {0.05: 0.2, 0.25: 0.4, 0.5: 0.61, 0.75: 0.8, 0.95: 1.3}
    return TrendSummary(
        model="One wear coordinate moves all parameters along a power-law clock, with random wear "
        "and a scatter from mounting to mounting",
        hyperparameters={"wear_rate": levels, "clock_exponent": levels, "volatility": levels},
        carried_by_prior=carried,
        figures=figures_,
        diagnostics={},
        converged=converged,
        warnings=(),
    )


PROVENANCE = Provenance(
    hdprog_version="0.1.0",
    seed=7,
    quick=False,
    command="hdprog run cell3-axis2 --seed 7",
    created="2026-03-02T05:58:00+00:00",
    versions={"numpy": "2.4.6", "emcee": "3.1.6"},
    files={"t01.csv": "a" * 64},
)


def single_fit(*limits: Limit, wear: float = 0.3, hours: float | None = None) -> DriveResult:
    owner = drive(*limits)
    return DriveResult(owner, (one_test(1, hours, wear, owner),), None, (), (), PROVENANCE)


def wearing(
    *limits: Limit,
    crossing: float = 1900.0,
    spread: float = 230.0,
    count: int = 7,
    now: float = 900.0,
    never: float = 0.0,
    risk: float = 0.05,
    shutdown: float | None = SHUTDOWN,
    samples: int = 2400,
) -> DriveResult:
    """Drive whose first limit is passed about `crossing`, a share `never` of the paths aside."""
    limits = limits or (LOST_MOTION,)
    owner = drive(*limits, shutdown=shutdown)
    at = np.linspace(0.0, now, count) if count > 1 else np.array([now])
    tests = tuple(
        one_test(
            i + 1, float(hour), 0.75 * float(hour) / max(crossing, 1.0), owner, samples=samples
        )
        for i, hour in enumerate(at)
    )
    rng = np.random.default_rng(5)
    forecasts, draws, fans = [], [], {}
    for index, limit in enumerate(limits):
        middle = crossing * (1.0 + 0.25 * index)
        own = middle + spread * (1 + index) * rng.standard_normal(4000)
        own = np.maximum(own, now if middle > now else 0.0)
        own[rng.random(4000) < never] = np.inf
        draws.append(own)
        forecasts.append(forecast_of(limit, own, now, risk=risk, shutdown=shutdown))
        fans[limit.key] = trend_of(limit, tests, middle, spread * (1 + index))
    if len(limits) > 1:
        first = np.min(draws, axis=0)
        forecasts.append(forecast_of(None, first, now, risk=risk, shutdown=shutdown))
    carried = ("volatility", "clock_exponent") if count < 4 else ("volatility",)
    return DriveResult(
        owner, tests, trend_summary(fans, carried=carried), tuple(forecasts), (), PROVENANCE
    )


def healthy() -> DriveResult:
    """Almost no path passes the limit before the horizon."""
    return wearing(LOST_MOTION, crossing=30_000.0, spread=3_000.0)


def past_limit() -> DriveResult:
    """The limit was passed before the last test."""
    return wearing(LOST_MOTION, crossing=700.0, spread=40.0)


def not_converged() -> DriveResult:
    """One test of a wearing drive and the trend did not converge."""
    result = wearing(LOST_MOTION, SECANT)
    assert result.trend is not None
    tests = list(result.tests)
    tests[2] = one_test(3, tests[2].service_hours, 0.12, result.drive, converged=False)
    return replace(result, tests=tuple(tests), trend=replace(result.trend, converged=False))
