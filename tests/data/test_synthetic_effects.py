"""Effects in a simulated drive folder are those of its truth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hdprog.data import synthetic
from hdprog.data.check import check_path
from hdprog.data.coordinates import record_course
from hdprog.data.drive_folder import read_drive_folder, read_test_loop
from hdprog.data.loop import Loop
from hdprog.data.synthetic import (
    ALPHA,
    reading_times,
    torque_history,
    write_drive_folder,
)
from hdprog.data.synthetic_effects import chosen_effects, rates_of
from hdprog.errors import UsageError
from hdprog.inference.effect_starts import unmet
from hdprog.physics.drive_model import predict
from hdprog.physics.effects import BY_ID, EFFECTS
from hdprog.physics.torque_path import TorquePath

RATED, SAMPLES, CYCLES = 63.0, 600, 3
NEEDS_RATES = sorted(e.id for e in EFFECTS if "several loading rates" in e.needs)
NEEDS_SIGNS = sorted(e.id for e in EFFECTS if "both signs of torque" in e.needs)
ONE_SIDED = [effect.id for effect in EFFECTS if effect.id not in NEEDS_SIGNS]
TORQUE = torque_history(RATED, SAMPLES, CYCLES, one_sided=False)


def simulated(out: Path, **changes: Any) -> Path:
    options: dict[str, Any] = {
        "seed": 11,
        "scenario": "wearing",
        "tests": 2,
        "hours": 400.0,
        "cycles": CYCLES,
        "samples": SAMPLES,
        "max_torque_Nm": RATED,
        "one_sided": False,
        "command": "hdprog simulate",
    }
    return write_drive_folder(out, **{**options, **changes})


def truth_of(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "truth.json").read_text("utf-8"))


def loops_of(folder: Path) -> list[Loop]:
    drive = read_drive_folder(folder)
    return [read_test_loop(drive, test) for test in drive.tests]


@pytest.fixture(name="fine")
def fine_fixture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the encoder resolve what a small effect adds."""
    monkeypatch.setattr(synthetic, "ANGLE_STEP", 1e-8)


def rms_added(one: Path, other: Path) -> float:
    """Root mean square in rad of the difference of all angles of two folders."""
    pairs = zip(loops_of(one), loops_of(other), strict=True)
    return float(np.sqrt(np.mean([(a.angle - b.angle) ** 2 for a, b in pairs])))


@pytest.mark.usefixtures("fine")
@pytest.mark.parametrize("name", BY_ID)
def test_an_effect_adds_what_the_truth_says(name: str, tmp_path: Path) -> None:
    plain = simulated(tmp_path / "plain")
    folder = simulated(tmp_path / "with", effects=(name,))
    report = check_path(folder)
    assert report.ok, report.lines
    assert report.warnings == ()

    truth, without = truth_of(folder), truth_of(plain)
    [effect] = truth.pop("effects")
    assert truth == without
    assert set(effect) == {"id", "parameters", "units", "rms_rad"}
    assert effect["id"] == name

    loops = loops_of(folder)
    course = record_course(loops[0], TorquePath.exact(TORQUE), 0.03)
    assert unmet(BY_ID[name], course) == ()
    described = {each.name: each for each in BY_ID[name].parameters(course.scales)}
    assert effect["units"] == {each.name: each.unit for each in described.values()}
    assert set(effect["parameters"]) == set(described)
    for key, value in effect["parameters"].items():
        coordinate = described[key].coordinate(value)
        # The scales of the record as read differ a little from those of the exact one.
        if described[key].amplitude:
            assert 0.4 < abs(coordinate) < 1.6, key
        else:
            assert abs(coordinate) < 0.8, key

    for loop, bare in zip(loops, loops_of(plain), strict=True):
        np.testing.assert_array_equal(loop.torque, bare.torque)
    # Written to a hundred-millionth of a rad.
    assert rms_added(folder, plain) == pytest.approx(effect["rms_rad"], rel=0.01)
    assert effect["rms_rad"] > 2e-6


@pytest.mark.usefixtures("fine")
def test_of_two_effects_each_has_its_own_share(tmp_path: Path) -> None:
    names = ("torque_offset", "angle_ripple", "asymmetry", "kinematic_error")
    both = simulated(tmp_path / "both", effects=names)
    entries = truth_of(both)["effects"]
    assert [entry["id"] for entry in entries] == list(names)
    for entry in entries:
        others = [name for name in names if name != entry["id"]]
        rest = simulated(tmp_path / f"without_{entry['id']}", effects=others)
        kept = {each["id"]: each["parameters"] for each in truth_of(rest)["effects"]}
        assert kept == {e["id"]: e["parameters"] for e in entries if e is not entry}
        assert rms_added(both, rest) == pytest.approx(entry["rms_rad"], rel=0.01)


@pytest.mark.usefixtures("fine")
def test_a_torque_sensor_with_an_offset_reads_too_much(tmp_path: Path) -> None:
    folder = simulated(tmp_path / "d", effects=("torque_offset",))
    truth, loop = truth_of(folder), loops_of(folder)[0]
    [effect] = truth["effects"]
    offset = effect["parameters"]["zero_torque"]
    mounted = {name: np.asarray(value) for name, value in truth["tests"][0]["mounted"].items()}
    # The reading follows the programme; the drive feels less. Forgotten after the first turns:
    # where the mesh stood.
    assert np.abs(loop.torque - TORQUE).max() < 0.05 + 5 * 0.03
    rest = (loop.angle - predict(TORQUE - offset, mounted, ALPHA))[SAMPLES // 4 :]
    assert np.std(rest) == pytest.approx(1e-5, rel=0.15)


def test_cycles_run_at_one_four_and_twelve_times_the_rate(tmp_path: Path) -> None:
    for name in NEEDS_RATES:
        loop = loops_of(simulated(tmp_path / name, effects=(name,), cycles=4))[0]
        assert loop.time is not None
        torque = torque_history(RATED, SAMPLES, 4, one_sided=False)
        rate = np.abs(np.diff(torque) / np.diff(loop.time))
        # Turns at 3, 7, 11 and 16 times the largest torque; readings beside them mix two rates.
        within = np.searchsorted([3, 7, 11], (np.arange(SAMPLES - 1) + 0.5) / (SAMPLES - 1) * 16)
        for cycle, expected in enumerate((2.0, 8.0, 24.0, 2.0)):
            assert np.median(rate[within == cycle]) == pytest.approx(expected, rel=1e-3)


def test_without_a_need_for_rates_there_is_one() -> None:
    assert rates_of([BY_ID["creep"], BY_ID["backlash"]]) == (1.0,)
    times = reading_times(RATED, 100, 2, (1.0,), one_sided=True)
    np.testing.assert_allclose(np.diff(times), 4 * RATED / 2.0 / 99)


def test_the_output_creeps_round_where_an_effect_needs_it(tmp_path: Path) -> None:
    turned = loops_of(simulated(tmp_path / "turned", effects=("kinematic_error",)))
    for loop in turned:
        assert loop.output_angle is not None
        assert np.ptp(loop.output_angle) == pytest.approx(0.3)
    assert loops_of(simulated(tmp_path / "held", effects=("creep",)))[0].output_angle is None


@pytest.mark.parametrize("name", ONE_SIDED)
def test_a_one_sided_loop_shows_every_effect_that_it_can(name: str, tmp_path: Path) -> None:
    for seed in range(3):
        out = tmp_path / f"{name}{seed}"
        [effect] = truth_of(simulated(out, seed=seed, effects=(name,), one_sided=True))["effects"]
        assert effect["rms_rad"] > 1e-6, seed


def test_an_effect_asked_for_twice_is_added_once() -> None:
    chosen = chosen_effects(["creep", "backlash", "creep"], cycles=1, one_sided=False)
    assert [effect.id for effect in chosen] == ["creep", "backlash"]


def refusals() -> list[Any]:
    signs = [({"effects": (name,), "one_sided": True}, "--one-sided") for name in NEEDS_SIGNS]
    rates = [({"effects": (name,), "cycles": 2}, "--cycles: found 2") for name in NEEDS_RATES]
    unknown = [({"effects": ("creep", "nosuch")}, "--effect: found nosuch; .*backlash, .*creep")]
    return signs + rates + unknown


@pytest.mark.parametrize(("changes", "words"), refusals())
def test_what_no_loop_can_show_is_refused(
    changes: dict[str, Any], words: str, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=words) as refused:
        simulated(tmp_path / "d", **changes)
    assert refused.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []
