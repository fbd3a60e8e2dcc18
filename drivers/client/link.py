"""One Socket.IO connection that is kept alive: it reconnects by itself until it is closed."""

import asyncio
import contextlib
import logging
import os
import random
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from ...schemas.messages import NAMESPACE
from ...system.start import spare_of_socketio
from ...system.tasks import end, keep
from ..server import tokens

if TYPE_CHECKING:
    import aiohttp
    import socketio

    from ...system.websocket import WebSocket

CONNECT_S = 5
LONGEST_CONNECT_S = 40
"""One attempt, up to the server's greeting: doubled each time that a server is there but slow."""
REACH_S = 5.0
"""How long an address is tried that refuses, or where nothing answers."""
ANSWER_S = 2.0
FIRST_DELAY_S = 0.1
LONGEST_DELAY_S = 1.0
WINDOWS_ERRORS = 1000
"""From here on the numbers are Windows', which come with their words."""
LOG = logging.getLogger("labrun")
# python-engineio prints each loss that is told in words here, by two handlers where there is one already.
logging.getLogger("engineio.client").addFilter(lambda said: "queue is empty" not in str(said.msg))

Answer = dict[str, Any]


class LinkDown(Exception):
    """No answer: the connection broke, or the server was silent for too long."""


class ServerUnreachable(Exception):
    """A device server that cannot be reached, with its address and the reason."""

    def __init__(self, address: str, reason: str) -> None:
        super().__init__(f"the device server at {address} cannot be reached: {reason}")
        self.address = address
        self.reason = reason


class Slow(ServerUnreachable):
    """The server is there, or something is, but has not greeted in time."""


class Denied(ServerUnreachable):
    """The server refuses the connection; an immediate retry would not help."""


class Link:
    """Connect, report when the link is up or down, reconnect.

    `on_up` runs on every new connection before anything else may use it: there the client checks
    which server it is talking to. Each connection gets a fresh Socket.IO client, so that nothing of
    a broken one (callbacks, half a binary message, its own reconnect) carries over into the next.
    """

    def __init__(
        self,
        url: str,
        token: str | None,
        events: dict[str, Callable[[Answer], None]],
        on_up: Callable[[], Awaitable[None]],
        on_down: Callable[[], None],
    ) -> None:
        self.url = url
        self.up = asyncio.Event()
        self.refusal = ""
        self._token = token
        self._events = events
        self._on_up = on_up
        self._on_down = on_down
        self._refused = False
        self._connect_s = CONNECT_S
        self._sio: socketio.AsyncClient | None = None
        self._http: aiohttp.ClientSession | None = None
        self._socket: WebSocket | None = None
        self._broken = asyncio.Event()
        self._waiting: set[asyncio.Future[Answer]] = set()
        self._keeper: asyncio.Task[None] | None = None

    async def open(self, timeout_s: float) -> None:
        """Connect for the first time; raises ServerUnreachable."""
        import aiohttp

        from ...system.websocket import WebSocket

        def opened(*parts: Any, **more: Any) -> WebSocket:
            # python-engineio forgets the socket of a server that fell silent, or never greeted.
            self._socket = WebSocket(*parts, **more)
            return self._socket

        self._http = aiohttp.ClientSession(
            timeout=aiohttp.ClientTimeout(total=None, sock_connect=REACH_S),
            ws_response_class=opened,  # pyright: ignore[reportArgumentType] - it is only called
        )
        first = asyncio.get_running_loop().create_future()
        self._keeper = keep(f"the link to {self.url}", lambda: self._keep(first))
        try:
            async with asyncio.timeout(timeout_s):
                await asyncio.wait({first}, timeout=REACH_S)
                while not first.done() and not self._refused:
                    await asyncio.wait({first}, timeout=FIRST_DELAY_S)
                if not first.done():
                    raise TimeoutError
                await first
        except TimeoutError:
            await self.close()
            silence = f"no response within {timeout_s:g} s"
            raise ServerUnreachable(self.url, self.refusal if self._refused else silence) from None
        except BaseException:  # a cancel as well
            await self.close()
            raise

    async def close(self) -> None:
        """Disconnect, and leave no task running."""
        try:
            await end(self._keeper)
            self._keeper = None
        finally:
            if self._http is not None:
                await self._http.close()
                self._http = None

    async def _keep(self, first: asyncio.Future[None]) -> None:
        delay = FIRST_DELAY_S
        while True:
            try:
                await self._connect()
                await self._on_up()
                self._connect_s = CONNECT_S
                self.up.set()
                if not first.done():
                    first.set_result(None)
                delay = FIRST_DELAY_S
                await self._broken.wait()
            except Exception as fault:  # whatever went wrong, the next attempt may work
                if not isinstance(fault, (ServerUnreachable, LinkDown)):
                    LOG.exception("connecting to %s failed", self.url)
                self.refusal = getattr(fault, "reason", str(fault))
                # Somebody who is too slow to greet, or whose greeting broke off, has refused nothing.
                self._refused = not isinstance(fault, (Slow, LinkDown))
                if isinstance(fault, Denied) and not first.done():
                    first.set_exception(fault)
            finally:
                await self._drop()
            await asyncio.sleep(delay * random.uniform(0.8, 1.2))
            delay = min(2 * delay, LONGEST_DELAY_S)

    async def _connect(self) -> None:
        spare_of_socketio()
        import socketio
        from socketio.exceptions import ConnectionError as Unconnected

        from ..server.packet import Packet

        self._broken.clear()
        sio = socketio.AsyncClient(
            serializer=Packet,  # pyright: ignore[reportArgumentType] - a class as well as a name
            reconnection=False,
            handle_sigint=False,
            http_session=self._http,
            websocket_extra_options={"max_msg_size": 0},
        )
        words: list[str] = []
        sio.on("connect_error", lambda data=None: words.append(_words(data)), namespace=NAMESPACE)
        sio.on("disconnect", lambda reason=None: self._break(sio), namespace=NAMESPACE)
        for event, receive in self._events.items():
            sio.on(event, receive, namespace=NAMESPACE)
        self._sio = sio
        token = self._token or tokens.found(self.url)  # a server that restarts makes a new one
        try:
            async with asyncio.timeout(self._connect_s):
                await sio.connect(
                    self.url,
                    auth={} if token is None else {"token": token},
                    transports=["websocket"],
                    namespaces=[NAMESPACE],
                    wait_timeout=self._connect_s + 1,
                )
        except TimeoutError:
            reason = f"no response within {self._connect_s} s"
            self._connect_s = min(2 * self._connect_s, LONGEST_CONNECT_S)
            raise Slow(self.url, reason) from None
        except (Unconnected, OSError, ValueError) as fault:
            # python-socketio reports a connection that did not come about as a server's no, too.
            broken = fault.__cause__
            if words and broken is None:
                raise Denied(self.url, words[-1]) from fault
            raise ServerUnreachable(self.url, _why(broken or fault)) from fault

    def _break(self, sio: "socketio.AsyncClient") -> None:
        if sio is not self._sio:
            return
        self._broken.set()
        for future in self._waiting:
            if not future.done():
                future.set_exception(LinkDown(f"the connection to {self.url} broke"))

    async def _drop(self) -> None:
        """Forget a connection, whether it broke or is no longer wanted."""
        was_up = self.up.is_set()
        self.up.clear()
        sio, self._sio = self._sio, None
        socket, self._socket = self._socket, None
        for future in self._waiting:
            if not future.done():
                future.set_exception(LinkDown(f"the connection to {self.url} is closed"))
        if was_up:
            self._on_down()
        try:
            if sio is not None:
                with contextlib.suppress(TimeoutError):  # what is abandoned needs no orderly end
                    async with asyncio.timeout(ANSWER_S):
                        await sio.disconnect()
        finally:
            if socket is not None:
                socket.drop()
            if sio is not None:
                await end(sio.eio.read_loop_task, sio.eio.write_loop_task)

    async def send(self, event: str, payload: Answer, answered: Callable[[Answer], None]) -> bool:
        """Send without waiting; False if there is no connection.

        Does not yield to the event loop: the message is queued when this returns.
        """
        sio = self._sio
        if sio is None or NAMESPACE not in sio.namespaces:
            return False
        await sio.emit(event, payload, namespace=NAMESPACE, callback=answered)
        return True

    async def call(
        self, event: str, payload: Answer, timeout_s: float = ANSWER_S, again_s: float | None = None
    ) -> Answer:
        """Send and wait for the answer; raises LinkDown if none comes.

        `again_s`: how often it is sent once more meanwhile, where that does no harm: a network may have
        lost it, or its answer, and let the connection stand.
        """
        future: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()

        def answered(answer: Answer) -> None:
            if not future.done():
                future.set_result(answer)

        if not await self.send(event, payload, answered):
            raise LinkDown(f"there is no connection to {self.url}")
        self._waiting.add(future)
        try:
            async with asyncio.timeout(timeout_s):
                while not (await asyncio.wait({future}, timeout=again_s))[0]:
                    await self.send(event, payload, answered)
                return future.result()
        except TimeoutError:
            raise LinkDown(f"{self.url} did not answer `{event}` within {timeout_s:g} s") from None
        finally:
            self._waiting.discard(future)
            if future.done() and not future.cancelled():
                future.exception()  # whoever was cancelled meanwhile does not ask for it


def accepted(answer: Answer, url: str) -> Answer:
    """The answer without its `ok`; ServerUnreachable if the server could not give one."""
    if not answer.get("ok"):
        raise ServerUnreachable(url, str(answer.get("message", "no reason given")))
    return {name: value for name, value in answer.items() if name != "ok"}


def _why(fault: BaseException) -> str:
    """What the system or the server said, where the libraries have hidden it behind their own words."""
    import aiohttp

    told = fault.__context__ or fault
    match told:
        case aiohttp.ClientConnectorError():
            errno = told.os_error.errno or 0
            words = os.strerror(errno) if 0 < errno < WINDOWS_ERRORS else told.os_error.strerror
            return words or str(told)
        case aiohttp.WSServerHandshakeError():
            return f"it answers, but not as a device server does: HTTP {told.status}"
        case _:
            return str(told)


def _words(data: Any) -> str:
    return str(data.get("message", data)) if isinstance(data, dict) else str(data)
