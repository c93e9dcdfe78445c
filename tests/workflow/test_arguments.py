"""Arguments of the Python API that cannot be meant are refused with words, before any fit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hdprog
from hdprog.arguments import checked_record, checked_seed, randomness
from hdprog.data.drive_folder import DriveFolder
from hdprog.errors import BadInputError, UsageError
from hdprog.seeds import LARGEST_SEED
from hdprog.shipped import shipped
from hdprog.tests_of_drive import with_rated_torque

DRIVE = Path(str(shipped("datasets"))) / "wearing-csf-25-80"
FILE = DRIVE / "loops" / "t05.csv"
OF_LOOPS = (hdprog.fit, hdprog.explain, hdprog.compare)


@pytest.fixture(name="loop", scope="module")
def loop_fixture() -> hdprog.Loop:
    return hdprog.read_loop(FILE)


def test_paths_are_refused_with_what_reads_them(loop: hdprog.Loop) -> None:
    stage: Any
    for stage in OF_LOOPS:
        with pytest.raises(UsageError, match=r"loop: found '.*t05.csv'.*hdprog\.read_loop"):
            stage(FILE)
        with pytest.raises(UsageError, match=r"drive: found '.*drive.toml'.*hdprog\.read_drive"):
            stage(loop, DRIVE / "drive.toml")
    with pytest.raises(UsageError, match=r"loop: found 'nofile.csv'.*hdprog\.read_loop"):
        hdprog.explain("nofile.csv", hdprog.read_drive(DRIVE))


def test_arrays_are_told_by_their_type(loop: hdprog.Loop) -> None:
    """All their numbers had been in the message."""
    stage: Any
    for stage in OF_LOOPS:
        with pytest.raises(UsageError, match="loop: found an object of type ndarray, expected"):
            stage(loop.torque)
    for stage in (hdprog.run, hdprog.backtest):
        with pytest.raises(UsageError, match="path: found an object of type Loop, expected"):
            stage(loop)


@pytest.mark.parametrize("rng", [0, np.random.RandomState(0)])
def test_what_is_no_generator_is_refused(loop: hdprog.Loop, rng: Any) -> None:
    stage: Any
    for stage in OF_LOOPS:
        with pytest.raises(UsageError, match=r"rng: found .*numpy\.random\.default_rng\(0\)"):
            stage(loop, rng=rng)


@pytest.mark.parametrize("seed", [-1, 1.5, "1", LARGEST_SEED + 1])
def test_what_is_no_seed_is_refused(loop: hdprog.Loop, seed: Any) -> None:
    """The largest ones had been fitted with, and could not be written."""
    stage: Any
    for stage, given in [*((each, loop) for each in OF_LOOPS), (hdprog.run, DRIVE)]:
        with pytest.raises(UsageError, match=r"seed: found .*, expected a whole number from 0"):
            stage(given, seed=seed)


def test_a_seed_out_of_an_array_can_be_written() -> None:
    assert json.dumps(checked_seed(np.arange(5)[3])) == "3"


def test_ids_and_loads_come_in_sequences(loop: hdprog.Loop) -> None:
    wrong: Any
    for wrong in ("creep", None):
        with pytest.raises(UsageError, match=r"effects: found .*expected ids in a tuple"):
            hdprog.fit(loop, effects=wrong)
    for wrong in (0.8, "much", None):
        with pytest.raises(UsageError, match=r"loads: found .*expected numbers in a tuple"):
            hdprog.run(DRIVE, loads=wrong)


def test_arrays_are_looked_at_as_files_are(loop: hdprog.Loop) -> None:
    """Of arrays a record that no reader takes had been fitted, with a report that looked sound."""
    half = loop.torque[:75]
    no_loops = [
        (loop.torque[:5], loop.angle[:5], "5 samples"),
        (np.full(100, 30.0), loop.angle[:100], "the same torque"),
        (loop.torque, -loop.angle, "falls while the torque rises"),
        (half, loop.angle[:75], "the unloading"),
    ]
    stage: Any
    for stage in OF_LOOPS:
        for torque, angle, words in no_loops:
            with pytest.raises(BadInputError, match=words):
                stage(hdprog.Loop(torque, angle))
    in_milliradians = hdprog.Loop(loop.torque, 1e3 * loop.angle)
    warned, drive = checked_record(in_milliradians, None)
    assert drive == hdprog.Drive.default()
    assert any("Check the units of torque and angle" in text for text in warned.warnings)
    assert checked_record(loop, None)[0] is loop


def test_a_record_is_compared_with_a_drive_that_its_reader_was_not_given(
    loop: hdprog.Loop,
) -> None:
    drive = hdprog.Drive(rated_torque=63_000.0)  # Nmm
    warned = checked_record(loop, drive)[0]
    assert warned.warnings == hdprog.read_loop(FILE, drive=drive).warnings
    assert any("times the drive's rated torque" in text for text in warned.warnings)
    assert checked_record(warned, drive)[0] is warned


def test_torque_beyond_any_drive_is_no_rated_torque(loop: hdprog.Loop) -> None:
    folder = DriveFolder(hdprog.Drive(), (), Path("rig"))
    too_much = hdprog.Loop(1e6 * loop.torque, loop.angle)
    with pytest.raises(
        BadInputError, match=r"rig: found a largest torque of .* unit of the torque"
    ):
        with_rated_torque(folder, [too_much])


def test_a_generator_without_streams_of_its_own_gets_some() -> None:
    made = [randomness(np.random.default_rng(np.random.RandomState(3)), None)[0] for _ in range(2)]
    streams = [one.spawn(1)[0].random(3) for one in made]
    np.testing.assert_array_equal(*streams)
    with_its_own = np.random.default_rng(3)
    assert randomness(with_its_own, None) == (with_its_own, None)
