"""Who may connect: pages of allowed origins, and with the token if others can reach us.

A page of any site can make a browser open a WebSocket to this machine, so the Origin must be one of
ours; and such a site may make its own name resolve to 127.0.0.1 (DNS rebinding), so the Host must
be ours too. Programs send no Origin.
"""

from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from ....drivers.server.gate import Brake, is_loopback, is_ours, split
from ....drivers.server.same_user import is_own

WRONG = "a token is required: ws://HOST:PORT/?token=..."


@dataclass(frozen=True, slots=True)
class Gate:
    """`host` is the listening address; `origins` are allowed besides pages of this machine.

    `made`: nobody chose the token, so that programs of our own user need not show it.
    """

    host: str
    brake: Brake
    origins: frozenset[str] = frozenset()
    made: bool = False

    async def check(self, connection: ServerConnection, request: Request) -> Response | None:
        """None if the client may connect, else the refusal."""
        refusal = self.refusal(request)
        own = self.made and is_own(connection.remote_address[:2], connection.local_address[:2])
        if refusal is None and not own and not await self.brake.look(_token(request)):
            refusal = HTTPStatus.UNAUTHORIZED, WRONG
        if refusal is None:
            return None
        status, words = refusal
        return connection.respond(status, f"labrun ros: {words}\n")

    def refusal(self, request: Request) -> tuple[HTTPStatus, str] | None:
        """The reason to refuse a client whatever its token, if any."""
        if len(request.headers.get_all("Host")) != 1 or not is_ours(
            self.host, request.headers["Host"]
        ):
            return HTTPStatus.MISDIRECTED_REQUEST, "this endpoint has another name"
        for origin in request.headers.get_all("Origin"):
            if origin not in self.origins and not _is_local_page(origin):
                return HTTPStatus.FORBIDDEN, (
                    f"pages of {origin[:100]} may not connect; `labrun ros --origin {origin[:100]}` allows it"
                )
        return None


def _token(request: Request) -> str:
    words = request.headers.get("Authorization", "")
    if words.startswith("Bearer "):
        return words.removeprefix("Bearer ")
    return parse_qs(urlsplit(request.path).query).get("token", [""])[0]


def _is_local_page(origin: str) -> bool:
    parts = split(origin)
    return parts.scheme in ("http", "https") and is_loopback(parts.hostname or "")
