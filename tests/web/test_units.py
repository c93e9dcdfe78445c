"""Pages show figures in the units that a drive's reports are written in."""

from __future__ import annotations

from hdprog.reporting.rounding import significant
from hdprog.store.audit import COMMAND_LINE
from hdprog.store.drives import change_drive, content_of, find_drive
from hdprog.store.uploads import list_tests
from tests.reporting.drives import LOST_MOTION, SECANT, wearing
from tests.web.conftest import ClientOf, service_in
from tests.web.server import text_of
from tests.web.test_forecast_dates import analysed

ARCMIN = 0.29088820866572  # mrad


def test_figures_are_in_the_units_of_the_reports(person: ClientOf) -> None:
    """The verdict told mrad and in·lbf, the tables beside it arcmin and Nm."""
    result = wearing(LOST_MOTION, SECANT)
    viewer = person("viewer")
    name = analysed(service_in(viewer), result)
    with service_in(viewer).store.writing() as session:
        drive = find_drive(session, name)
        assert drive is not None
        report = {"angle_unit": "mrad", "torque_unit": "in-lbf"}
        change_drive(session, COMMAND_LINE, drive, content_of(drive) | {"report": report})
        uid = list_tests(session, drive, "accepted")[0].uid
    median = result.tests[0].figures["lost_motion_arcmin"][0.5]
    page = " ".join(text_of(viewer.get(f"/drives/{name}").text).split())
    assert "lost motion above 0.5818 mrad" in page
    assert "secant stiffness at 124 in·lbf below 106 200 in·lbf/rad" in page
    assert "rated torque 558 in·lbf" in page
    assert f"{significant(ARCMIN * median)} mrad" in page
    figures = text_of(viewer.get(f"/tests/{uid}").text).partition("Figures of merit")[2]
    assert "lost motion" in figures
    assert " mrad" in figures
    for other in ("arcmin", "Nm"):
        assert other not in page.partition("Forecast")[2]
        assert other not in figures.partition("Report of this test")[0]
