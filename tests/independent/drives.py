"""Drives that wear, tested now and then: folders with a known hour at which limits are crossed.

The wear of teeth, preload and friction follows laws that are neither powers nor saturating
exponentials, but for drives that are asked to wear regularly. Every test is scattered by
remounting; the true crossing hours are those of the drive without that scatter.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from .loops import programme, record_loop, scatter, worn_parameters, write_csv
from .simulator import DriveParameters, FloatArray, MeasurementChain, true_figures

IrregularLaw = Literal["logistic", "bilinear", "run-in then accelerating", "gamma process"]
RegularLaw = Literal["power", "saturating"]
WearLaw = IrregularLaw | RegularLaw
LAWS: tuple[WearLaw, ...] = get_args(IrregularLaw)
REGULAR_LAWS: tuple[WearLaw, ...] = get_args(RegularLaw)

RATED_TORQUE = 63.0
SECANT_TORQUE = 14.0
_SECANT = f"secant_stiffness_Nm_per_rad@{SECANT_TORQUE:g}Nm"
#: What a unit of wear changes in the logarithm of b, T_i or mu, by Table 2.
_CHANGE = {"teeth": 1.5, "preload": 0.5, "friction": 0.14}
#: Least and most wear, where a drift ends: the tooth threshold is not below zero.
_POSSIBLE = {"teeth": (0.005, 1.4), "preload": (-0.3, 1.5), "friction": (-1.5, 3.0)}
#: Figure, quantity in drive.toml and direction of the limit.
LIMITED: tuple[tuple[str, str, Literal["above", "below"]], ...] = (
    ("lost_motion_arcmin", "lost_motion_arcmin", "above"),
    (_SECANT, "secant_stiffness_Nm_per_rad", "below"),
    ("hysteresis_width_arcmin", "hysteresis_width_arcmin", "below"),
)


def wear_curve(law: WearLaw, rng: np.random.Generator, points: int = 161) -> FloatArray:
    """Draw a wear curve over evenly spaced relative hours from 0 to 1.

    ``logistic`` starts slowly and levels off; ``bilinear`` changes its rate once; ``run-in then
    accelerating`` loses some at once, rests, and speeds up; ``gamma process`` grows by
    independent random increments of constant mean. Of the regular laws ``power`` has an exponent
    about 1, and ``saturating`` nears an end exponentially.

    Returns
    -------
    numpy.ndarray
        shape (points,), rising from 0 to 1.
    """
    x = np.linspace(0.0, 1.0, points)
    if law == "logistic":
        middle, width = rng.uniform(0.35, 0.6), rng.uniform(0.1, 0.2)
        raw = 1.0 / (1.0 + np.exp(-(x - middle) / width))
    elif law == "bilinear":
        knee, second = rng.uniform(0.25, 0.55), rng.uniform(0.35, 2.8)
        raw = np.minimum(x, knee) + second * np.maximum(x - knee, 0.0)
    elif law == "run-in then accelerating":
        share, quick, rise = rng.uniform(0.15, 0.35), rng.uniform(0.03, 0.08), rng.uniform(2.0, 3.5)
        run_in = x / (x + quick)
        raw = share * run_in + (1.0 - share) * np.sinh(rise * x) / math.sinh(rise)
    elif law == "power":
        raw = x ** math.exp(0.45 * rng.standard_normal())
    elif law == "saturating":
        raw = -np.expm1(-rng.uniform(0.5, 2.5) * x)
    else:
        per_step = rng.uniform(0.15, 0.5)
        raw = np.concatenate(([0.0], np.cumsum(rng.gamma(per_step, size=points - 1))))
    curve: FloatArray = (raw - raw[0]) / (raw[-1] - raw[0])
    return curve


def drifts(size: float, points: int, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Draw random walks of the wear of each group.

    ``size`` is the standard deviation at the last point, of the logarithm of the parameter that
    shows the group's wear; each walk has shape (points,) and starts from 0.
    """
    steps = rng.standard_normal((len(_CHANGE), points - 1)) * size / math.sqrt(points - 1)
    return {
        group: np.concatenate(([0.0], np.cumsum(own))) / change
        for (group, change), own in zip(_CHANGE.items(), steps, strict=True)
    }


@dataclass(frozen=True)
class WearingDrive:
    """The true life of a drive.

    Attributes
    ----------
    law
        Wear law of teeth, preload and friction alike; each has its own draw, or all have one.
    hours
        shape (n,), from 0 to the horizon [h].
    wear
        By group, shape (n,): 0 is Table 2's initial state, 1 its post-test state.
    basis
        What this drive's parameters are multiplied with, for it is not that of Table 2.
    figures
        By name, shape (n,), along ``hours``.
    limits
        One entry a limit: quantity, direction, value and hour at which it is first crossed.
    """

    law: WearLaw
    hours: FloatArray
    wear: dict[str, FloatArray]
    basis: dict[str, float]
    figures: dict[str, FloatArray]
    limits: list[dict[str, object]]

    def parameters(self, hour: float) -> DriveParameters:
        """Return the parameters at an hour, without remounting scatter."""
        state = {group: float(np.interp(hour, self.hours, w)) for group, w in self.wear.items()}
        return _scaled(worn_parameters(**state), self.basis)


def _scaled(parameters: DriveParameters, basis: Mapping[str, float]) -> DriveParameters:
    """Multiply parameters by the factors that make a drive an individual."""
    values = parameters.as_dict()
    return replace(parameters, **{name: values[name] * factor for name, factor in basis.items()})


def first_crossing(
    hours: FloatArray, values: FloatArray, limit: float, direction: Literal["above", "below"]
) -> float | None:
    """Return the first hour at which a figure passes its limit, or None; straight in between."""
    excess = values - limit if direction == "above" else limit - values
    over = np.flatnonzero(excess > 0.0)
    if over.size == 0:
        return None
    k = int(over[0])
    if k == 0:
        return float(hours[0])
    share = excess[k - 1] / (excess[k - 1] - excess[k])
    return float(hours[k - 1] + share * (hours[k] - hours[k - 1]))


def random_wear(
    rng: np.random.Generator,
    law: WearLaw | None = None,
    horizon_hours: float | None = None,
    *,
    one_course: bool = False,
    drift: float = 0.0,
) -> WearingDrive:
    """Draw the life of a drive and limits that its wear reaches.

    Teeth, preload and friction each draw a course of their own, or all go the same one
    (``one_course``), each as far as it does. Each may drift beside it at random, by ``drift`` of
    the parameter that shows it until the horizon (one standard deviation). Every limit is the
    value that a figure has at some hour between 50 % and 97 % of the horizon, rounded to four
    digits; a figure that has not moved its way by 4 % until then gets none.
    """
    law = LAWS[int(rng.integers(len(LAWS)))] if law is None else law
    if horizon_hours is None:
        horizon_hours = float(round(math.exp(rng.uniform(math.log(500.0), math.log(20000.0))), -1))
    hours = np.linspace(0.0, horizon_hours, 161)
    start = float(rng.uniform(0.02, 0.1))
    shared = wear_curve(law, rng) if one_course else None

    def course() -> FloatArray:
        return wear_curve(law, rng) if shared is None else shared

    # Never past 1.4: there b is down to a quarter of what Table 2 found after its test.
    wear = {
        "teeth": start + float(rng.uniform(0.8, 1.3)) * course(),
        "preload": float(rng.uniform(0.8, 1.3)) * course(),
        "friction": float(rng.uniform(-0.2, 1.0)) * course(),
    }
    if drift:
        for group, beside in drifts(drift, hours.size, rng).items():
            wear[group] = np.clip(wear[group] + beside, *_POSSIBLE[group])
    spread = {"K_F": 0.04, "K_W": 0.04, "b": 0.05, "T_i": 0.05, "mu": 0.08}
    basis = {name: math.exp(sd * rng.standard_normal()) for name, sd in spread.items()}
    drive = WearingDrive(law, hours, wear, basis, {}, [])
    rows = [true_figures(drive.parameters(hour), secant_torque=SECANT_TORQUE) for hour in hours]
    drive.figures.update({name: np.array([row[name] for row in rows]) for name in rows[0]})
    for name, quantity, direction in LIMITED:
        values = drive.figures[name]
        at = float(np.interp(rng.uniform(0.5, 0.97) * horizon_hours, hours, values))
        moved = at / values[0] - 1.0
        if (moved if direction == "above" else -moved) < 0.04:
            continue
        value = float(f"{at:.4g}")
        crossed = first_crossing(hours, values, value, direction)
        if crossed is None:
            continue
        drive.limits.append(
            {
                "quantity": quantity,
                "direction": direction,
                "limit": value,
                "at_torque_Nm": SECANT_TORQUE if name == _SECANT else None,
                "crossing_hours": crossed,
            }
        )
    return drive


def write_drive(
    folder: Path,
    rng: np.random.Generator,
    *,
    law: WearLaw | None = None,
    horizon_hours: float | None = None,
    effects: Mapping[str, float] | None = None,
    growing_effects: bool = False,
    remounting: float = 1.0,
    samples: int = 300,
    drive_id: str | None = None,
    model: str | None = "CSF-25-80",
    chain: Callable[[np.random.Generator], MeasurementChain] | None = None,
    temperatures: Sequence[float] | None = None,
    friction_by_10_kelvin: float = 0.0,
) -> dict[str, object]:
    """Write a drive folder: drive.toml, tests.csv, loops/*.csv and truth.json.

    Parameters
    ----------
    folder
        Made if it does not exist.
    rng
        Source of everything random.
    law, horizon_hours
        Drawn where not given.
    effects
        Size [rad] by name in ``effects.EFFECTS``, in every test.
    growing_effects
        Whether the effects grow from a fifth of their size in the first test to the whole in the
        last (wear), rather than staying as they are (the rig).
    remounting
        Scale of the scatter between tests; 0 leaves it out.
    samples
        Samples a loop.
    model
        Written into drive.toml unless None.
    chain
        Draws the sensors of a test; the paper's rig with a random angle zero where not given.
    temperatures
        Of the tests [°C], whose number they set; drawn about 23 °C where not given.
    friction_by_10_kelvin
        Change of the logarithm of the friction coefficient for every 10 K above 23 °C.

    Returns
    -------
    dict
        What truth.json holds.
    """
    life = random_wear(rng, law, horizon_hours)
    while not life.limits:
        life = random_wear(rng, life.law, float(life.hours[-1]))
    horizon = float(life.hours[-1])
    count = int(rng.integers(8, 13)) if temperatures is None else len(temperatures)
    gaps = rng.gamma(2.5, size=count - 1)
    last = float(rng.uniform(0.5, 0.8)) * horizon
    service = np.round(np.concatenate(([0.0], np.cumsum(gaps) / gaps.sum())) * last, 1)
    drive_id = folder.name if drive_id is None else drive_id

    (folder / "loops").mkdir(parents=True, exist_ok=True)
    began = datetime(2023, 3, 1, 8, tzinfo=UTC)
    lines = [
        "test_id,file,service_hours,date,temperature_C,note,event,mean_torque_Nm,mean_speed_rpm"
    ]
    tests: list[dict[str, object]] = []
    for index, hour in enumerate(service.tolist()):
        exact = life.parameters(hour)
        spread = {"K_F": 0.004, "K_W": 0.006, "b": 0.012, "T_T": 0.008, "T_i": 0.012, "mu": 0.025}
        mounted = scatter(exact, {name: remounting * sd for name, sd in spread.items()}, rng)
        if temperatures is not None:
            warmer = math.exp(friction_by_10_kelvin * (temperatures[index] - 23.0) / 10.0)
            mounted = _scaled(mounted, {"mu": warmer})
        reach = float(rng.choice((63.0, 80.0, 100.0)))
        segments = programme("two-sided", reach, float(rng.uniform(10.0, 40.0)), rng)
        grown = (0.2 + 0.8 * index / (count - 1)) if growing_effects else 1.0
        sizes = {name: size * grown for name, size in (effects or {}).items()}
        sensors = MeasurementChain(angle_zero=float(rng.uniform(-math.pi, math.pi)))
        record = record_loop(
            mounted,
            segments,
            samples,
            rng,
            chain=sensors if chain is None else chain(rng),
            effects=sizes,
        )
        test_id = f"t{index + 1:02d}"
        file = f"loops/{test_id}.csv"
        write_csv(record, folder / file)
        date = (began + timedelta(hours=1.7 * hour)).date().isoformat()
        drawn = 23.0 + 2.0 * rng.standard_normal()
        temperature = drawn if temperatures is None else temperatures[index]
        load = "," if index == 0 else f"{rng.uniform(40.0, 63.0):.1f},{rng.uniform(800, 2000):.0f}"
        lines.append(f"{test_id},{file},{hour:.1f},{date},{temperature:.1f},,,{load}")
        tests.append(
            {
                "test_id": test_id,
                "service_hours": hour,
                "figures": true_figures(mounted, secant_torque=SECANT_TORQUE),
                "parameters_without_remounting": exact.as_dict(),
                **record.truth,
            }
        )
    (folder / "tests.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    shutdown = round(last + float(rng.uniform(0.05, 0.2)) * horizon, 1)
    (folder / "drive.toml").write_text(
        _drive_toml(drive_id, model, life.limits, horizon, shutdown), encoding="utf-8"
    )
    truth: dict[str, object] = {
        "schema": "independent.truth/1",
        "drive_id": drive_id,
        "law": life.law,
        "horizon_hours": horizon,
        "last_test_hours": float(service[-1]),
        "next_shutdown_hours": shutdown,
        "remounting": remounting,
        "limits": [
            {**limit, "already_crossed": _hours(limit) <= float(service[-1])}
            for limit in life.limits
        ],
        "first_limit_crossing_hours": min(_hours(limit) for limit in life.limits),
        "tests": tests,
        "life": {
            "hours": life.hours.tolist(),
            "wear": {group: w.tolist() for group, w in life.wear.items()},
            "figures": {name: values.tolist() for name, values in life.figures.items()},
        },
    }
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    return truth


def _hours(limit: Mapping[str, object]) -> float:
    """Return the crossing hour of an entry of ``limits``."""
    return float(str(limit["crossing_hours"]))


def _drive_toml(
    drive_id: str,
    model: str | None,
    limits: list[dict[str, object]],
    horizon: float,
    shutdown: float,
) -> str:
    """Return the text of drive.toml."""
    lines = ["[drive]", f'id = "{drive_id}"']
    if model is not None:
        lines.append(f'model = "{model}"')
    lines += [
        "ratio = 80",
        "alpha_deg = 30.0",
        f"rated_torque_Nm = {RATED_TORQUE}",
        "[noise]",
        "torque_resolution_Nm = 0.1",
        "angle_resolution_rad = 9.77e-6",
    ]
    for limit in limits:
        lines += ["[[limits]]", f'quantity = "{limit["quantity"]}"']
        if limit["at_torque_Nm"] is not None:
            lines.append(f"at_torque_Nm = {limit['at_torque_Nm']}")
        lines.append(f"{limit['direction']} = {limit['limit']}")
    lines += [
        "[forecast]",
        f"horizon_hours = {horizon}",
        "acceptable_risk = 0.05",
        f"next_shutdown_hours = {shutdown}",
    ]
    return "\n".join(lines) + "\n"
