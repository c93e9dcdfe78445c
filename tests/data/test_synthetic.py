"""A simulated drive folder holds what its truth says."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hdprog.data.check import check_path
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.data.synthetic import measured_loop, torque_history, write_drive_folder
from hdprog.data.wear_path import SCENARIOS
from hdprog.errors import BadInputError, UsageError
from hdprog.physics.drive_model import predict
from hdprog.shipped import shipped
from tests.physics.table2 import POST_TEST

ARCMIN = 180 * 60 / np.pi
RATED = 63.0
SHIPPED = ("wearing-csf-25-80", "healthy-csf-25-80")
DEFAULTS: dict[str, Any] = {
    "seed": 3,
    "scenario": "wearing",
    "tests": 41,
    "hours": 2000.0,
    "cycles": 1,
    "samples": 120,
    "max_torque_Nm": RATED,
    "one_sided": False,
    "command": "hdprog simulate --seed 3",
}


def simulated(out: Path, **changes: Any) -> Path:
    return write_drive_folder(out, **{**DEFAULTS, **changes})


def truth_of(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "truth.json").read_text("utf-8"))


def content(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def assert_same(made: Any, kept: Any) -> None:
    """But for rounding: exponentials of one processor differ from another's in the last digit."""
    if isinstance(kept, dict):
        assert list(made) == list(kept)
        made, kept = list(made.values()), list(kept.values())
    if isinstance(kept, list):
        for one, other in zip(made, kept, strict=True):
            assert_same(one, other)
    elif isinstance(kept, float):
        assert made == pytest.approx(kept, rel=1e-12)
    else:
        assert made == kept


@pytest.fixture(name="drive", scope="module")
def drive_fixture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulated(tmp_path_factory.mktemp("simulated") / "drive")


def limited_figures(state: Mapping[str, float]) -> dict[str, float]:
    """The three limited figures, read off a simulated steady cycle to ± rated torque."""
    at = 0.04 * RATED
    up = np.array([-RATED, -at, 0.0, at, RATED])
    torque = np.concatenate([[0.0, RATED], up, up[-2::-1]])
    angle = predict(torque, {name: np.asarray(value) for name, value in state.items()}) * ARCMIN
    rising, falling = angle[2:7], angle[6:][::-1]
    middle = (rising + falling) / 2
    # 14 Nm over the angle of the three springs in series: the teeth by a fine sum of dT/K_T.
    fine = (np.arange(14_000) + 0.5) * 1e-3
    teeth = np.sum(1e-3 / (state["a"] * np.minimum(fine, state["T_T"]) + state["b"]))
    twist = teeth + 14 / state["K_F"] + 14 * np.tan(np.radians(30)) ** 2 / state["K_W"]
    return {
        "lost_motion_arcmin": middle[3] - middle[1],
        "secant_stiffness_Nm_per_rad@14Nm": 14 / twist,
        "hysteresis_width_arcmin": falling[2] - rising[2],
    }


def test_the_folder_is_a_drive_folder(drive: Path) -> None:
    folder, truth = read_drive_folder(drive), truth_of(drive)
    assert folder.drive.id == "drive"
    assert [test.test_id for test in folder.tests] == [t["test_id"] for t in truth["tests"]]
    hours = [test.service_hours for test in folder.tests]
    assert hours == [test["service_hours"] for test in truth["tests"]]
    assert hours[0] == 0
    assert hours[-1] == 2000
    loop = read_test_loop(folder, folder.tests[7])
    assert len(loop) == 120
    assert loop.warnings == ()
    assert loop.time is not None


def test_the_crossing_hours_are_those_of_the_states(drive: Path) -> None:
    truth = truth_of(drive)
    hours = np.array([test["service_hours"] for test in truth["tests"]])
    figures = [limited_figures(test["state"]) for test in truth["tests"]]
    limits = {limit.key: limit for limit in read_drive_folder(drive).drive.limits}
    assert set(limits) == set(truth["crossing_hours"])
    for key, limit in limits.items():
        values = np.array([figure[key] for figure in figures])
        past = values > limit.threshold if limit.direction == "above" else values < limit.threshold
        assert past.any(), key
        first = int(np.argmax(past))
        # Between two tests wear runs almost straight: within a fifth of their distance.
        share = (limit.threshold - values[first - 1]) / (values[first] - values[first - 1])
        step = hours[first] - hours[first - 1]
        expected = hours[first - 1] + share * step
        assert truth["crossing_hours"][key] == pytest.approx(expected, abs=0.2 * step + 5), key


def test_a_healthy_drive_crosses_nothing(tmp_path: Path) -> None:
    truth = truth_of(simulated(tmp_path / "d", scenario="healthy", tests=2, hours=100.0))
    assert set(truth["crossing_hours"].values()) == {None}


@pytest.mark.parametrize("name", ['we"ird', "back\\slash", "line\nbreak", "del\x7f", "Prüfstand 3"])
@pytest.mark.parametrize("hours", [30_000.0, 120_000.0])
def test_whatever_is_made_can_be_read(tmp_path: Path, name: str, hours: float) -> None:
    """Such names made a drive.toml that is none, and such hours a horizon before the last test."""
    made = simulated(tmp_path / name, scenario="healthy", tests=2, hours=hours)
    drive = read_drive_folder(made).drive
    assert (drive.id, drive.forecast.horizon_hours) == (name, 2.0 * hours)
    assert truth_of(made)["horizon_hours"] == 2.0 * hours
    assert check_path(made).ok


@pytest.mark.parametrize(
    "changes",
    [
        {"one_sided": True, "samples": 900, "cycles": 3},
        {"samples": 303, "cycles": 3},
        {"samples": 60_000, "max_torque_Nm": 3.0},
    ],
)
def test_no_two_readings_are_simultaneous(tmp_path: Path, changes: dict[str, Any]) -> None:
    """Where the torque turned midway between two, or within a millisecond, they were untimed."""
    folder = read_drive_folder(simulated(tmp_path / "d", tests=1, **changes))
    loop = read_test_loop(folder, folder.tests[0])
    assert loop.warnings == ()
    assert loop.time is not None
    wanted = {**DEFAULTS, **changes}
    legs = 2 * wanted["cycles"] if wanted["one_sided"] else 4 * wanted["cycles"]
    assert loop.time[-1] == pytest.approx(legs * wanted["max_torque_Nm"] / 2.0, rel=0.02)


def test_mounting_scatters_each_parameter_by_a_per_cent(drive: Path) -> None:
    deviations = [
        np.log(test["mounted"][name] / value)
        for test in truth_of(drive)["tests"]
        for name, value in test["state"].items()
        if value != 0
    ]
    # About 327 normal deviations: their spread is known to 4 %; four of that, 1 in 15 000.
    assert np.std(deviations) == pytest.approx(truth_of(drive)["remounting_scatter"], rel=0.16)
    assert abs(np.mean(deviations)) < 4 * 0.01 / np.sqrt(len(deviations))
    assert truth_of(drive)["tests"][0]["mounted"]["T_T"] == 0


def test_wear_never_heals(drive: Path) -> None:
    states = [test["state"] for test in truth_of(drive)["tests"]]
    for name, sign in (("b", -1), ("K_W", -1), ("T_i", -1), ("T_T", 1), ("mu", 1), ("c", 1)):
        assert (sign * np.diff([state[name] for state in states]) >= 0).all(), name


def test_the_record_is_the_mounted_drive_with_the_noise_of_the_rig(drive: Path) -> None:
    folder, truth = read_drive_folder(drive), truth_of(drive)
    torque = torque_history(RATED, 120, 1, one_sided=False)
    for number in (0, 20, 40):
        loop = read_test_loop(folder, folder.tests[number])
        mounted = {n: np.asarray(v) for n, v in truth["tests"][number]["mounted"].items()}
        # Where the mesh stood before the first reading is forgotten once the torque has turned.
        rest = (loop.angle - predict(torque, mounted))[40:]
        expected = np.hypot(1e-5, 9.77e-6 / np.sqrt(12))
        # 80 readings know a spread to 8 %; four of that, 1 in 15 000, of three tests.
        assert np.std(rest) == pytest.approx(expected, rel=0.33)
        assert np.abs(loop.torque - torque).max() < 0.05 + 5 * 0.03


def test_same_seed_same_bytes(drive: Path, tmp_path: Path) -> None:
    assert content(simulated(tmp_path / "drive")) == content(drive)
    other = content(simulated(tmp_path / "other" / "drive", seed=4))
    same = [name for name, written in content(drive).items() if other[name] == written]
    assert same == ["drive.toml"]


def test_torque_is_read_in_steps_of_a_tenth() -> None:
    torque = torque_history(RATED, 300, 1, one_sided=True)
    parameters = {name: np.asarray(value) for name, value in POST_TEST.items()}
    table = measured_loop(parameters, torque, np.random.default_rng(0))
    steps = table["torque_Nm"] / 0.1
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert np.unique(np.round(steps)).size > 100
    steps = table["angle_rad"] / 9.77e-6
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


@pytest.mark.parametrize(
    ("one_sided", "lowest", "travelled"), [(False, -RATED, 12 * RATED), (True, 0.0, 6 * RATED)]
)
def test_torque_starts_and_ends_at_zero(one_sided: bool, lowest: float, travelled: float) -> None:
    torque = torque_history(RATED, 7201, 3, one_sided=one_sided)
    assert torque.size == 7201
    assert (torque[0], torque[-1]) == (0, 0)
    assert torque.max() == pytest.approx(RATED, rel=1e-3)
    assert torque.min() == pytest.approx(lowest, rel=1e-3)
    assert np.abs(np.diff(torque)).sum() == pytest.approx(travelled, rel=1e-3)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_course_of_wear_has_the_mean_of_its_power_law(scenario: str) -> None:
    hours = np.arange(0.0, 2001.0, 5.0)
    law = SCENARIOS[scenario]
    rng = np.random.default_rng(8)
    ends = [law.course(hours, rng)[-1] for _ in range(200)]
    mean = law.rate * 2.0**law.exponent
    # The increments that would fall are cut off, which lifts the mean; half as much again at most.
    assert 0.95 * mean < np.mean(ends) < 1.5 * mean


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_dataset_is_made_by_the_command_it_names(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from typer.testing import CliRunner

    from hdprog.cli import app

    source = Path(str(shipped("datasets"))) / name
    truth = truth_of(source)
    program, *arguments = shlex.split(truth["made_by"])
    assert program == "hdprog"
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    made, kept = content(tmp_path / arguments[arguments.index("--out") + 1]), content(source)
    again = json.loads(made.pop("truth.json"))
    kept.pop("truth.json")
    assert made == kept
    assert_same(again | {"made_by": truth["made_by"]}, truth)


@pytest.mark.parametrize(
    "changes",
    [
        {"max_torque_Nm": 0.0},
        {"max_torque_Nm": 1e-5},
        {"max_torque_Nm": float("inf")},
        {"max_torque_Nm": -5.0},
        {"samples": 19},
        {"samples": 59, "cycles": 3},
    ],
)
def test_a_loop_that_cannot_be_measured_is_refused(changes: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(
        UsageError, match=r"--samples: found .* expected .* fewer --cycles\."
    ) as refused:
        simulated(tmp_path / "d", **changes)
    assert refused.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []


def test_a_drive_that_was_not_simulated_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "drive.toml").write_text("[drive]\n", "utf-8")
    with pytest.raises(BadInputError, match=r"no truth\.json"):
        simulated(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["drive.toml"]
    simulated(tmp_path / "new", tests=1)
    simulated(tmp_path / "new", tests=2)
