"""Hand-made explanations of records and drives, one for each verdict.

The record is that of `drives`; residuals are drawn around an effect of known size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hdprog.explanation import (
    Carrier,
    ConsideredEffect,
    DriveExplanation,
    ErrorFigures,
    Explanation,
    FoundEffect,
    Quantiles,
    ResidualCourse,
    Verdict,
)
from hdprog.results import DriveResult
from tests.reporting import drives

FLOOR = 7e-6
BLOCKS, SIZE = 240, 10


def around(value: float, spread: float = 0.03) -> Quantiles:
    deviates = (-1.645, -0.674, 0.0, 0.674, 1.645)
    levels = (0.05, 0.25, 0.5, 0.75, 0.95)
    return {
        level: value + spread * abs(value) * z for level, z in zip(levels, deviates, strict=True)
    }


def creep(**changes: Any) -> FoundEffect:
    return replace(
        FoundEffect(
            id="creep",
            words="the angle keeps growing under load and recovers",
            coordinate=None,
            log_evidence_gain=412.3,
            elpd_gain=388.4,
            elpd_se=27.1,
            share=0.94,
            parameters={
                "creep.compliance": around(2.1e-6),
                "creep.time_constant": around(41.0, 0.12),
            },
            units={"creep.compliance": "rad/Nm", "creep.time_constant": "s"},
            indistinguishable_from=("viscous_friction", "microslip"),
            separating_test="repeat the record at a second loading rate, with a hold of 60 s",
            advice="hold the load for two minutes before each reading",
        ),
        **changes,
    )


def backlash(**changes: Any) -> FoundEffect:
    return replace(
        FoundEffect(
            id="backlash",
            words="a step in angle where torque changes sign",
            coordinate=None,
            log_evidence_gain=96.0,
            elpd_gain=88.0,
            elpd_se=11.4,
            share=0.88,
            parameters={"backlash.gap": around(6.0e-5), "backlash.width": around(1.4, 0.2)},
            units={"backlash.gap": "rad", "backlash.width": "Nm"},
            indistinguishable_from=(),
            separating_test=None,
            advice="check the coupling and the flange bolts for play",
        ),
        **changes,
    )


def unknown(coordinate: str = "torque") -> FoundEffect:
    return FoundEffect(
        id="unknown",
        words="a smooth function of torque",
        coordinate=coordinate,
        log_evidence_gain=140.0,
        elpd_gain=121.7,
        elpd_se=14.2,
        share=0.71,
        parameters={},
        units={},
        indistinguishable_from=(),
        separating_test=None,
        advice="repeat the record and look whether the shape comes back",
    )


CONSIDERED = (
    ConsideredEffect(
        "viscous_friction", "width proportional to rate", 3.2, 1.1, 2.4, "gains too little"
    ),
    ConsideredEffect(
        "kinematic_error", "periodic in the output angle", None, None, None, "needs output angle"
    ),
)


def course(added: str, scale: float = 1.0, seed: int = 3) -> ResidualCourse:
    """Two cycles of torque in 240 s; what was added is "creep", "backlash", "bump" or "nothing".

    The drive model takes up six tenths of a mechanism and nothing of the bump.
    """
    rng = np.random.default_rng(seed)
    position = (np.arange(BLOCKS) + 0.5) * SIZE
    torque = drives.cycle(63.0, BLOCKS)
    time = position / 10.0
    rising = np.gradient(torque) > 0
    shapes = {
        "creep": 9e-5 * np.sin(2 * math.pi * (time - 25.0) / 120.0 - 0.8),
        "backlash": 3e-5 * np.tanh(torque / 2.0),
        "bump": 4.5e-5 * np.exp(-0.5 * ((torque - 22.0) / 3.0) ** 2),
        "nothing": np.zeros(BLOCKS),
    }
    names = added.split("+")
    parts = {name: scale * shapes[name] for name in names}
    total = np.sum([*parts.values()], axis=0)
    hidden = 0.6 * np.sum([v for k, v in parts.items() if k != "bump"] or [0 * time], axis=0)
    noise = np.full(BLOCKS, FLOOR / math.sqrt(SIZE))
    after = noise * rng.standard_normal(BLOCKS)
    left = total - hidden
    turns = np.flatnonzero(np.diff(rising.astype(int))) + 1
    start = np.zeros(BLOCKS, dtype=int)
    start[turns] = turns
    since = np.abs(torque - torque[np.maximum.accumulate(start)])
    rate = np.gradient(torque, time)
    return ResidualCourse(
        torque=torque,
        angle=torque / 2e4,
        rising=rising.astype(float),
        position=position,
        time=time,
        count=np.full(BLOCKS, float(SIZE)),
        before=after + left - left.mean(),
        after=after,
        added=total - total.mean(),
        unknown=parts.get("bump"),
        coordinates={
            "time": time,
            "torque": torque,
            "angle": torque / 2e4,
            "rate": rate,
            "branch": torque,
            "distance_since_reversal": since,
            "order": position,
        },
        noise=noise,
    )


def record(
    verdict: Verdict = "explained",
    effects: tuple[FoundEffect, ...] | None = None,
    shape: str = "creep",
    *,
    carriers: Mapping[str, float] | None = None,
    scale: float = 1.0,
    test_id: str = "t01",
    hours: float | None = None,
    **changes: Any,
) -> Explanation:
    found = (creep(),) if effects is None else effects
    along = course(shape, scale)
    before = math.sqrt(float(np.mean(along.before**2)) + 0.9 * FLOOR**2)
    named = {"time": 0.83, "order": 0.79, "torque": 0.11} if carriers is None else carriers
    explanation = Explanation(
        test_id=test_id,
        service_hours=hours,
        verdict=verdict,
        noise_floor_rad=FLOOR,
        repeatability_rad=9e-6,
        outlier_fraction=0.002,
        before=ErrorFigures(before, 1.1 * before, 1.3 * before, 0.91),
        after=ErrorFigures(7.1e-6, 7.4e-6, 7.3e-6, 0.02),
        branch_rmse={"rising": (before, 7.0e-6), "falling": (0.9 * before, 7.2e-6)},
        carried_by=tuple(
            Carrier(name, share, 1e-5 if share > 0.2 else 0.31) for name, share in named.items()
        ),
        effects=found,
        considered=CONSIDERED,
        strained={"mu": 3.4} if found else {},
        parameters_before={"K_F": around(69_000.0), "mu": around(0.09), "a": around(1833.0)},
        parameters_after={
            "K_F": around(78_200.0),
            "mu": around(0.066),
            "a": around(1830.0),
            "creep.compliance": around(2.1e-6),
        },
        figures_before={
            "hysteresis_width_arcmin": around(0.43, 0.01),
            "secant_stiffness_Nm_per_rad@14Nm": around(14_100.0, 0.005),
        },
        figures_after={
            "hysteresis_width_arcmin": around(0.36, 0.01),
            "secant_stiffness_Nm_per_rad@14Nm": around(14_600.0, 0.005),
        },
        course=along,
        converged=True,
    )
    return replace(explanation, **changes)


def adequate(**changes: Any) -> Explanation:
    same = ErrorFigures(7.1e-6, 7.3e-6, 7.2e-6, 0.02)
    return record(
        "adequate",
        (),
        "nothing",
        carriers={"time": 0.0, "torque": 0.01},
        before=same,
        after=same,
        **changes,
    )


def partly(**changes: Any) -> Explanation:
    return record("partly_explained", (creep(), unknown()), "creep+bump", **changes)


def unexplained(**changes: Any) -> Explanation:
    return record(
        "unexplained",
        (unknown(),),
        "bump",
        carriers={"torque": 0.78, "angle": 0.74, "time": 0.05},
        **changes,
    )


def drive_explanation(count: int = 7, now: float = 900.0, **changes: Any) -> DriveExplanation:
    """Backlash that grows from nothing in the first two tests, and none of it in the rig."""
    tests, rows = [], []
    for number, hours in enumerate(np.linspace(0.0, now, count)):
        name, size = f"t{number + 1:02d}", max(0.0, float(hours) - 0.3 * now) / (0.7 * now)
        if size == 0.0:
            tests.append(adequate(test_id=name, hours=float(hours)))
            rows.append([hours, 0.0, 0.0, 0.0])
            continue
        tests.append(
            record(
                "explained",
                (backlash(),),
                "backlash",
                carriers={"torque": 0.6 * size, "time": 0.02},
                scale=size,
                test_id=name,
                hours=float(hours),
            )
        )
        rows.append([hours, *(2.8e-5 * size * np.array([0.9, 1.0, 1.1]))])
    explanation = DriveExplanation(
        verdict="explained",
        effects=(backlash(origin="wear"),),
        considered=CONSIDERED,
        amplitudes={"backlash": np.array(rows)},
        tests=tuple(tests),
        remaining_hours_before=dict(
            zip(
                (0.05, 0.25, 0.5, 0.75, 0.95), (1210.0, 1400.0, 1560.0, 1700.0, 1890.0), strict=True
            )
        ),
        remaining_hours_after=dict(
            zip((0.05, 0.25, 0.5, 0.75, 0.95), (1420.0, 1700.0, 1900.0, 2100.0, None), strict=True)
        ),
    )
    return replace(explanation, **changes)


def adequate_drive() -> DriveExplanation:
    tests = tuple(adequate(test_id=f"t{n:02d}", hours=150.0 * n) for n in (1, 2, 3))
    return DriveExplanation("adequate", (), CONSIDERED, {}, tests)


def single(explanation: Explanation) -> DriveResult:
    return replace(drives.single_fit(drives.LOST_MOTION), explanation=explanation)


def of_drive(explanation: DriveExplanation | None = None, **changes: Any) -> DriveResult:
    found = drive_explanation() if explanation is None else explanation
    return replace(drives.wearing(count=len(found.tests), **changes), explanation=found)
