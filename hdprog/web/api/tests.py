"""The API of tests: uploading records."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, File, Request, UploadFile
from starlette.datastructures import UploadFile as StarletteFile

from hdprog.errors import BadInputError
from hdprog.store.uploads import TestFacts, said_otherwise
from hdprog.web.api.models import TestAccepted, problems
from hdprog.web.facts import FIELDS, facts_of_form
from hdprog.web.lookup import drive_named
from hdprog.web.names import DriveName
from hdprog.web.security.identity import WritingProgram
from hdprog.web.service import service_of

router = APIRouter(prefix="/api/v1", tags=["tests"])

_MOST_TOLD = 10  # unknown fields
# A form without them is refused in words of ours, not of the form's reader, which would know.
_HOURS_REQUIRED = {
    "requestBody": {"content": {"multipart/form-data": {"schema": {"required": ["service_hours"]}}}}
}


async def one_file(request: Request, who: WritingProgram) -> tuple[str, ...]:
    """Refuse what would be let fall in silence, all files but the last; give unknown fields.

    Who asks comes first: without a token there is nothing to be told of the file.

    Raises
    ------
    BadInputError
        for no file or several
    """
    form = await request.form()
    files = form.getlist("file")
    if len(files) != 1 or not isinstance(files[0], StarletteFile):
        found = f"{len(files)} of them" if len(files) > 1 else "no file with a name"
        raise BadInputError(
            found,
            "field file",
            "one file, the record of one test",
            "Send each record in a request of its own, as a file of multipart/form-data.",
        )
    return tuple(dict.fromkeys(name for name in form if name != "file" and name not in FIELDS))


@router.post(
    "/drives/{drive_id}/tests",
    status_code=202,
    responses=problems(400, 401, 403, 404, 413, 422, 507),
    openapi_extra=_HOURS_REQUIRED,
)
def upload_test(
    request: Request,
    who: WritingProgram,
    unknown: Annotated[tuple[str, ...], Depends(one_file)],
    drive_id: DriveName,
    facts: Annotated[TestFacts, Depends(facts_of_form)],
    file: Annotated[UploadFile, File(description="The record, as hdprog check reads it.")],
) -> TestAccepted:
    """Upload the record of a test, with its service hours.

    A record that cannot be read is refused with the words of `hdprog check`. The same record
    again is the same test. What makes one doubt that it is this drive's is among the warnings,
    and so are fields of other names than those here, which are not used.
    """
    service = service_of(request)
    with service.store.reading() as session:
        name = drive_named(session, drive_id).name
    service.require_room()
    taken = service.take_in(who.actor, name, file.file, file.filename or "", facts, accepted=True)
    doubts = list(filter(None, (taken.doubt, taken.test.quality.get("copied"))))
    doubts += [
        f"field {name[:40]!r}: found no field of that name here, so that its value was not used; "
        f"expected only file, {', '.join(FIELDS)}. Correct the name, and the test on its page."
        for name in unknown[:_MOST_TOLD]
    ]
    if otherwise := said_otherwise(taken.test, facts):
        doubts.append(
            f"This record is test {taken.test.label} of the drive already: its "
            f"{', '.join(otherwise)} stayed as before. Correct what is wrong on the test's page."
        )
    return TestAccepted(
        job_id=None if taken.job is None else taken.job.id,
        test_id=taken.test.label,
        test_uid=taken.test.uid,
        new=taken.new,
        warnings=doubts + list(taken.test.quality.get("warnings", [])),
    )
