"""Names in addresses: what a drive's, a test's or a job's may look like."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path

DriveName = Annotated[str, Path(min_length=1, max_length=100, description="The drive's id.")]
TestName = Annotated[str, Path(min_length=1, max_length=220, description="The test's id.")]
JobNumber = Annotated[
    str, Path(pattern=r"^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$", description="The job's id.")
]
