from __future__ import annotations

import copy
import math
import pickle
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hdprog.config import (
    Drive,
    ForecastSettings,
    Limit,
    NoiseResolution,
    ReportSettings,
    drive_from_mapping,
    read_drive,
)
from hdprog.errors import BadInputError

LOST = Limit("lost_motion_arcmin", 2.0, "above")

FULL = """
[drive]
id = "cell3-axis2"
model = "CSF-25-80"
ratio = 80
alpha_deg = 20.0
rated_torque_Nm = 63.0
reference_torque_Nm = 50.0
[noise]
torque_resolution_Nm = 0.1
angle_resolution_rad = 9.77e-6
[prior]
file = "csf-25-80"
[[limits]]
quantity = "lost_motion_arcmin"
above = 2.0
[[limits]]
quantity = "secant_stiffness_Nm_per_rad"
at_torque_Nm = 14.0
below = 12000.0
[forecast]
horizon_hours = 10000
acceptable_risk = 0.1
next_shutdown_hours = 1500.0
[columns]
torque = "TORQUE:Nm"
time = ""
[select]
test_nr = [100, 101]
mode = "slow, fast"
"""

CONTENT: dict[str, Any] = {
    "drive": {"id": "x", "rated_torque_Nm": 63},
    "limits": [{"quantity": "lost_motion_arcmin", "above": 2}],
}


def test_every_key_is_read_and_converted(tmp_path: Path) -> None:
    # Windows editors put a byte-order mark first.
    (tmp_path / "drive.toml").write_text(FULL, encoding="utf-8-sig")
    drive = read_drive(tmp_path)
    assert drive == read_drive(tmp_path / "drive.toml")
    assert (drive.id, drive.model, drive.ratio) == ("cell3-axis2", "CSF-25-80", 80.0)
    assert drive.alpha == pytest.approx(math.radians(20))
    assert drive.alpha_declared
    assert (drive.rated_torque, drive.reference_torque) == (63.0, 50.0)
    assert (drive.noise.torque_Nm, drive.noise.angle_rad) == (0.1, 9.77e-6)
    assert drive.prior == "csf-25-80"
    assert [limit.key for limit in drive.limits] == [
        "lost_motion_arcmin",
        "secant_stiffness_Nm_per_rad@14Nm",
    ]
    assert drive.limits[1] == Limit("secant_stiffness_Nm_per_rad", 12000.0, "below", 14.0)
    assert drive.forecast.horizon_hours == 10000.0
    assert drive.forecast.next_shutdown_hours == 1500.0
    assert drive.columns == {"torque": "TORQUE:Nm", "time": ""}
    assert drive.select == {"test_nr": ("100", "101"), "mode": ("slow", "fast")}
    assert drive.source == tmp_path / "drive.toml"
    assert pickle.loads(pickle.dumps(drive)) == drive


def test_defaults() -> None:
    drive = drive_from_mapping({"drive": {"id": "x"}})
    assert drive == Drive(id="x")
    assert not drive.alpha_declared
    assert Drive.default().alpha == pytest.approx(math.radians(30))
    assert (drive.forecast.horizon_hours, drive.forecast.acceptable_risk) == (20000.0, 0.05)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c["drive"].update(rated_torqe_Nm=1), "Did you mean rated_torque_Nm"),
        (lambda c: c["drive"].update(idd=c["drive"].pop("id")), "the key idd.*Did you mean id"),
        (lambda c: c.update(limit=[]), "Did you mean limits"),
        (lambda c: c.pop("drive"), r"no \[drive\] table; expected \[drive\] with id"),
        (lambda c: c["drive"].pop("id"), "no id"),
        (lambda c: c["drive"].update(id=3), "quotation marks"),
        (lambda c: c["drive"].update(id=" "), "not empty"),
        (lambda c: c["drive"].update(ratio="80"), "number without quotation"),
        (lambda c: c["drive"].update(ratio=True), "ratio = true"),
        (lambda c: c["drive"].update(rated_torque_Nm=0), "greater than 0"),
        (lambda c: c["drive"].update(rated_torque_Nm=1e300), "1e.06 or less"),
        (lambda c: c.update(forecast={"horizon_hours": 1e8}), "1e.07 or less"),
        (lambda c: c["drive"].update(alpha_deg=90), "60 or less"),
        (lambda c: c["drive"].update(alpha_deg=math.nan), "finite"),
        (lambda c: c.update(forecast={"acceptable_risk": 1.0}), "less than 1"),
        (lambda c: c.update(forecast={"horizon_hours": -1}), "greater than 0"),
        (lambda c: c["limits"][0].update(Max=2.0), "the key Max.*Did you mean above"),
        (lambda c: c["limits"][0].update(min=2.0), "the key min.*Did you mean below"),
        (lambda c: c["drive"].update(max=2.0), "Remove it or correct its name"),
        (lambda c: c["limits"][0].update(below=1), "both above and below"),
        (lambda c: c["limits"][0].pop("above"), "neither above nor below"),
        (lambda c: c["limits"][0].update(at_torque_Nm=5), "Remove at_torque_Nm"),
        (lambda c: c["limits"][0].update(quantity="lost_motion"), "Did you mean lost_motion_arc"),
        (lambda c: c["drive"].pop("rated_torque_Nm"), "Add rated_torque_Nm"),
        (
            lambda c: c["limits"].append(c["limits"][0]),
            "two limits on lost_motion_arcmin, both above = 2; expected limits that differ",
        ),
        (
            lambda c: c["limits"].extend(
                {"quantity": "lost_motion_arcmin", side: at}
                for side, at in (("above", 5.0), ("below", 2.5))
            ),
            "above = 2 and below = 2.5; expected room between",
        ),
        (
            lambda c: c["limits"].append({"quantity": "lost_motion_arcmin", "below": 2.5}),
            "above = 2 and below = 2.5; expected room between.*Exchange above and below",
        ),
        (
            lambda c: c["limits"].append({"quantity": "local_stiffness_Nm_per_rad", "below": 1}),
            "number 2.*without at_torque_Nm",
        ),
        (lambda c: c.update(columns={"torqe": "X:Nm"}), "Did you mean torque"),
        (lambda c: c.update(select={"run": []}), "at least one value"),
        (lambda c: c.update(select={"run": [math.nan]}), "run = nan; expected the values of the"),
        (lambda c: c.update(select={"run": math.inf}), "run = inf; expected the values of the"),
        (lambda c: c.update(select={"run": [1, {"a": 2}]}), "expected the values of the rows"),
        (lambda c: c.update(select={"run": [True]}), "run = true; expected the values of the"),
        (lambda c: c.update(limits={"quantity": "x"}), r"\[\[limits\]\]"),
        (lambda c: c.update(drive=3), "table"),
    ],
)
def test_refusals_name_the_place_and_what_to_do(
    change: Callable[[dict[str, Any]], object], words: str
) -> None:
    content = copy.deepcopy(CONTENT)
    change(content)
    with pytest.raises(BadInputError, match=words):
        drive_from_mapping(content, Path("rig/drive.toml"))


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("drive.id = 2026-01-01", "id = 2026-01-01"),
        ("drive = {id = 'x', rated_torque_Nm = true}", "rated_torque_Nm = true"),
        (
            "drive.id = 'x'\n[limits]\nquantity = 'preload_Nm'\nbelow = 9",
            "limits = {quantity = 'preload_Nm', below = 9}",
        ),
        ("drive.id = 'x'\n[[forecast]]\nhorizon_hours = 9", "forecast = [{horizon_hours = 9}]"),
    ],
)
def test_what_was_found_is_told_as_the_file_has_it(tmp_path: Path, text: str, found: str) -> None:
    (tmp_path / "drive.toml").write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError) as refused:
        read_drive(tmp_path)
    assert refused.value.found == found


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no readable file"),
        (b"[drive\n", "not valid TOML"),
        (b"id = '\xff'", "saved as UTF"),
        (b"ratio = " + 5000 * b"1", "not valid TOML"),
        (b"a = " + 5000 * b"[", "not valid TOML"),
    ],
)
def test_files_that_are_no_drive(tmp_path: Path, text: bytes | None, words: str) -> None:
    path = tmp_path / "drive.toml"
    if text is not None:
        path.write_bytes(text)
    with pytest.raises(BadInputError, match=words):
        read_drive(path)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: Drive(rated_torque=-63.0), "Drive: found rated_torque=-63.0.*greater than 0"),
        (lambda: Drive(reference_torque=math.nan), "reference_torque=nan; expected a finite"),
        (lambda: Drive(ratio=0), "ratio=0; expected a number greater than 0"),
        (lambda: Drive(ratio="80"), "ratio='80'; expected a number"),  # type: ignore[arg-type]
        (lambda: Drive(alpha=45.0), r"alpha=45.0.*math.radians\(30\)"),
        (lambda: Drive(id=" "), "id=' '; expected text that is not empty"),
        (lambda: ForecastSettings(acceptable_risk=5.0), "acceptable_risk=5.0.*less than 1"),
        (lambda: ForecastSettings(horizon_hours=math.inf), "horizon_hours=inf.*finite"),
        (lambda: NoiseResolution(torque_Nm=0.0), "torque_Nm=0.0.*greater than 0"),
        (lambda: Limit("preload_Nm", -1.0, "below"), "threshold=-1.0.*greater than 0"),
        (
            lambda: Limit("preload", 1.0, "below"),
            "Limit: found quantity = .*Did you mean preload_Nm",
        ),
        (lambda: Limit("secant_stiffness_Nm_per_rad", 1.0, "below"), "without at_torque_Nm"),
        (lambda: Limit("preload_Nm", 1.0, "below", 14.0), "Remove at_torque_Nm"),
        (lambda: Limit("preload_Nm", 1.0, "under"), "direction='under'"),  # type: ignore[arg-type]
        (lambda: Drive(limits=(LOST,)), "Drive, limits.*lost_motion_arcmin in a drive without"),
        (lambda: Drive(rated_torque=1.0, limits=(LOST, LOST)), "two limits on lost_motion_arcmin"),
        (lambda: Drive(columns={"torqe": "M:Nm"}), "columns=.*torqe.*only torque, angle, time"),
        (lambda: Drive(columns={"torque": ""}), "columns=.*text that is not empty"),
        (lambda: Drive(select={"run": ()}), "select=.*at least one value"),
        (lambda: Drive(select={"run": (True,)}), "select=.*quotation"),  # type: ignore[dict-item]
        (lambda: ReportSettings(angle_unit="furlong"), 'angle_unit = "furlong".*arcmin'),
    ],
)
def test_settings_made_in_python_keep_the_rules_of_the_file(
    made: Callable[[], object], words: str
) -> None:
    """45 degrees passed for radians, and a rated torque below zero was fitted with."""
    with pytest.raises(BadInputError, match=words):
        made()


def test_columns_rows_and_units_made_in_python_are_those_of_the_file() -> None:
    text = """
        [drive]
        id = "x"
        [columns]
        torque = "M:Nm"
        time = ""
        [select]
        run = [100, 101.5]
        [report]
        torque_unit = "lbf in"
        """
    drive = Drive(
        id="x",
        columns={"torque": "M:Nm", "time": ""},
        select={"run": (100, 101.5)},  # type: ignore[dict-item]
        report=ReportSettings(torque_unit="lbf in"),
    )
    assert drive == drive_from_mapping(tomllib.loads(text))
    assert drive.select == {"run": ("100", "101.5")}


def test_settings_take_whole_numbers_and_those_of_numpy() -> None:
    given = {"ratio": np.int64(80), "rated_torque": np.float32(63.0), "alpha": math.radians(60.0)}
    drive = Drive(**given)  # type: ignore[arg-type]
    assert [drive.ratio, drive.rated_torque] == [80.0, 63.0]
    assert {type(drive.ratio), type(drive.rated_torque)} == {float}
