"""Fixtures of these tests: an application in this process, without workers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from hdprog.service.web_settings import WebSettings
from hdprog.store import accounts
from hdprog.store.audit import COMMAND_LINE
from hdprog.web.app import create_app
from hdprog.web.service import Service
from tests.service_fixtures import database_url, postgres_server, postgres_url, store
from tests.web.server import PASSWORD, log_in

__all__ = ["database_url", "postgres_server", "postgres_url", "store"]

ClientOf = Callable[[str], TestClient]


@pytest.fixture(scope="module")
def app_client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    """Run the application with an account of each role; this client is nobody."""
    data = tmp_path_factory.mktemp("data")
    app = create_app(WebSettings(data, max_upload_mb=1.0))
    with TestClient(app, base_url="http://testserver") as client:
        with service_in(client).store.writing() as session:
            for role in accounts.ROLES:
                accounts.add_user(session, COMMAND_LINE, role, PASSWORD, role)
        yield client


def service_in(client: TestClient) -> Service:
    """Find the service behind a client."""
    found: Service = client.app.state.service  # type: ignore[attr-defined]
    return found


@pytest.fixture(scope="module")
def person(app_client: TestClient) -> ClientOf:
    """Give a browser in which the account of a role is logged in."""

    def make(role: str) -> TestClient:
        client = TestClient(app_client.app)
        assert log_in(client, role).status_code == 303
        return client

    return make


@pytest.fixture(scope="module")
def program(app_client: TestClient) -> ClientOf:
    """Give a program with a token of a role."""

    def make(role: str) -> TestClient:
        with service_in(app_client).store.writing() as session:
            text = accounts.add_token(session, COMMAND_LINE, f"test-{role}", role)  # type: ignore[arg-type]
        return TestClient(app_client.app, headers={"authorization": f"Bearer {text}"})

    return make


@pytest.fixture
def loop_file() -> Path:
    """Give a record that can be used."""
    return Path(__file__).resolve().parents[2] / "datasets/wearing-csf-25-80/loops/t01.csv"
