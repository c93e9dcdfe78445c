"""Pages out of templates."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from datetime import datetime
from functools import cache
from typing import Any
from urllib.parse import quote

import jinja2
from fastapi import Request
from starlette.responses import HTMLResponse, Response

from hdprog import __version__
from hdprog.config import ReportSettings
from hdprog.config.report_settings import report_settings
from hdprog.reporting.forecast_words import inspect_words, interval_words, middle_words
from hdprog.reporting.reader_units import shown_in
from hdprog.reporting.rounding import hours, percent, percent_beside, plain, significant
from hdprog.reporting.sparkline import sparkline
from hdprog.reporting.words import (
    counted,
    figure_interval,
    quantity,
    threshold_words,
    tidy,
    torque_words,
    with_unit,
)
from hdprog.web.security.identity import Identity, csrf_token, leave_visit
from hdprog.web.service import service_of

STANDINGS = {
    "act": "Act now",
    "plan": "Plan an inspection",
    "present": "Present condition only",
    "good": "Nothing to plan yet",  # no limit in sight, or a risk that is accepted
    "untested": "No result yet",
}
"""How drives stand, worst first, in words."""

_SAID = {
    "made": "The drive is made. Upload its first test below.",
    "saved": "Saved.",
    "accepted": "Accepted. The job that is under way brings the results up to date.",
    "discarded": "Discarded. It does not count.",
    "cancelled": "The job is called off.",
    "again": "The job waits for its turn again.",
    "password": "The password is changed. Log in again with the new one.",
    "out": "You are logged out.",
    "expired": "Your session has ended: nothing of the form was done. Log in and send it again.",
    "empty": "No file was chosen. Choose one or several records first.",
    "imported": "The drive is imported.",
}


def render(
    request: Request,
    template: str,
    context: Mapping[str, Any],
    status: int = 200,
    *,
    who: Identity | None = None,
) -> Response:
    """Make a page.

    Parameters
    ----------
    request : that the page answers
    template : name of its template
    context : what the template needs
    status : of the answer
    who : is asking; pages without one show no way further
    """
    settings = service_of(request).settings
    html = (
        environment()
        .get_template(template)
        .render(
            csrf=csrf_token(request),
            who=who,
            login=settings.login,
            said=_SAID.get(request.query_params.get("said", "")),
            path=request.url.path,
            version=__version__,
            max_upload_mb=settings.max_upload_mb,
            **context,
        )
    )
    response = HTMLResponse(html, status)
    leave_visit(request, response)
    return response


def render_of_drive(
    request: Request,
    template: str,
    content: Mapping[str, Any],
    context: Mapping[str, Any],
    status: int = 200,
    *,
    who: Identity,
) -> Response:
    """Make a page that shows figures of a drive, in the units of its reports; see `render`.

    `content` is that of the drive's drive.toml.
    """
    units = asdict(ReportSettings()) | content.get("report", {})
    with shown_in(report_settings(**units, where="drive settings, [report]")):
        return render(request, template, context, status, who=who)


@cache
def environment() -> jinja2.Environment:
    """Return the templates of all pages."""
    made = jinja2.Environment(
        loader=jinja2.PackageLoader("hdprog.web"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters.update(
        tidy=tidy,
        hours=_hours,
        percent=_percent,
        percent_beside=_percent_beside,
        moment=_moment,
        size=_size,
        number=_number,
        declared=plain,
        segment=_segment,
        details=_details,
        standing=STANDINGS.__getitem__,
    )
    made.globals.update(
        middle_words=middle_words,
        interval_words=interval_words,
        inspect_words=inspect_words,
        sparkline=sparkline,
        quantity=quantity,
        with_unit=with_unit,
        counted=counted,
        figure_interval=figure_interval,
        threshold_words=threshold_words,
        torque_words=torque_words,
    )
    return made


def _hours(value: float | None, otherwise: str = "–") -> str:
    return otherwise if value is None else hours(value)


def _percent(value: float | None, otherwise: str = "–") -> str:
    return otherwise if value is None else percent(value)


def _percent_beside(value: float | None, accepted: float) -> str:
    return "–" if value is None else percent_beside(value, accepted)


def _number(value: float | None, otherwise: str = "–") -> str:
    return otherwise if value is None else significant(value)


def _moment(value: datetime | None) -> str:
    return "–" if value is None else f"{value:%Y-%m-%d %H:%M} UTC"


def _size(value: int) -> str:
    return f"{value / 1e6:.1f} MB" if value >= 1e6 else f"{value / 1e3:.0f} kB"


def _segment(text: str) -> str:
    """Give a name as a part of an address."""
    return quote(text, safe="")


def _details(content: Mapping[str, Any]) -> str:
    """Write a line's details out, with the letters that people typed."""
    return json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False)
