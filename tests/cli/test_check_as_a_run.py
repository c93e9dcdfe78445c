"""`hdprog check` tells beforehand what a run would refuse."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Invoke
from tests.data.samples import two_sided

DRIVE = '[drive]\nid = "a"\nmodel = "{model}"\nrated_torque_Nm = 63.0\n'
SECANT = """[[limits]]
quantity = "secant_stiffness_Nm_per_rad"
at_torque_Nm = {}
below = {}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    torque, angle = two_sided()
    rows = "\n".join(f"{one:.4f},{other:.8f}" for one, other in zip(torque, angle, strict=True))
    (tmp_path / "t01.csv").write_text(f"torque_Nm,angle_rad\n{rows}\n", "utf-8")
    (tmp_path / "tests.csv").write_text("test_id,file,service_hours\nt01,t01.csv,700\n", "utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("model", "more", "code", "words"),
    [
        ("CSF-25-80", "", 0, "usable"),
        ("CSF-25-80", "[forecast]\nhorizon_hours = 500.0\n", 3, "{at}, [forecast] horizon_hours"),
        ("CSF-25-80", '[prior]\nfile = "csf-99-80"\n', 3, "no prior called"),
        ("XYZ-99", '[[limits]]\nquantity = "K2_Nm_per_rad"\nbelow = 1.0\n', 3, "no T1 and T2"),
        ("XYZ-99", "", 0, "No prior is known for model XYZ-99"),
        ("CSF-50-80", "", 0, "times that of the catalogue for CSF-50-80"),
        (
            "CSF-25-80",
            SECANT.format(14.0, 13.0),
            0,
            "times less than anything that the drive's prior",
        ),
        ("XYZ-99", SECANT.format(14.0, 13.0), 0, "times less than anything that the drive's prior"),
        ("CSF-25-80", SECANT.format(630.0, 1e4), 0, "has a limit, and the tests reach"),
    ],
)
def test_a_drive_is_checked_as_a_run_would(
    invoke: Invoke, folder: Path, model: str, more: str, code: int, words: str
) -> None:
    (folder / "drive.toml").write_text(DRIVE.format(model=model) + more, "utf-8")
    shown = invoke("check", str(folder))
    assert shown.exit_code == code
    assert words.format(at=folder / "drive.toml") in shown.stdout


def test_a_drive_file_beside_folders_alone_is_not_passed_over(invoke: Invoke, folder: Path) -> None:
    own = folder / "drive.toml"
    own.write_text(DRIVE.format(model="CSF-25-80"), "utf-8")
    shown = invoke("check", str(folder), "--drive", str(own))
    assert shown.exit_code == 2
    assert "A drive folder is checked by its own drive.toml" in shown.stderr
    assert invoke("check", str(folder / "t01.csv"), str(folder), "--drive", str(own)).exit_code == 0
