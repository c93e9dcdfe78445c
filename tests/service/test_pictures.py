"""Pictures of a drive's page speak as its report does."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from hdprog.config import ReportSettings
from hdprog.service.pictures import write_pictures
from tests.reporting import drives


def test_pictures_have_the_units_of_the_drive_s_reports(tmp_path: Path) -> None:
    result = drives.wearing(drives.LOST_MOTION, drives.SECANT)
    settings = ReportSettings(angle_unit="mrad", torque_unit="in·lbf")
    write_pictures(
        replace(result, drive=replace(result.drive, report=settings)), tmp_path / "pictures"
    )
    words = json.loads((tmp_path / "pictures" / "pictures.json").read_text("utf-8"))
    told = " ".join(one["alt"] + one["shows"] for one in words)
    missing = [unit for unit in ("mrad", "in·lbf") if unit not in told]
    others = [unit for unit in ("arcmin", "Nm") if unit in told]
    assert (missing, others) == ([], [])
