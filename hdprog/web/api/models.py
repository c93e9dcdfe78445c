"""What the API takes and gives, as its OpenAPI document describes it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from hdprog.errors import BadInputError

Responses = dict[int | str, dict[str, Any]]


class Problem(BaseModel):
    """Why a request was refused: what was found, where, what was expected, what to do."""

    detail: str
    problems: list[str]


def _without_nulls(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_nulls(one) for name, one in value.items() if one is not None}
    if isinstance(value, list):
        return [_without_nulls(one) for one in value]
    return value


class DriveFile(BaseModel):
    """The content of a drive.toml as JSON; its parts are checked as the file's are."""

    model_config = ConfigDict(
        extra="allow",
        json_schema_extra={
            "examples": [
                {
                    "drive": {"id": "cell3-axis2", "model": "CSF-25-80", "rated_torque_Nm": 63.0},
                    "limits": [{"quantity": "lost_motion_arcmin", "above": 2.0}],
                }
            ]
        },
    )

    drive: dict[str, Any]
    limits: list[dict[str, Any]] = []

    @property
    def declared(self) -> dict[str, Any]:
        """What is given, without nulls: TOML has none, and leaving out says the same."""
        try:
            given: dict[str, Any] = _without_nulls(self.model_dump(exclude_unset=True))
        except RecursionError as error:
            raise BadInputError(
                "values within values, hundreds deep",
                "body",
                "the content of a drive.toml, whose values are at most in lists in sections",
                "Correct it.",
            ) from error
        return given


class DriveMade(BaseModel):
    """A drive that is there."""

    id: str
    url: str


class DriveLine(BaseModel):
    """A drive in a list, worst first."""

    id: str
    status: str
    provisional: bool
    sentence: str
    tests: int
    last_test_hours: float | None
    remaining_hours: dict[str, float | None]
    inspect_before_hours: float | None
    outdated: Annotated[
        bool, Field(description="True where it lacks what was uploaded or changed since.")
    ]


class DriveList(BaseModel):
    """A page of the fleet."""

    drives: list[DriveLine]
    found: int
    page: int


class TestAccepted(BaseModel):
    """A test that was accepted, and the job that will analyse it."""

    job_id: str | None
    test_id: str
    test_uid: str
    new: Annotated[bool, Field(description="False where the drive had this very file already.")]
    warnings: list[str]


class JobState(BaseModel):
    """How far a job is."""

    id: str
    state: Literal["queued", "running", "done", "failed"]
    progress: Annotated[float, Field(ge=0, le=1)]
    error: str | None
    stage: str
    cancelled: bool
    drive_id: str
    test_id: str | None
    created_at: datetime
    finished_at: datetime | None


def problems(*codes: int) -> Responses:
    """Describe the refusals of an operation; any may find that the database does not answer."""
    words = {
        400: "The request is not what its form says.",
        401: "No valid token.",
        403: "The token's role does not suffice.",
        404: "There is no such thing.",
        409: "It is there already.",
        413: "More than the server takes in.",
        422: "What was sent cannot be used; the words say why.",
        503: "The database does not answer.",
        507: "The server's disk is full.",
    }
    return {code: {"model": Problem, "description": words[code]} for code in sorted({*codes, 503})}
