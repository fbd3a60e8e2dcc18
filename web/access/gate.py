"""The gate before every request: hosts, origins, sizes, sign-in; and the headers of every answer.

A page of another site can make a browser send requests to 127.0.0.1, even under a name that it
made resolve there (DNS rebinding). So the Host must be one of ours, the Origin must equal the
Host, and a request that changes anything needs a cookie that other sites cannot send. A browser
that comes with the token in its address gets that cookie, and goes on to the address without it.
"""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import parse_qsl, quote, urlencode

from fastapi.responses import RedirectResponse

from ...drivers.server.gate import is_ours, split
from ..local.refusal import Refusal, as_response
from .sessions import Sessions, bearer

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

LARGEST_BODY = 4_000_000
STOP_PATH = "/api/v1/stop"
OPEN_PATHS = ("/api/v1/session", "/api/v1/openapi.json", STOP_PATH)
POLICY = (
    "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; worker-src 'self' blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
HEADERS = (
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"same-origin"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"permissions-policy", b"camera=(), microphone=(), geolocation=()"),
)


class Gate:
    """An ASGI application around another; `host` is what the server listens on."""

    def __init__(self, app: Any, sessions: Sessions, host: str) -> None:
        self._app = app
        self._sessions = sessions
        self._listens_on = host

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass allowed requests on; refuse all others."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        try:
            await self._check(scope, headers)
        except Refusal as refusal:
            await _refuse(scope, receive, send, refusal)
            return
        if scope["type"] == "websocket":
            await self._app(scope, receive, send)
            return
        if (given := _in_address(scope)) is not None:
            response = RedirectResponse(_without_token(scope), 303, {"cache-control": "no-store"})
            if await self._sessions.enters(given):
                self._sessions.set_cookie(response)
            await response(scope, receive, _with_headers(send))
            return
        bounded = _Bounded(scope, receive, _with_headers(send))
        await self._app(scope, bounded.receive, bounded.send)

    async def _check(self, scope: Scope, headers: dict[str, str]) -> None:
        host = headers.get("host", "")
        if not is_ours(self._listens_on, host):
            raise Refusal(421, "WRONG_HOST", f"this server is not {host[:100]!r}")
        origin = headers.get("origin")
        if origin is not None and split(origin).netloc.lower() != host.lower():
            raise Refusal(403, "WRONG_ORIGIN", "pages of other sites may not use this server")
        if headers.get("sec-fetch-site") == "cross-site" and scope.get("path") != "/":
            raise Refusal(403, "WRONG_ORIGIN", "pages of other sites may not use this server")
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > LARGEST_BODY:
            raise _too_large()
        path = str(scope.get("path", ""))
        is_socket = scope["type"] == "websocket"
        needs = path.startswith("/api/") and path not in OPEN_PATHS
        given = bearer(headers)
        if given is not None and self._sessions.token_needed and path != STOP_PATH:
            await self._sessions.admit(given)
        if (needs or is_socket) and not self._sessions.knows_raw(headers):
            hint = (
                "send `Authorization: Bearer TOKEN`, or open the address with the token in it, which "
                "`labrun web` prints to its own user when it is started once more"
                if self._sessions.token_needed
                else "GET /api/v1/session, then try again"
            )
            raise Refusal(401, "SIGN_IN", "sign in first", hint)


class _Bounded:
    """Counts a body without a stated length; beyond the limit it ends like a disconnect and is refused."""

    def __init__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self._scope = scope
        self._receive = receive
        self._send = send
        self._got = 0

    async def receive(self) -> MutableMapping[str, Any]:
        """The next part of the body."""
        message = await self._receive()
        if message["type"] == "http.request":
            self._got += len(message.get("body", b""))
            if self._got > LARGEST_BODY:
                return {"type": "http.disconnect"}
        return message

    async def send(self, message: MutableMapping[str, Any]) -> None:
        """The answer; replaced by a refusal if the body was too large."""
        if self._got <= LARGEST_BODY:
            await self._send(message)
        elif message["type"] == "http.response.start":
            await as_response(_too_large())(self._scope, self._receive, self._send)


def _query(scope: Scope) -> list[tuple[str, str]]:
    return parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)


def _in_address(scope: Scope) -> str | None:
    """The token in the address of a page, if there is one."""
    if scope["method"] != "GET" or str(scope["path"]).startswith("/api/"):
        return None
    return dict(_query(scope)).get("token")


def _without_token(scope: Scope) -> str:
    # One stroke: a browser takes `//name` for another site.
    path = "/" + quote(str(scope["path"]).lstrip("/"))
    rest = urlencode([(name, value) for name, value in _query(scope) if name != "token"])
    return f"{path}?{rest}" if rest else path


def _too_large() -> Refusal:
    return Refusal(413, "TOO_LARGE", f"a request may have at most {LARGEST_BODY:,} bytes")


def _with_headers(send: Send) -> Send:
    async def answering(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            given = list(message.get("headers", []))
            known = {name.lower() for name, _ in given}
            given += [(name, value) for name, value in HEADERS if name not in known]
            message["headers"] = given
        await send(message)

    return answering


async def _refuse(scope: Scope, receive: Receive, send: Send, refusal: Refusal) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": refusal.fault.code})
        return
    await as_response(refusal)(scope, receive, _with_headers(send))
