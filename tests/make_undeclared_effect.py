"""Make datasets/undeclared-effect: drives whose loops carry what nobody declared.

    python tests/make_undeclared_effect.py [--out datasets/undeclared-effect]

Four drive folders and a README. Loops come from the simulator in tests/independent, which shares no
code with hdprog; shapes of the effects are its own, too. Everything random hangs on `SEED`. Each
folder's truth.json says what was put in; `hdprog backtest` alone reads it.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.independent.drives import RATED_TORQUE, WearingDrive, WearLaw, random_wear
from tests.independent.effects import EFFECTS, apply_effects
from tests.independent.loops import LoopRecord, _unabsorbed, scatter, write_csv
from tests.independent.simulator import (
    DriveParameters,
    FloatArray,
    MeasurementChain,
    Segment,
    Trace,
    make_path,
    measure,
    simulate,
)

ROOT = Path(__file__).resolve().parent.parent
SEED = 25
TESTS, SAMPLES = 6, 300
HORIZON = 8000.0
TORQUE = 80.0
SLOW, QUICK, HOLD = 200.0, 50.0, 60.0  # s, from zero to the largest torque
JITTER = 0.02  # of a sampling interval
TILT = math.radians(30.0)
REMOUNTING = {"K_F": 0.004, "K_W": 0.006, "b": 0.012, "T_T": 0.008, "T_i": 0.012, "mu": 0.025}


@dataclass(frozen=True)
class Case:
    """One drive folder.

    Attributes
    ----------
    name : of the folder
    says : what is put in, for the README
    law : of the drive's wear
    amplitudes : by name in `tests.independent.effects`, in Nm for a torque reading and else in rad
    grows : whether the effects grow from nothing with the wear of the teeth
    tested : first and last test in parts of the horizon
    limited : quantities that get a limit
    """

    name: str
    says: str
    law: WearLaw
    amplitudes: dict[str, float]
    grows: bool = False
    tested: tuple[float, float] = (0.0, 0.55)
    limited: tuple[str, ...] = (
        "lost_motion_arcmin",
        "secant_stiffness_Nm_per_rad",
        "hysteresis_width_arcmin",
    )


CASES = (
    Case(
        "one-effect",
        "creep, the same in every test",
        "logistic",
        {"creep": 2.4e-4},
    ),
    Case(
        "two-effects",
        "a kinematic error and a drift as the rig warms up, the same in every test",
        "bilinear",
        {"kinematic_error": 4.5e-5, "thermal_drift": 1.3e-4},
    ),
    Case(
        "on-no-list",
        "saw teeth on the falling branch, which no effect of hdprog describes",
        "run-in then accelerating",
        {"stick_slip_teeth": 1.6e-4},
    ),
    # A constant width more leaves stiffness and mid-line alone: these limits keep their hours.
    Case(
        "grows-with-wear",
        "friction that does not depend on load, from nothing at first to most in the last test",
        "gamma process",
        {"coulomb_friction": 1.1e-4},
        grows=True,
        limited=("lost_motion_arcmin", "secant_stiffness_Nm_per_rad"),
    ),
)


def programme() -> list[Segment]:
    """Two cycles that are not recorded, a slow one with holds and a quick one."""
    before = [Segment(end, 200.0, recorded=False) for end in 2 * [TORQUE, -TORQUE]]
    return [
        *before,
        Segment(0.0, 100.0, recorded=False),
        Segment(TORQUE, SLOW),
        Segment(TORQUE, HOLD, "hold"),
        Segment(-TORQUE, 2 * SLOW),
        Segment(-TORQUE, HOLD, "hold"),
        Segment(TORQUE, 2 * QUICK),
        Segment(-TORQUE, 2 * QUICK),
        Segment(0.0, QUICK),
    ]


def drawn_life(case: Case, rng: np.random.Generator) -> WearingDrive:
    """A life whose limits are all reached, and not before the forecast begins."""
    begins = (case.tested[1] + 0.05) * HORIZON
    while True:
        life = random_wear(rng, case.law, HORIZON)
        limits = [limit for limit in life.limits if limit["quantity"] in case.limited]
        late = all(float(str(limit["crossing_hours"])) > begins for limit in limits)
        if len(limits) == len(case.limited) and late:
            return replace(life, limits=limits)


def reading_noise(trace: Trace, chain: MeasurementChain) -> float:
    """Root mean square [rad] of the readings' noise, that of the torque as an angle."""
    p, size = trace.parameters, np.abs(trace.torque[trace.recorded])
    slope = 1 / p.K_F + 1 / (p.a * np.minimum(size, p.T_T) + p.b) + math.tan(TILT) ** 2 / p.K_W
    torque = chain.torque_noise**2 + chain.torque_step**2 / 12
    angle = chain.angle_noise**2 + chain.angle_step**2 / 12
    return float(np.sqrt(np.mean(angle + slope**2 * torque)))


def unabsorbed(trace: Trace, angle: FloatArray, torque: FloatArray) -> float:
    """Root mean square [rad] of what the base model leaves of a changed angle and torque."""
    return _unabsorbed(replace(trace, torque=torque), angle[trace.recorded], 0.0)


def read_temperature(true: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Temperature [°C] as a sensor with some noise shows it."""
    return true + 0.05 * rng.standard_normal(true.size)


@dataclass(frozen=True)
class Tested:
    """A record and what is true of it."""

    record: LoopRecord
    truth: dict[str, object]


def tested(
    parameters: DriveParameters,
    amplitudes: dict[str, float],
    settings: int,
    rng: np.random.Generator,
) -> Tested:
    """One test: effects of these amplitudes, their other constants drawn from `settings`."""
    path = make_path(0.0, programme(), SAMPLES, rng, jitter=JITTER)
    trace = simulate(path, parameters)
    chain = MeasurementChain(angle_zero=float(rng.uniform(-1e-3, 1e-3)))
    angle, torque = trace.angle, trace.torque
    output_angle: FloatArray | None = None
    temperature: FloatArray | None = None
    put_in: list[dict[str, object]] = []
    noise = reading_noise(trace, chain)
    for name, amplitude in amplitudes.items():
        alone = apply_effects(trace, {name: 1e-5}, np.random.default_rng([SEED, settings]))
        (entry,) = alone.truth
        factor = amplitude / float(str(entry["amplitude"]))
        change = (factor * (alone.angle - trace.angle), factor * (alone.torque - trace.torque))
        angle, torque = angle + change[0], torque + change[1]
        left = unabsorbed(trace, trace.angle + change[0], trace.torque + change[1])
        output_angle = alone.output_angle if output_angle is None else output_angle
        temperature = alone.temperature if temperature is None else temperature
        put_in.append(
            {
                "id": EFFECTS[name].identifier,
                "name": name,
                "acts_on": entry["acts_on"],
                "amplitude": amplitude,
                "unit": "Nm" if entry["acts_on"] == "torque" else "rad",
                "size_rad": factor * 1e-5,
                "unabsorbed_over_noise": round(left / noise, 2),
                "settings": entry["settings"],
            }
        )
    seen = trace.recorded
    stamps, read_torque, read_angle, _ = measure(
        trace.time[seen], torque[seen], angle[seen], chain, rng
    )
    left = unabsorbed(trace, angle, torque)
    record = LoopRecord(
        torque=read_torque,
        angle=read_angle,
        time=stamps - stamps[0],
        true_torque=trace.torque[seen],
        true_angle=angle[seen],
        base_angle=trace.angle[seen],
        temperature=None if temperature is None else read_temperature(temperature[seen], rng),
        output_angle=None if output_angle is None else output_angle[seen],
        truth={},
    )
    truth: dict[str, object] = {
        "parameters": parameters.as_dict(),
        "effects": put_in,
        "unabsorbed_rms_rad": left,
        "noise_rms_rad": noise,
        "unabsorbed_over_noise": round(left / noise, 2),
    }
    return Tested(record, truth)


def write_case(folder: Path, case: Case, number: int, count: int = TESTS) -> list[float]:
    """Write a drive folder; returns what is left over the noise in each test."""
    rng = np.random.default_rng([SEED, number])
    life = drawn_life(case, rng)
    inner = np.sort(rng.uniform(0.1, 0.9, count - 2))
    shares = np.concatenate(([0.0], 0.5 * inner + 0.5 * np.linspace(0.2, 0.8, count - 2), [1.0]))
    first, last = case.tested
    service = np.round((first + (last - first) * shares) * HORIZON, 1)
    worn = np.interp(service, life.hours, life.wear["teeth"])
    growth = (worn - worn[0]) / (worn[-1] - worn[0]) if case.grows else np.ones(count)
    (folder / "loops").mkdir(parents=True, exist_ok=True)
    began = datetime(2024, 1, 8, tzinfo=UTC)
    rows, tests, ratios = ["test_id,file,service_hours,date"], [], []
    for index, (hour, grown) in enumerate(zip(service.tolist(), growth.tolist(), strict=True), 1):
        exact = life.parameters(hour)
        amplitudes = {name: grown * value for name, value in case.amplitudes.items() if grown > 0}
        one = tested(scatter(exact, REMOUNTING, rng), amplitudes, number, rng)
        test_id = f"t{index:02d}"
        write_csv(one.record, folder / "loops" / f"{test_id}.csv")
        date = (began + timedelta(hours=1.5 * hour)).date().isoformat()
        rows.append(f"{test_id},loops/{test_id}.csv,{hour:g},{date}")
        ratios.append(float(str(one.truth["unabsorbed_over_noise"])))
        tests.append(
            {
                "test_id": test_id,
                "service_hours": hour,
                "growth": grown,
                "parameters_without_remounting": exact.as_dict(),
                **one.truth,
            }
        )
    (folder / "tests.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    shutdown = round(float(service[-1]) + 0.08 * HORIZON, 0)
    drive_id = f"undeclared-{case.name}"
    (folder / "drive.toml").write_text(drive_toml(drive_id, life, shutdown), encoding="utf-8")
    truth = {
        "made_by": "python tests/make_undeclared_effect.py",
        "seed": [SEED, number],
        "drive_id": drive_id,
        "law_of_wear": life.law,
        "effects": sorted({EFFECTS[name].identifier for name in case.amplitudes}),
        "effects_grow": case.grows,
        "limits": life.limits,
        "crossing_hours": {limit_key(limit): limit["crossing_hours"] for limit in life.limits},
        "horizon_hours": HORIZON,
        "tests": tests,
    }
    text = json.dumps(truth, indent=1) + "\n"
    (folder / "truth.json").write_text(text, encoding="utf-8")
    return ratios


def limit_key(limit: dict[str, object]) -> str:
    """Key of a limited figure as in hdprog's summaries."""
    torque = limit["at_torque_Nm"]
    quantity = str(limit["quantity"])
    return quantity if torque is None else f"{quantity}@{float(str(torque)):g}Nm"


def drive_toml(drive_id: str, life: WearingDrive, shutdown: float) -> str:
    """Text of drive.toml; it knows nothing of the effects."""
    lines = [
        "[drive]",
        f'id = "{drive_id}"',
        'model = "CSF-25-80"',
        "ratio = 80",
        "alpha_deg = 30.0",
        f"rated_torque_Nm = {RATED_TORQUE}",
        "",
        "[noise]",
        "torque_resolution_Nm = 0.1",
        "angle_resolution_rad = 9.77e-6",
        "",
        "[prior]",
        'file = "csf-25-80"',
    ]
    for limit in life.limits:
        lines += ["", "[[limits]]", f'quantity = "{limit["quantity"]}"']
        if limit["at_torque_Nm"] is not None:
            lines.append(f"at_torque_Nm = {limit['at_torque_Nm']}")
        lines.append(f"{limit['direction']} = {limit['limit']}")
    lines += [
        "",
        "[forecast]",
        f"horizon_hours = {HORIZON}",
        "acceptable_risk = 0.05",
        f"next_shutdown_hours = {shutdown}",
    ]
    return "\n".join(lines) + "\n"


README = """\
# Drives with an effect that nobody declared

Simulated tests of four CSF-25-80 drives, {tests} tests of {samples} readings each. The loops carry
something that the drive model lacks, and neither `drive.toml` nor `tests.csv` says so: these
folders are there to see whether `hdprog explain` and `hdprog run` find it.

| folder | what was put in | left by the best drive model, over the noise |
|---|---|---|
{rows}

The last column is the root mean square of what no choice of the drive model's parameters can
imitate (to first order), over that of the readings' noise, from test to test. Without the effects
it is 0.

* Made by `python tests/make_undeclared_effect.py` from seed {seed}; the same command makes the same
  files again, this one included.
* The loops come from the simulator in `tests/independent`, which shares no code with hdprog. Its
  effects have shapes that hdprog's have not (creep with other time constants, a triangular
  kinematic error), and its drives wear by laws that hdprog's trend does not know.
* Each test: two cycles that are not recorded, then from zero to ± {torque:g} Nm at {slow:.1f} Nm/s
  with a hold of {hold:g} s at either end, and once more at {quick:.1f} Nm/s. The sensors' noise
  (standard deviation) is {torque_noise} Nm and {angle_noise} rad, their steps are 0.1 Nm and
  9.77e-6 rad; the zero of the angle is arbitrary.
* `truth.json` holds the parameters, effects and sizes of every test and the service hours at which
  the drive itself, effects apart, reaches each limit. `hdprog backtest` alone reads
  it: it scores forecasts by these hours.
"""


def main() -> None:
    """Write the folders and the README."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "datasets" / "undeclared-effect")
    out: Path = parser.parse_args().out
    rows = []
    for number, case in enumerate(CASES, start=1):
        ratios = write_case(out / case.name, case, number)
        span = ", ".join(f"{ratio:.1f}" for ratio in ratios)
        rows.append(f"| `{case.name}` | {case.says} | {span} |")
        print(f"{case.name}: {span}")
    chain = MeasurementChain()
    text = README.format(
        tests=TESTS,
        samples=SAMPLES,
        rows="\n".join(rows),
        seed=SEED,
        torque=TORQUE,
        slow=TORQUE / SLOW,
        quick=TORQUE / QUICK,
        hold=HOLD,
        torque_noise=chain.torque_noise,
        angle_noise=f"{chain.angle_noise:.0e}",
    )
    (out / "README.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
