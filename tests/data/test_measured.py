"""Records that nobody of this project made: real length, real noise, real file formats."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from hdprog.data.quality import assess
from hdprog.data.readers import read_loop
from hdprog.data.turning_points import turning_points

pytestmark = pytest.mark.measured

CYCLOIDAL = "torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s"
SPRING = "torque=torque_out:Nm,angle=displacement:deg,time=time:s"


@pytest.mark.parametrize("name", ["base_init1", "base_runin1", "conic_init1", "conic_5pre1"])
def test_cycloidal_drive(measured_data: Path, name: str) -> None:
    path = measured_data / "cycloidal-torque-ramps" / f"{name}.csv.gz"
    loop = read_loop(path, columns=CYCLOIDAL, select="test_nr=100,101,102")
    # Time stamps repeat in groups: the order of rows is all that is known.
    assert loop.time is None
    assert any("repeat" in warning for warning in loop.warnings)
    # Three cycles 0 → +T → -T → 0, whatever the motor's current does within the play.
    points = turning_points(loop.torque)
    assert len(points) == 8
    peak = 25.0 if name.startswith("base") else 38.0
    extremes = [np.abs(loop.torque[a : b + 1]).max() for a, b in pairwise(points[:-1])]
    assert min(extremes) > peak
    if name.startswith("base"):
        # It is held there: a branch ends at the end of its hold, not at its largest noise.
        held = [np.abs(loop.torque[end - 60 : end + 1].mean()) for end in points[1:-1]]
        np.testing.assert_allclose(held, peak, atol=0.1)
    quality = assess(loop)
    assert quality.cycles == pytest.approx(3.0, abs=0.1)
    # The encoder's 65536 steps a revolution; torque noise of ±0.3 Nm by the data's own notes.
    assert quality.angle_step == pytest.approx(2 * np.pi / 65536, rel=1e-6)
    assert 0.1 < quality.torque_noise < 0.3
    assert 200 < quality.secant_stiffness < 1000


@pytest.mark.parametrize("name", ["kt-4-7-55-5-09032023-142108", "kt-8-2-68-5-09032023-143334"])
def test_torsion_spring(measured_data: Path, name: str) -> None:
    loop = read_loop(measured_data / "torsion-spring" / f"{name}.csv.gz", columns=SPRING)
    assert loop.warnings == ()
    quality = assess(loop)
    assert quality.cycles == pytest.approx(1.0, abs=0.01)
    assert quality.branches == 3
    assert quality.duration == pytest.approx(35.0, abs=0.1)
    # What the data's notes say: 1300-2500 Nm/rad, angle noise 1.5e-5 rad.
    assert 1300 < quality.secant_stiffness < 2500
    assert quality.angle_noise == pytest.approx(1.5e-5, rel=0.15)


def test_without_columns_the_message_says_what_to_add(measured_data: Path) -> None:
    path = measured_data / "cycloidal-torque-ramps" / "base_init1.csv.gz"
    with pytest.raises(Exception, match=r"--columns torque=TORQUE:Nm,angle=HEADER:rad"):
        read_loop(path, columns="time=")
