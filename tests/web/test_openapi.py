"""The API answers as its OpenAPI document says, whatever it is sent."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from schemathesis import Case
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)
from starlette.testclient import TestClient

from hdprog.service.web_settings import WebSettings
from hdprog.store import accounts
from hdprog.store.audit import COMMAND_LINE
from hdprog.web.app import create_app

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[TestClient, str]]:
    app = create_app(WebSettings(tmp_path_factory.mktemp("data"), max_upload_mb=1.0))
    with TestClient(app) as client:
        with app.state.service.store.writing() as session:
            token = accounts.add_token(session, COMMAND_LINE, "tests", "engineer")
        client.post(
            "/api/v1/drives",
            json={"drive": {"id": "known"}},
            headers={"authorization": f"Bearer {token}"},
        )
        yield client, token


def test_any_request(served: tuple[TestClient, str]) -> None:
    """Any request that the document allows, and some that it does not, gets an answer of its."""
    client, token = served
    document = schemathesis.openapi.from_asgi("/api/v1/openapi.json", client.app)
    tried = 0
    for found in document.get_all_operations():
        operation = found.ok()

        @settings(
            max_examples=12,
            deadline=None,
            derandomize=True,
            database=None,
            phases=[Phase.explicit, Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(case=operation.as_strategy())
        def answers(case: Case) -> None:
            case.call_and_validate(headers={"Authorization": f"Bearer {token}"}, checks=CHECKS)

        answers()
        tried += 1
    assert tried >= 9


def test_every_operation_has_a_summary_and_its_refusals(served: tuple[TestClient, str]) -> None:
    document = served[0].get("/api/v1/openapi.json").json()
    operations = [one for path in document["paths"].values() for one in path.values()]
    assert len(operations) >= 9
    for one in operations:
        assert one["description"]
        assert "503" in one["responses"]
        if one["tags"] != ["health"]:
            assert "401" in one["responses"]


def test_what_an_upload_is_refused_without_is_required(served: tuple[TestClient, str]) -> None:
    """Programs that are made of the document must not take service hours for optional."""
    client, token = served
    document = client.get("/api/v1/openapi.json").json()
    upload = document["paths"]["/api/v1/drives/{drive_id}/tests"]["post"]
    schema = upload["requestBody"]["content"]["multipart/form-data"]["schema"]
    named = document["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
    assert {*schema["required"], *named["required"]} == {"file", "service_hours"}
    answer = client.post(
        "/api/v1/drives/known/tests",
        files={"file": ("loop.csv", b"torque_Nm,angle_rad\n")},
        headers={"authorization": f"Bearer {token}"},
    )
    assert answer.status_code == 422
    assert "no service hours" in answer.json()["detail"]
