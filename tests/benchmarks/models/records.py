"""Records that the models are compared on."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import hdprog
from hdprog.config import Drive
from hdprog.data.loop import Loop
from hdprog.data.synthetic import write_drive_folder
from hdprog.reproduction.records import DRIVE, record
from hdprog.reproduction.table2 import INITIAL, POST_TEST
from hdprog.shipped import shipped

SEED = 6
_RAMPS = "torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s"
_SPRING = "torque=torque_out:Nm,angle=displacement:deg,time=time:s"
_REST = 4.0  # s at the beginning of the springs' records, left out as their description asks
_LARGE = "test_nr=100,101,102"
_MEASURED = {
    "spring, 4 Nm": ("torsion-spring/kt-4-7*", _SPRING, None),
    "spring, 8 Nm": ("torsion-spring/kt-8-1*", _SPRING, None),
    "cycloidal, run in": ("cycloidal-torque-ramps/base_runin1*", _RAMPS, _LARGE),
    "cycloidal, preloaded": ("cycloidal-torque-ramps/conic_3pre1*", _RAMPS, _LARGE),
}


@dataclass(frozen=True)
class Record:
    """A record with what is declared of its drive.

    Attributes
    ----------
    name : a few words
    made : where it comes from
    """

    name: str
    made: str
    loop: Loop
    drive: Drive


def made() -> Iterator[Record]:
    """Records that the project makes: new, worn, shipped ones, one with a moving output."""
    rng = np.random.default_rng(SEED)
    yield Record("new", "Table 2, initial", record(INITIAL, rng, "new"), DRIVE)
    yield Record("worn", "Table 2, post-test", record(POST_TEST, rng, "worn"), DRIVE)
    shipped_drive = Path(str(shipped("datasets"))) / "undeclared-effect" / "one-effect"
    yield Record(
        "with an effect",
        "datasets/undeclared-effect/one-effect, t01",
        hdprog.read_loop(shipped_drive / "loops" / "t01.csv"),
        hdprog.read_drive(shipped_drive / "drive.toml"),
    )
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "moving"
        command = "hdprog simulate --effect kinematic_error"
        write_drive_folder(
            place,
            seed=SEED,
            scenario="wearing",
            tests=2,
            hours=900.0,
            cycles=3,
            samples=900,
            max_torque_Nm=63.0,
            one_sided=False,
            command=command,
            effects=("kinematic_error",),
        )
        yield Record(
            "output moving",
            "hdprog simulate --effect kinematic_error, t01",
            hdprog.read_loop(place / "loops" / "t01.csv"),
            hdprog.read_drive(place / "drive.toml"),
        )


def measured(data: Path) -> Iterator[Record]:
    """Records that others measured, which are no part of the project."""
    for name, (pattern, columns, select) in _MEASURED.items():
        [path] = sorted(data.glob(pattern))
        loop = hdprog.read_loop(
            path,
            columns=columns,
            select=select,
        )
        if loop.time is not None and "spring" in name:
            loop = _from(loop, _REST)
        yield Record(name, path.name, loop, Drive())


def _from(loop: Loop, start: float) -> Loop:
    assert loop.time is not None
    kept = loop.time >= start
    return Loop(
        loop.torque[kept],
        loop.angle[kept],
        time=loop.time[kept],
        source=loop.source,
        sha256=loop.sha256,
        warnings=loop.warnings,
    )
