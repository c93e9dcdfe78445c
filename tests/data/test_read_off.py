"""Figures read off a record without a model, held against those of the drive that made it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from hdprog.config import Drive
from hdprog.data.check import check_path
from hdprog.data.read_off import readings
from hdprog.physics.drive_model import predict
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.torque_path import TorquePath
from tests.reporting.drives import NEW, WORN

TOP = 63.0
OPERATION = Operation(math.radians(30.0), TOP, TOP)
REQUESTS = (
    FigureRequest("hysteresis_width_arcmin"),
    FigureRequest("hysteresis_loss_J"),
    FigureRequest("lost_motion_arcmin"),
    FigureRequest("secant_stiffness_Nm_per_rad", 14.0),
    FigureRequest("preload_Nm"),
)


def along(*turns: float, samples: int = 400) -> TorquePath:
    """Straight ramps from turn to turn, so many readings each."""
    ramps = [np.linspace(a, b, samples, endpoint=False) for a, b in pairwise(turns)]
    return TorquePath.exact(np.append(np.concatenate(ramps), turns[-1]))


@pytest.mark.parametrize("state", [NEW, WORN], ids=["new", "worn"])
def test_they_are_those_of_the_drive(state: dict[str, float]) -> None:
    """But for bends near a torque, which lines do not follow: a few hundredths."""
    path = along(0.0, TOP, -TOP, TOP, -TOP, 0.0)
    angle = predict(path.torque, state)
    exact = figures(REQUESTS, {name: np.array([value]) for name, value in state.items()}, OPERATION)
    found = {key: float(how.of(angle)) for key, how in readings(path, REQUESTS, TOP).items()}
    assert list(found) == [request.key for request in REQUESTS[:-1]]
    for key, value in found.items():
        assert value == pytest.approx(float(exact[key][0]), rel=0.05), key


def test_what_a_record_does_not_show_is_not_read() -> None:
    """Its first rise is from rest: no branch of a cycle; its last ends at zero torque."""
    assert readings(along(0.0, TOP, 0.0), REQUESTS, TOP) == {}
    found = readings(along(0.0, TOP, -TOP, 0.0), REQUESTS, TOP)
    assert list(found) == ["hysteresis_width_arcmin"]
    shallow = readings(along(0.0, TOP, -TOP, 0.3 * TOP), REQUESTS, TOP)
    assert "hysteresis_loss_J" not in shallow
    assert "lost_motion_arcmin" in shallow


def test_minor_loops_are_no_cycles() -> None:
    """Their branches begin nowhere near an extreme and lie inside."""
    plain = along(0.0, TOP, -TOP, TOP)
    more = along(0.0, TOP, -TOP, TOP, 20.0, 40.0, 0.0, 30.0, -10.0, 20.0)
    for key, how in readings(plain, REQUESTS, TOP).items():
        again = readings(more, REQUESTS, TOP)[key]
        value = float(how.of(predict(plain.torque, WORN)))
        assert float(again.of(predict(more.torque, WORN))) == pytest.approx(value, rel=0.02), key


def test_the_offset_of_the_angle_does_not_count_and_noise_does() -> None:
    path = along(0.0, TOP, -TOP, TOP, 0.0)
    angle, noise = predict(path.torque, WORN), 2e-5
    rng = np.random.default_rng(1)
    drawn = angle + 1.0 + noise * rng.standard_normal((2000, angle.size))
    for key, how in readings(path, REQUESTS, TOP).items():
        sd = how.sd(angle, noise**2 * np.eye(angle.size))
        assert float(how.of(drawn).std()) == pytest.approx(sd, rel=0.08), key
        assert float(how.of(drawn).mean()) == pytest.approx(float(how.of(angle)), rel=1e-3), key


def test_check_tells_them_before_any_fit(tmp_path: Path) -> None:
    """Lost motion hangs on the rated torque, which only a declared drive has."""
    path = along(0.0, TOP, -TOP, TOP, 0.0)
    rows = zip(path.torque, predict(path.torque, WORN), strict=True)
    file = tmp_path / "t01.csv"
    file.write_text("torque_Nm,angle_rad\n" + "\n".join(f"{t},{a}" for t, a in rows), "utf-8")
    drive = replace(Drive.default(), rated_torque=TOP)
    found, bare = check_path(file, drive=drive), check_path(file)
    (line,) = (line for line in found.lines if "Read off it" in line)
    assert re.fullmatch(
        r"  Read off it, no model in between: width 0\.3\d+ arcmin at zero torque, loss 0\.00\d+ J "
        r"a cycle, lost motion 2\.[45]\d* arcmin",
        line,
    )
    (loop,) = found.as_json()["loops"]
    assert list(loop["read_off"]) == [request.key for request in REQUESTS[:3]]
    (loop,) = bare.as_json()["loops"]
    assert list(loop["read_off"]) == [request.key for request in REQUESTS[:2]]


def test_a_branch_with_a_gap_about_a_torque_is_not_read_there() -> None:
    """The other cycle shows the width and the loss as well."""
    path = along(0.0, TOP, -TOP, TOP, -TOP, 0.0)
    angle = predict(path.torque, WORN)
    whole = {key: float(how.of(angle)) for key, how in readings(path, REQUESTS, TOP).items()}
    kept = np.ones(path.torque.size, dtype=bool)
    kept[500:740] = False  # of the first fall, 38 to -38 Nm
    gap = TorquePath.exact(path.torque[kept])
    found = {key: float(how.of(angle[kept])) for key, how in readings(gap, REQUESTS, TOP).items()}
    for key in ("hysteresis_width_arcmin", "hysteresis_loss_J", "lost_motion_arcmin"):
        assert found[key] == pytest.approx(whole[key], rel=0.02), key
