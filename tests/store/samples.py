"""Drives and tests to put into stores."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import add_drive
from hdprog.store.files import Files
from hdprog.store.tables import DriveRow, JobRow, TestRow
from hdprog.store.uploads import TestFacts, add_test

DATASETS = Path(__file__).resolve().parents[2] / "datasets"
WEARING = DATASETS / "wearing-csf-25-80"


def content(name: str = "cell3-axis2", **drive: Any) -> dict[str, Any]:
    return {
        "drive": {"id": name, "model": "CSF-25-80", "rated_torque_Nm": 63.0, **drive},
        "limits": [
            {"quantity": "lost_motion_arcmin", "above": 2.0},
            {"quantity": "secant_stiffness_Nm_per_rad", "at_torque_Nm": 14.0, "below": 12000.0},
        ],
    }


def add_sample(session: Session, name: str = "cell3-axis2") -> DriveRow:
    return add_drive(session, COMMAND_LINE, content(name))


def add_bytes(
    session: Session,
    files: Files,
    drive: DriveRow,
    data: bytes,
    facts: TestFacts,
    *,
    accepted: bool = True,
    name: str = "loop.csv",
) -> tuple[TestRow, bool]:
    """Add a record of these bytes; nothing is read out of it."""
    incoming, digest, size = files.receive(io.BytesIO(data))
    assert digest == hashlib.sha256(data).hexdigest()
    files.keep(incoming, digest)
    return add_test(
        session,
        COMMAND_LINE,
        drive,
        facts,
        file_name=name,
        sha256=digest,
        size=size,
        quality={},
        accepted=accepted,
    )


def jobs_of(session: Session, drive: DriveRow) -> Sequence[JobRow]:
    """Give all jobs of a drive, the newest first."""
    asked = select(JobRow).where(JobRow.drive_id == drive.id).order_by(JobRow.created_at.desc())
    return session.scalars(asked).all()
