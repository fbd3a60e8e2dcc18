"""Whatever is sent, the answer is a sentence and nothing breaks: every route, every kind of nonsense."""

import asyncio
import json
import os
import socket

import httpx
import pytest

from labrun.web.access.fault import FaultLog
from labrun.web.server.app import make_app

NAMES = (
    "x", "..", "%2e%2e%2fetc%2fpasswd", "a%00b", "%ff%fe", "a" * 300, "a" * 3000, "%F0%9F%92%A9" * 40,
    "..%5c..", ".hidden.yaml", "a%0Ab.yaml", "%7Bx%7D", "run%2F..%2F..", "1e999",
)  # fmt: skip
BODIES = (
    b"", b"{", b"null", b"[]", b'"x"', b'{"a": 1}', b"\xff\xfe\x00", b"[" * 5000,
    b'{"text": "\\ud800", "name": "\\ud800"}', b'{"text": "\\u0000", "name": "a\\u0000b"}',
    b'{"name": "../x.yaml", "copy_of": "../../etc/passwd"}', b'{"name": "z", "run": "../.."}',
    b'{"axis": "x", "distance_mm": NaN}', b'{"axis": "x", "distance_mm": 1e308}',
    b'{"axis": "x", "direction": 1, "feed_mm_min": Infinity}',
    b'{"axis": "x", "direction": 1, "feed_mm_min": 1e308}',
    b'{"params": {"x": 1e400}}', b'{"params": {"x": "NaN mm"}}', b'{"params": {"x": {"a": [1]}}}',
    b'{"protocol": "\\u0000.yaml"}', b'{"token": "\\ud800"}', b'{"keys": ["\\ud800"]}',
    json.dumps({"text": "x" * 2_100_000}).encode(),
)  # fmt: skip
QUERIES = ("", "-1", "1e9", "9" * 40, "nan", "\x00", "x" * 5000, "../../etc/passwd")
HEADERS = (
    {"Idempotency-Key": "x"}, {"Idempotency-Key": "x" * 200}, {"X-Deadline": "nan"},
    {"X-Deadline": "-inf"}, {"X-Deadline": "soon"}, {"X-Control-Lease": "\u00fc"},
    {"Content-Type": "text/plain"}, {"Origin": "http://["}, {"Host": "["}, {"Cookie": "a=b; ;=\x01"},
)  # fmt: skip
REAL = {"device": "gantry", "action": "move_to", "name": "grid.yaml"}
KEEPS_OUT = ("/api/v1/stop", "/api/v1/session", "/api/v1/control/take", "/api/v1/control/release")


@pytest.fixture(scope="module")
def routes(shared):
    paths = shared.client().get("/openapi.json").json()["paths"]
    return [
        (method, path.removeprefix("/api/v1"), operation)
        for path, all_of in paths.items()
        for method, operation in all_of.items()
        if path not in KEEPS_OUT
    ]


def filled(path, operation, name=None):
    for one in operation.get("parameters", []):
        if one["in"] == "path":
            path = path.replace("{" + one["name"] + "}", name or REAL.get(one["name"], "x"))
    return path


def sound(answer):
    """A success, or a refusal in words that a person understands."""
    if answer.status_code < 400:
        return True
    ours = answer.headers["content-type"] == "application/json" and answer.json()["message"]
    return bool(ours) and (answer.status_code < 500 or answer.status_code in (501, 503))


@pytest.mark.slow
def test_no_name_breaks_a_route(page, routes):
    wrong = []
    for method, path, operation in routes:
        for name in NAMES if "{" in path else ():
            if filled(path, operation, name).endswith("/.."):
                continue  # the client itself would make another address of it
            answer = page.command(filled(path, operation, name), {}, method=method)
            wrong += [] if sound(answer) else [(method, path, name[:20], answer.status_code)]

    assert wrong == []


@pytest.mark.slow
def test_no_body_breaks_a_route(page, routes):
    wrong = []
    for method, path, operation in routes:
        for body in BODIES if method in ("post", "put") else ():
            answer = page.command(filled(path, operation), content=body, method=method)
            wrong += [] if sound(answer) else [(method, path, body[:40], answer.status_code)]

    assert wrong == []


@pytest.mark.slow
def test_no_query_breaks_a_route(page, routes):
    wrong = []
    for method, path, operation in routes:
        asked = [p["name"] for p in operation.get("parameters", []) if p["in"] == "query"]
        for name, value in ((n, v) for n in asked for v in QUERIES):
            answer = page.request(method, filled(path, operation), params={name: value})
            wrong += [] if sound(answer) else [(method, path, name, value[:20], answer.status_code)]

    assert wrong == []


def test_no_header_breaks_a_command(page):
    told = [
        page.command("/devices/gantry/actions/move_to", {"params": {"x": 1}}, **{
            name: value.encode() for name, value in headers.items()
        })
        for headers in HEADERS
    ]  # fmt: skip

    assert [answer.status_code for answer in told if not sound(answer)] == []
    assert all(answer.status_code >= 400 for answer in told[:6])


def test_no_address_breaks_the_page(shared, page):
    at_root = [
        page.request(method, f"{shared.url}{path}")
        for method in ("GET", "PATCH", "OPTIONS", "TRACE")
        for path in ("/%00", "/%2e%2e/%2e%2e/x", "/" + "a" * 3000, "/api", "/socket.io/", "/x.js")
    ]

    assert {answer.status_code for answer in at_root} <= {200, 400, 404, 405, 503}


def test_a_text_that_no_process_takes_is_refused_before_one_is_started(page):
    page.reach("gantry", "libs")
    before = page.get("/runs").json()
    asked = {"protocol": "grid.yaml", "checklist": [
        "enclosure closed", "nobody in the beam path", "sample fixed"
    ]}  # fmt: skip
    half = page.command(
        "/runs", content=json.dumps(asked | {"params": {"sample": "\ud800"}}).encode()
    )
    null = page.command("/runs", asked | {"answers": {"x": "\x00"}})
    long = page.command("/runs", asked | {"params": {"sample": "x" * 150_000}})

    assert [(a.status_code, a.json()["code"]) for a in (null, long)] == [(422, "INVALID")] * 2
    assert half.status_code == 422
    assert page.get("/runs").json() == before


def test_a_long_name_in_another_script_is_kept_and_thrown_away_like_any_other(page):
    name = "測" * 55 + ".yaml"
    made = page.post("/protocols", json={"name": "plain.yaml", "text": "labrun: 1\n"})
    saved = page.put(f"/protocols/{name}", json={"text": "labrun: 1\nname: x\n"})
    thrown = page.delete(f"/protocols/{name}")
    back = page.post(f"/trash/{thrown.json()['id']}/restore")
    versions = page.get(f"/protocols/{name}/versions").json()

    assert made.status_code == 201 and saved.status_code == 200
    assert thrown.json()["name"] == name == back.json()["name"]
    assert len(versions) == 1
    assert page.put(f"/protocols/{'測' * 80}.yaml", json={"text": ""}).status_code == 422


@pytest.mark.skipif(os.name == "nt", reason="looks at modes of files")
def test_a_fault_of_ours_is_answered_in_words_and_noted_with_versions(tmp_path, caplog):
    log = FaultLog(tmp_path / "faults.log")
    app = make_app(None)  # a site that is not there: every route that needs it falls over

    async def asked():
        transport = httpx.ASGITransport(app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://here") as client:
            return await client.get("/api/v1/devices")

    answer = asyncio.run(asked())
    try:
        raise RuntimeError("lost")
    except RuntimeError as fault:
        log.note("GET /api/v1/devices", fault)
    text = log.path.read_text()

    assert answer.status_code == 500 and answer.json()["code"] == "FAULT"
    assert "AttributeError" in answer.json()["message"]
    assert "RuntimeError: lost" in text and text.splitlines()[1] == "GET /api/v1/devices"
    assert log.path.stat().st_mode & 0o777 == 0o600
    assert "please report it" in caplog.text


@pytest.mark.parametrize("path", ["/check", "/devices/gantry/actions/home"])
def test_a_body_that_says_no_length_is_bounded_like_any_other(page, path):
    parts = iter([b'{"text": "', *[b"x" * 100_000] * 45, b'"}'])
    answer = page.command(path, content=parts)

    assert (answer.status_code, answer.json()["code"]) == (413, "TOO_LARGE")


def test_a_request_that_breaks_off_is_no_fault_of_ours(shared, page):
    host, port = shared.url.removeprefix("http://").split(":")
    cookie = "; ".join(f"{name}={value}" for name, value in page.cookies.items())
    head = (
        f"POST /api/v1/devices/gantry/actions/home HTTP/1.1\r\nHost: {host}:{port}\r\n"
        f"Cookie: {cookie}\r\nIdempotency-Key: 123456789\r\nContent-Length: 99\r\n\r\n{{"
    )
    with socket.create_connection((host, int(port))) as line:
        line.sendall(head.encode())
    assert page.get("/devices").status_code == 200

    assert not (shared.library / ".labrun" / "web" / "faults.log").exists()
