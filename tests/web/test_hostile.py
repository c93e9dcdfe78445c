"""Uploads by those who mean harm, or whose files do."""

from __future__ import annotations

import asyncio
import errno
import gzip
import io
import re
from pathlib import Path

import pytest
from starlette.datastructures import UploadFile
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.testclient import TestClient
from starlette.types import Message, Receive, Scope, Send

from hdprog.service.web_settings import WebSettings
from hdprog.web.app import create_app
from hdprog.web.security.body_limit import BodyLimit
from tests.web.conftest import ClientOf, service_in
from tests.web.server import csrf_of, text_of

SCRIPT = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def api(program: ClientOf) -> TestClient:
    client = program("engineer")
    made = client.post("/api/v1/drives", json={"drive": {"id": "hostile"}, "limits": []})
    assert made.status_code == 201
    return client


def send(api: TestClient, name: str, data: bytes, **fields: str) -> object:
    return api.post(
        "/api/v1/drives/hostile/tests",
        files={"file": (name, io.BytesIO(data))},
        data={"service_hours": "1", **fields},
    )


def record(loop_file: Path, comment: str) -> bytes:
    """Give a usable record that no other is equal to."""
    return f"# {comment}\n".encode() + loop_file.read_bytes()


def test_scripts_in_names_and_notes_are_words(
    api: TestClient, person: ClientOf, loop_file: Path
) -> None:
    name = f"{SCRIPT}.csv"
    sent = send(api, name, record(loop_file, "script"), note=SCRIPT)
    assert sent.status_code == 202
    client = person("engineer")
    for path in ("/drives/hostile", f"/tests/{sent.json()['test_uid']}", "/"):
        page = client.get(path)
        assert page.status_code == 200
        assert "<script>alert" not in page.text
    assert SCRIPT in text_of(client.get(f"/tests/{sent.json()['test_uid']}").text)
    assert "<script>alert" not in person("admin").get("/audit").text
    refused = send(api, name, b"nothing of use")
    assert refused.status_code == 422


def test_a_record_comes_back_as_bytes_that_do_nothing(
    api: TestClient, person: ClientOf, loop_file: Path
) -> None:
    data = record(loop_file, "<html><script>alert(1)</script>")
    sent = send(api, 'x"\r\nx: y.html', data)
    assert sent.status_code == 202
    answer = person("viewer").get(f"/tests/{sent.json()['test_uid']}/record")
    assert answer.content == data
    assert answer.headers["content-type"] == "application/octet-stream"
    assert answer.headers["content-disposition"].startswith("attachment;")
    assert "x" not in [name for name in answer.headers if name == "x"]
    assert "sandbox" in answer.headers["content-security-policy"]


def test_names_that_climb_stay_names(
    api: TestClient, app_client: TestClient, loop_file: Path
) -> None:
    files = service_in(app_client).store.files
    before = {path for path in files.root.parent.rglob("*") if files.root not in path.parents}
    sent = send(api, "../../../../tmp/evil.csv", record(loop_file, "climb"))
    assert sent.status_code == 202
    after = {path for path in files.root.parent.rglob("*") if files.root not in path.parents}
    assert before == after
    kept = [path.name for path in files.raw.rglob("*") if path.is_file()]
    assert all(re.fullmatch(r"[0-9a-f]{64}(-[0-9]+\.svg)?", name) for name in kept)


def test_more_than_the_limit_is_refused_by_what_it_claims(api: TestClient) -> None:
    answer = api.post(
        "/api/v1/drives/hostile/tests",
        content=b"",
        headers={"content-length": str(2 << 30), "content-type": "multipart/form-data; boundary=x"},
    )
    assert answer.status_code == 413
    assert "--max-upload-mb" in answer.json()["detail"]


def plain(_: Request, status: int, words: str) -> PlainTextResponse:
    return PlainTextResponse(words, status)


@pytest.mark.parametrize("kind", ["application/json", "text/plain", ""])
def test_a_large_body_that_is_no_form_is_not_taken_apart(kind: str) -> None:
    """JSON is parsed in memory before anybody is asked who they are."""
    answers: list[Message] = []
    body = b'{"limits": [' + b"[]," * 400_000 + b"[]]}"
    sent = iter([body[:700_000], body[700_000:]])

    async def receive() -> Message:
        part = next(sent, b"")
        return {"type": "http.request", "body": part, "more_body": bool(part)}

    async def send_on(message: Message) -> None:
        answers.append(message)

    async def parse(scope: Scope, receive: Receive, send: Send) -> None:
        await PlainTextResponse(str(await Request(scope, receive).json()))(scope, receive, send)

    limited = BodyLimit(parse, 64_000_000, plain, stranger=lambda _: None)
    headers = [(b"content-type", kind.encode())] if kind else []
    scope = {"type": "http", "method": "POST", "path": "/", "headers": headers}
    asyncio.run(limited(scope, receive, send_on))
    assert answers[0]["status"] == 413
    assert b"1 MB" in answers[1]["body"]


def test_a_claim_that_is_no_number_is_refused() -> None:
    answers: list[Message] = []

    async def receive() -> Message:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send_on(message: Message) -> None:
        answers.append(message)

    limited = BodyLimit(PlainTextResponse("in"), 1000, plain, stranger=lambda _: None)
    claim = [(b"content-length", b"\xb2")]  # a raised two
    scope = {"type": "http", "method": "POST", "path": "/", "headers": claim}
    asyncio.run(limited(scope, receive, send_on))
    assert answers[0]["status"] == 413


class Stream:
    """A request that streams a record of 800 kB into an application."""

    def __init__(self, path: str, **headers: str) -> None:
        head = b'--x\r\nContent-Disposition: form-data; name="file"; filename="a.csv"\r\n\r\n'
        self.sent = [head, *[b"1" * 40_000] * 20, b"\r\n--x--\r\n"]
        self.left, self.answer = list(self.sent), Response(status_code=0)
        given = {"content-type": "multipart/form-data; boundary=x", "host": "testserver", **headers}
        self.scope: Scope = {
            **{"type": "http", "method": "POST", "path": path, "query_string": b""},
            **{"scheme": "http", "server": ("testserver", 80), "client": ("10.9.8.1", 1)},
            "headers": [(name.encode(), text.encode()) for name, text in given.items()],
        }

    @property
    def size(self) -> int:
        return sum(len(part) for part in self.sent)

    @property
    def taken(self) -> int:
        return self.size - sum(len(part) for part in self.left)

    async def receive(self) -> Message:
        part = self.left.pop(0)
        return {"type": "http.request", "body": part, "more_body": bool(self.left)}

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.answer.status_code, self.answer.raw_headers = message["status"], message["headers"]

    def put_to(self, client: TestClient) -> Response:
        asyncio.run(client.app(self.scope, self.receive, self.send))
        return self.answer


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("/api/v1/drives/x/tests", {}, 401),
        ("/api/v1/drives/x/tests", {"authorization": "Bearer hdp_made-up"}, 401),
        ("/api/v1/drives/x/tests", {"cookie": "hdprog_session=made-up"}, 401),
        ("/drives/x/uploads", {}, 303),
        ("/drives/x/uploads", {"cookie": "hdprog_session=made-up"}, 303),
        ("/login", {}, 303),
    ],
)
def test_what_nobody_known_sends_is_not_put_down(
    app_client: TestClient,
    monkeypatch: pytest.MonkeyPatch,
    path: str,
    headers: dict[str, str],
    status: int,
) -> None:
    """Forms went to the disk before it was asked who sends them: a few requests filled it."""
    written: list[bytes] = []

    async def write(_file: UploadFile, data: bytes) -> None:
        written.append(data)

    monkeypatch.setattr(UploadFile, "write", write)
    stream = Stream(path, **headers)
    assert stream.put_to(app_client).status_code == status
    assert stream.taken < 150_000
    assert sum(map(len, written)) < 65_536
    # A browser that still sends looks at no answer: what it said it would send is thrown away.
    stream = Stream(path, **headers, **{"content-length": str(stream.size)})
    answer = stream.put_to(app_client)
    assert answer.status_code == status
    assert answer.headers["connection"] == "close"
    assert stream.left == []
    assert sum(map(len, written)) < 2 * 65_536


def test_what_somebody_known_sends_is_taken_in(api: TestClient, person: ClientOf) -> None:
    for path, client in (
        ("/api/v1/drives/hostile/tests", api),
        ("/drives/hostile/uploads", person("engineer")),
    ):
        known = {
            "authorization": client.headers.get("authorization", ""),
            "cookie": f"hdprog_session={client.cookies.get('hdprog_session')}",
        }
        stream = Stream(path, **known)
        assert stream.put_to(client).status_code in (422, 403)  # no hours; no token of a form
        assert stream.left == []


def test_without_a_login_everybody_is_known(tmp_path: Path) -> None:
    settings = WebSettings(tmp_path, login=False, max_upload_mb=1.0, hosts=("testserver",))
    with TestClient(create_app(settings), base_url="http://testserver") as client:
        stream = Stream("/drives/x/uploads")
        assert stream.put_to(client).status_code == 403  # no token of a form
        assert stream.left == []
        assert Stream("/api/v1/drives/x/tests").put_to(client).status_code == 401


@pytest.mark.parametrize("at", ["/api/v1/drives/hostile/tests", "/drives/hostile/uploads"])
def test_a_disk_that_fills_as_an_upload_streams_in_is_told(
    api: TestClient, person: ClientOf, monkeypatch: pytest.MonkeyPatch, at: str
) -> None:
    """It was told to be a request in the wrong form, to be corrected and sent again."""

    async def write(_file: UploadFile, _data: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(UploadFile, "write", write)
    client = api if at.startswith("/api") else person("engineer")
    answer = client.post(at, files={"file": ("a.csv", b"1,2\n")})
    assert answer.status_code == 507
    assert "make room" in text_of(answer.text)


def test_a_bomb_within_the_limit(api: TestClient) -> None:
    bomb = gzip.compress(b"torque_Nm,angle_rad\n" + b"\n" * 9_000_000, compresslevel=9)
    assert len(bomb) < 1_000_000
    answer = send(api, "bomb.csv.gz", bomb)
    assert answer.status_code == 422
    assert "bomb.csv.gz" in answer.json()["detail"]


@pytest.mark.parametrize(
    "data", [b"", b"GIF89a" + b"\x00" * 500, b"%PDF-1.7\n", b"\xff\xfe\x00\x00", b"a,b\n=1+1,2\n"]
)
def test_wrong_kinds_are_refused(api: TestClient, data: bytes) -> None:
    answer = send(api, "photo.csv", data)
    assert answer.status_code == 422
    assert "photo.csv" in answer.json()["detail"]


def test_nothing_is_left_of_refused_uploads(api: TestClient, app_client: TestClient) -> None:
    send(api, "x.csv", b"nothing of use")
    assert list(service_in(app_client).store.files.incoming.glob("*.part")) == []


def test_formulas_do_not_run_in_tables(api: TestClient, person: ClientOf) -> None:
    from hdprog.web.pages.downloads import _cell

    assert _cell("=cmd|' /C calc'!A0") == "'=cmd|' /C calc'!A0"
    assert _cell("@SUM(1)") == "'@SUM(1)"
    assert _cell(-1.5) == -1.5


def test_huge_forms_are_refused(person: ClientOf) -> None:
    client = person("engineer")
    csrf = csrf_of(client.get("/drives/new").text)
    answer = client.post("/drives/new", data={"csrf": csrf, "id": "x" * 900_000})
    assert answer.status_code in (400, 413, 422)


@pytest.mark.parametrize(
    "body",
    [
        b"{",
        b"[]",
        b'{"drive": 3}',
        b'{"drive": {"id": {"a": 1}}}',
        b"\xff",
        b'{"drive":{}}',
        b"[" * 5000,
    ],
)
def test_wrong_json(api: TestClient, body: bytes) -> None:
    answer = api.post("/api/v1/drives", content=body, headers={"content-type": "application/json"})
    assert answer.status_code in (400, 422)
    assert answer.json()["problems"]
