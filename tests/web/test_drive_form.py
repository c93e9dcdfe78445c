"""The form of a drive: what it has no fields for is not lost."""

from __future__ import annotations

from hdprog.web.drive_form import content_of_form, fields_of

CONTENT = {
    "drive": {"id": "cell3-axis2", "model": "CSF-25-80", "rated_torque_Nm": 63.0},
    "limits": [{"quantity": "lost_motion_arcmin", "above": 2.0}],
    "forecast": {"horizon_hours": 20000.0},
    "columns": {"torque": "M"},
    "select": {"cycle": [2]},
    "report": {"torque_unit": "in·lbf"},
}


def test_a_form_sent_back_as_it_came_changes_nothing() -> None:
    assert content_of_form(fields_of(CONTENT), CONTENT) == CONTENT


def test_what_is_emptied_in_the_form_goes() -> None:
    fields = fields_of(CONTENT) | {"columns_torque": "", "forecast_horizon_hours": ""}
    content = content_of_form(fields, CONTENT)
    assert "columns" not in content
    assert "forecast" not in content
    assert content["report"] == CONTENT["report"]
