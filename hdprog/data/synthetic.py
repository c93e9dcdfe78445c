"""Simulated drive folders whose truth is known and written beside them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hdprog.atomic import atomic_directory
from hdprog.data.synthetic_effects import AddedEffects, chosen_effects, rates_of
from hdprog.data.wear_path import SCENARIOS, worn_parameters
from hdprog.errors import BadInputError, UsageError
from hdprog.physics.drive_model import predict
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.parameters import FloatArray, Parameters, in_support

RATED_TORQUE = 63.0
ALPHA = math.radians(30.0)
TORQUE_STEP, ANGLE_STEP = 0.1, 9.77e-6  # resolution of the published rig (Table 1)
TORQUE_NOISE, ANGLE_NOISE = 0.03, 1.0e-5
HORIZON = 20_000.0  # at least
REMOUNTING = 0.01  # relative scatter of each parameter from one mounting to the next
LIMITS: tuple[tuple[FigureRequest, str, float], ...] = (
    (FigureRequest("lost_motion_arcmin"), "above", 2.0),
    (FigureRequest("secant_stiffness_Nm_per_rad", 14.0), "below", 13_000.0),
    (FigureRequest("hysteresis_width_arcmin"), "below", 0.30),
)
_LOADING_RATE = 2.0  # Nm/s
_TURNING = 0.1  # of the usual time between readings: the least that a turn between two takes
# Below, the noise hides the loop; far above rated torque, teeth jump.
_LEAST_TORQUE, _LARGEST_TORQUE = 10 * TORQUE_STEP, 1000.0
_DRIVE_TOML = """\
[drive]
id = {name}
model = "CSF-25-80"
ratio = 80
alpha_deg = 30.0
rated_torque_Nm = 63.0

[noise]
torque_resolution_Nm = 0.1
angle_resolution_rad = 9.77e-6

[prior]
file = "csf-25-80"
{limits}
[forecast]
horizon_hours = {horizon:.1f}
acceptable_risk = 0.05
next_shutdown_hours = 1500.0
"""


def torque_history(max_torque: float, samples: int, cycles: int, *, one_sided: bool) -> FloatArray:
    """Triangular torque from zero through whole cycles back to zero, (samples,) in Nm."""
    turns = _turning_torques(max_torque, cycles, one_sided=one_sided)
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    return np.interp(np.linspace(0.0, travelled[-1], samples), travelled, turns)


def reading_times(
    max_torque: float, samples: int, cycles: int, rates: Sequence[float], *, one_sided: bool
) -> FloatArray:
    """Times of the readings of `torque_history`, (samples,) in s.

    Parameters
    ----------
    max_torque, samples, cycles, one_sided : as in `torque_history`
    rates : loading rates relative to the usual one, which the cycles take in turn
    """
    legs = np.abs(np.diff(_turning_torques(max_torque, cycles, one_sided=one_sided)))
    # Two legs a cycle; one more, back to zero, belongs to the last.
    cycle = np.minimum(np.arange(legs.size) // 2, cycles - 1)
    lasting = legs / (_LOADING_RATE * np.asarray(rates)[cycle % len(rates)])
    travelled, passed = (np.concatenate([[0.0], np.cumsum(each)]) for each in (legs, lasting))
    return np.asarray(np.interp(np.linspace(0.0, travelled[-1], samples), travelled, passed))


def _turning_torques(max_torque: float, cycles: int, *, one_sided: bool) -> list[float]:
    turns = [0.0]
    for _ in range(cycles):
        turns += [max_torque, 0.0] if one_sided else [max_torque, -max_torque]
    if turns[-1] != 0.0:
        turns.append(0.0)
    return turns


def _require_drives(course: Mapping[str, FloatArray], hours: float) -> None:
    """Refuse service hours by which wear has led out of what the drive model holds for."""
    scattered = {**course, "mu": course["mu"] * math.exp(5 * REMOUNTING)}
    if not in_support(scattered, ALPHA).all():
        raise UsageError(
            f"--hours: found {hours:g} h, by which the simulated drive is worn past what the model "
            "holds for; expected fewer. Give fewer --hours, or --wear healthy."
        )


def measured_loop(
    parameters: Mapping[str, float],
    torque: FloatArray,
    rng: np.random.Generator,
    effects: AddedEffects | None = None,
) -> dict[str, FloatArray]:
    """What a rig records: time, torque and angle with noise, resolution and an arbitrary zero.

    Parameters
    ----------
    parameters : scalars by name
    torque : (samples,) in Nm: the true torque, or with effects what a sensor without noise reads
    rng : of noise, zero and initial state, drawn alike with effects and without
    effects : on this torque, to be added

    Returns
    -------
    columns by header, (samples,) each
    """
    initial = rng.uniform(-1.0, 1.0) * 1e-4
    values = {name: np.asarray(value) for name, value in parameters.items()}
    angle = predict(torque, values, ALPHA, initial_slip=initial)
    if effects is not None:
        angle = angle + effects.added(parameters, initial)
    angle = angle + rng.uniform(-1e-3, 1e-3) + ANGLE_NOISE * rng.standard_normal(angle.size)
    read = torque + TORQUE_NOISE * rng.standard_normal(torque.size)
    columns = {
        "time_s": _times_of(torque) if effects is None else effects.time,
        "torque_Nm": np.round(read / TORQUE_STEP) * TORQUE_STEP,
        "angle_rad": np.round(angle / ANGLE_STEP) * ANGLE_STEP,
    }
    if effects is not None and effects.output_angle is not None:
        columns["output_angle_rad"] = effects.output_angle
    return columns


def _times_of(torque: FloatArray) -> FloatArray:
    """Times (samples,) in s of readings at the usual loading rate.

    Two at the same torque, with a turning point midway between them, are still not simultaneous.
    """
    steps = np.abs(np.diff(torque))
    travelled = np.cumsum(np.maximum(steps, _TURNING * np.median(steps)))
    return np.concatenate([[0.0], travelled]) / _LOADING_RATE


def write_drive_folder(
    out: Path,
    *,
    seed: int,
    scenario: str,
    tests: int,
    hours: float,
    cycles: int,
    samples: int,
    max_torque_Nm: float,
    one_sided: bool,
    command: str,
    effects: Sequence[str] = (),
) -> Path:
    """Simulate a drive and write its folder, `truth.json` included.

    Parameters
    ----------
    out : folder to write; files in it are replaced
    seed : of everything random
    scenario : a name in `SCENARIOS`
    tests, hours : number of tests, and service hours of the last of several; the first is at 0
    cycles, samples, max_torque_Nm, one_sided : the loop of each test
    command : that asked for it
    effects : ids of effects to add in every test; nothing else random changes with them

    Returns
    -------
    the folder

    Raises
    ------
    UsageError
        if the loop asked for cannot be measured or cannot show an effect, or an effect is unknown
    BadInputError
        if the folder holds a drive that was not simulated
    """
    if not _LEAST_TORQUE <= max_torque_Nm <= _LARGEST_TORQUE or samples < 20 * cycles:
        raise UsageError(
            f"--max-torque, --samples: found {max_torque_Nm:g} Nm and {samples} samples for "
            f"{cycles} cycles; expected {_LEAST_TORQUE:g} to {_LARGEST_TORQUE:g} Nm and 20 samples "
            "a cycle or more. Change the one that is out of it, or ask for fewer --cycles."
        )
    chosen = chosen_effects(effects, cycles=cycles, one_sided=one_sided)
    _require_no_drive_of_others(out)
    rng = np.random.default_rng(seed)
    spacing = rng.uniform(0.8, 1.2, max(tests - 1, 1))
    at = np.concatenate([[0.0], np.cumsum(spacing) / spacing.sum() * hours])[:tests]
    at = np.round(at, 1)
    horizon = max(HORIZON, 2.0 * hours)  # past the last test, or a run would refuse the drive
    step = 5.0 * max(1.0, horizon / 1e5)
    grid = np.unique(np.concatenate([at, np.arange(0.0, horizon + 1, step)]))
    wear = SCENARIOS[scenario].course(grid, rng)
    course = worn_parameters(wear)
    _require_drives(course, hours)
    torque = torque_history(max_torque_Nm, samples, cycles, one_sided=one_sided)
    added = None
    if chosen:
        rates = rates_of(chosen)
        time = reading_times(max_torque_Nm, samples, cycles, rates, one_sided=one_sided)
        new = {name: float(values[0]) for name, values in course.items()}
        added = AddedEffects.drawn(chosen, new, torque, time, ALPHA, seed)
    with atomic_directory(out) as folder:
        states = [
            {name: float(values[place]) for name, values in course.items()}
            for place in np.searchsorted(grid, at)
        ]
        truth: dict[str, Any] = {
            "made_by": command,
            "seed": seed,
            "scenario": scenario,
            "remounting_scatter": REMOUNTING,
            "tests": _write_tests(folder, at, states, torque, rng, added),
            "crossing_hours": _crossings(grid, course),
            "horizon_hours": horizon,
        }
        if added is not None:
            truth["effects"] = added.truth()
        (folder / "drive.toml").write_text(_drive_toml(out.name, horizon), "utf-8")
        (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", "utf-8")
    return out


def _write_tests(
    folder: Path,
    hours: FloatArray,
    states: Sequence[Mapping[str, float]],
    torque: FloatArray,
    rng: np.random.Generator,
    added: AddedEffects | None,
) -> list[dict[str, Any]]:
    """Write a loop for each state at its service hours, and tests.csv; what is true of each."""
    (folder / "loops").mkdir()
    rows, truth = ["test_id,file,service_hours"], []
    for number, (moment, state) in enumerate(zip(hours, states, strict=True), start=1):
        mounted = {
            name: value * float(np.exp(REMOUNTING * rng.standard_normal()))
            for name, value in state.items()
        }
        name = f"t{number:02d}"
        table = measured_loop(mounted, torque, rng, added)
        _write_loop(folder / "loops" / f"{name}.csv", table, quick=added is not None)
        rows.append(f"{name},loops/{name}.csv,{moment:g}")
        truth.append({"test_id": name, "service_hours": moment, "state": state, "mounted": mounted})
    (folder / "tests.csv").write_text("\n".join(rows) + "\n", "utf-8")
    return truth


def _drive_toml(name: str, horizon: float) -> str:
    return _DRIVE_TOML.format(
        # a string of JSON is one of TOML, but for DEL
        name=json.dumps(name, ensure_ascii=False).replace("\x7f", "\\u007f"),
        limits="".join(_limit_toml(*limit) for limit in LIMITS),
        horizon=horizon,
    )


def _require_no_drive_of_others(out: Path) -> None:
    """Refuse to write over a drive's folder that has no truth."""
    for name in ("drive.toml", "tests.csv"):
        if (out / name).exists() and not (out / "truth.json").exists():
            raise BadInputError(
                found=f"a {name} and no truth.json",
                where=str(out),
                expected="a new folder, or one that was simulated before",
                advice="Give another folder with --out: what lies here is a drive of its own.",
            )


def _crossings(grid: FloatArray, course: Parameters) -> dict[str, float | None]:
    """Service hours at which the drive's own state first passes each limit; None past the end."""
    operation = Operation(ALPHA, RATED_TORQUE, RATED_TORQUE)
    values = figures([request for request, _, _ in LIMITS], course, operation)
    crossings: dict[str, float | None] = {}
    for request, direction, threshold in LIMITS:
        figure = values[request.key]
        past = figure > threshold if direction == "above" else figure < threshold
        crossings[request.key] = float(grid[np.argmax(past)]) if past.any() else None
    return crossings


def _limit_toml(request: FigureRequest, direction: str, threshold: float) -> str:
    lines: list[Any] = ["", "[[limits]]", f'quantity = "{request.quantity}"']
    if request.at_torque_Nm is not None:
        lines.append(f"at_torque_Nm = {request.at_torque_Nm}")
    return "\n".join([*lines, f"{direction} = {threshold}", ""])


def _write_loop(path: Path, table: dict[str, FloatArray], *, quick: bool) -> None:
    """Write a table; `quick` readings follow one another in hundredths of a second."""
    shortest = float(np.diff(table["time_s"]).min())
    decimals = max(6 if quick else 3, 1 - math.floor(math.log10(shortest)))
    formats = {
        "time_s": f"{{:.{decimals}f}}",
        "torque_Nm": "{:.1f}",
        "angle_rad": "{:.8f}",
        "output_angle_rad": "{:.8f}",
    }
    lines = [",".join(table)]
    rows = zip(*table.values(), strict=True)
    lines += [
        ",".join(formats[name].format(value) for name, value in zip(table, row, strict=True))
        for row in rows
    ]
    path.write_text("\n".join(lines) + "\n", "utf-8")
