"""Making a drive: pick it from the catalogue, then check what was filled in."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import RedirectResponse, Response

from hdprog.errors import BadInputError
from hdprog.inference.catalogue import CatalogueGear, gears, look_up
from hdprog.inference.prior_file import name_of_model, read_prior_file
from hdprog.store.drives import add_drive
from hdprog.web.drive_form import content_of_form, context_of, fields_of
from hdprog.web.rendering import render
from hdprog.web.security.identity import Engineer, Identity, form_of_ours
from hdprog.web.service import service_of

router = APIRouter()
_SHARE = 0.6
_LOST_MOTION = 2.0


@router.get("/drives/new")
def pick_page(
    request: Request,
    who: Engineer,
    series: Annotated[str, Query(max_length=10)] = "",
    size: Annotated[str, Query(max_length=6)] = "",
    ratio: Annotated[str, Query(max_length=6)] = "",
) -> Response:
    """Show the form, filled in from the catalogue where a gear was picked."""
    problems: list[str] = []
    proposed: dict[str, Any] = {"drive": {"id": ""}}
    picked = None
    if series and size.isdecimal() and ratio.isdecimal():  # ² is a digit, but no number
        try:
            picked = look_up(series, int(size), int(ratio))
            proposed = _proposal(picked, series, int(size), int(ratio))
        except BadInputError as error:
            problems = [str(error)]
    elif series or size or ratio:
        problems = ["Pick series, size and ratio, all three, or fill in the form without them."]
    return _page(request, who, fields_of(proposed), problems, picked, (series, size, ratio))


@router.post("/drives/new", dependencies=[Depends(form_of_ours)])
async def make(request: Request, who: Engineer) -> Response:
    """Make a drive of the form."""
    fields = {name: str(value) for name, value in (await request.form()).items()}
    return await run_in_threadpool(_make, request, who, fields)


def _make(request: Request, who: Identity, fields: dict[str, str]) -> Response:
    try:
        content = content_of_form(fields)
        with service_of(request).store.writing() as session:
            drive = add_drive(session, who.actor, content)
            name = drive.name
    except BadInputError as error:
        return _page(request, who, fields_of({}) | fields, [str(error)], None, ("", "", ""), 422)
    return RedirectResponse(f"/drives/{name}?said=made", 303)


def _page(
    request: Request,
    who: Identity,
    fields: dict[str, str],
    problems: list[str],
    picked: CatalogueGear | None,
    choice: tuple[str, str, str],
    status: int = 200,
) -> Response:
    known = gears()
    context = context_of(fields) | {
        "problems": problems,
        "picked": picked,
        "choice": choice,
        "series": _choices({name for gear in known for name in gear.series}),
        "sizes": _choices({gear.size for gear in known}),
        "ratios": _choices({ratio for gear in known for ratio in gear.ratios}),
    }
    return render(request, "new_drive.html", context, 422 if problems else status, who=who)


def _choices(values: Iterable[str] | Iterable[int]) -> list[tuple[str, str]]:
    """Give the choices of a list, none of them first."""
    return [("", "–"), *((str(value), str(value)) for value in sorted(values))]


def _proposal(gear: CatalogueGear, series: str, size: int, ratio: int) -> dict[str, Any]:
    """Fill in what the catalogue tells of a gear, and limits as shares of its stiffness."""
    model = f"{series}-{size}-{ratio}"
    numbers, served = gear.numbers, name_of_model(model)
    listed = None if served is None else read_prior_file(served).catalogue
    rated = None if listed is None else listed.rated_torque_Nm
    drive: dict[str, Any] = {"id": "", "model": model, "ratio": float(ratio), "alpha_deg": 30.0}
    limits: list[dict[str, Any]] = []
    if rated is not None:
        drive["rated_torque_Nm"] = rated
        limits.append({"quantity": "lost_motion_arcmin", "above": _LOST_MOTION})
    second = numbers.T1 / numbers.K1 + (numbers.T2 - numbers.T1) / numbers.K2
    for torque, stiffness in ((numbers.T1, numbers.K1), (numbers.T2, numbers.T2 / second)):
        limits.append(
            {
                "quantity": "secant_stiffness_Nm_per_rad",
                "at_torque_Nm": torque,
                "below": float(f"{_SHARE * stiffness:.2g}"),
            }
        )
    return {"drive": drive, "limits": limits}
