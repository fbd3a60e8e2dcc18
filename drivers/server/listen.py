"""Serve an ASGI app on our own socket, in the running event loop, without signal handlers."""

import asyncio
import contextlib
import socket
import ssl
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import urlsplit

import uvicorn
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from ...system import WINDOWS
from ...system.tasks import spawn
from .server import MAX_MESSAGE_BYTES

START_S = 10.0
FIRST_BYTES = 16 * 1024
"""The longest message of a client that has not been let in."""
LET_IN = "40"
"""So begins what Socket.IO sends to a client that it has let into a namespace."""


class _Guarded(WebSocketsSansIOProtocol):
    """Keeps no long message of anybody before the gate and the token have let them in."""

    def __init__(self, *parts: Any, **more: Any) -> None:
        super().__init__(*parts, **more)
        self._take(FIRST_BYTES)

    async def send(self, message: Any) -> None:
        if (message.get("text") or "").startswith(LET_IN):
            self._take(self.config.ws_max_size)
        await super().send(message)

    def _take(self, most_bytes: int) -> None:
        newer = hasattr(self.conn, "max_message_size")  # since websockets 16
        setattr(self.conn, "max_message_size" if newer else "max_size", most_bytes)


class _Server(uvicorn.Server):
    """Ends when it is told to: an idle server of uvicorn's looks ten times a second whether it should."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.ending = asyncio.Event()

    async def main_loop(self) -> None:
        await self.on_tick(0)
        await self.ending.wait()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signals to the process, which must make its devices safe first."""
        yield


def bind(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 chooses a free one. Raises OSError if it is taken."""
    family, kind, protocol, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listener = socket.socket(family, kind, protocol)
    try:
        # A server that was killed leaves its port in TIME_WAIT; on Windows the same option would
        # let a second server take a port that is in use.
        if not WINDOWS:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(128)
        listener.setblocking(False)
    except OSError:
        listener.close()
        raise
    return listener


def free(host: str, port: int) -> bool:
    """Whether a port is free."""
    try:
        with contextlib.closing(bind(host, port)):
            return True
    except OSError:  # socket.gaierror is one, too
        return False


def for_other_machines(host: str, url: str) -> str:
    """`; other machines reach it at ...`, for a server that listens on all addresses of this one."""
    if host not in ("", "0.0.0.0", "::"):
        return ""
    at = urlsplit(url)
    family, away = (
        (socket.AF_INET6, "2001:db8::1") if host == "::" else (socket.AF_INET, "192.0.2.1")
    )
    names = [socket.gethostname()]
    with socket.socket(family, socket.SOCK_DGRAM) as asked, contextlib.suppress(OSError):
        asked.connect((away, 9))  # sends nothing: the kernel chooses the address to send from
        own = asked.getsockname()[0]
        names.insert(0, f"[{own}]" if ":" in own else own)
    urls = [f"{at.scheme}://{name}:{at.port}" for name in names]
    return f"; other machines reach it at {' or '.join(urls)}"


@asynccontextmanager
async def listening(
    app: Any, listener: socket.socket, tls: tuple[str, str] | None = None
) -> AsyncIterator[None]:
    """Serve for as long as the block lasts; `tls` is a certificate file and its key file."""
    config = uvicorn.Config(
        app,
        ws=_Guarded,
        ws_max_size=MAX_MESSAGE_BYTES,
        ws_ping_interval=None,  # Socket.IO sends its own pings
        ws_per_message_deflate=False,  # compression costs more than it saves on loopback and LAN
        lifespan="off",
        date_header=False,
        log_level="warning",
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=1,
        ssl_certfile=tls[0] if tls else None,
        ssl_keyfile=tls[1] if tls else None,
        ssl_version=ssl.PROTOCOL_TLS_SERVER,
    )
    server = _Server(config)
    serving = spawn("listener", server.serve(sockets=[listener]))
    try:
        async with asyncio.timeout(START_S):
            while not server.started and not serving.done():  # noqa: ASYNC110 - uvicorn has no event for it
                await asyncio.sleep(0.005)
        if serving.done():
            serving.result()
        yield
    finally:
        server.should_exit = True
        server.ending.set()
        await serving
        listener.close()
