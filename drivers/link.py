"""One Socket.IO connection that is kept alive: it comes back by itself until it is closed."""

import asyncio
import contextlib
import random
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from ..schemas.messages import NAMESPACE

if TYPE_CHECKING:
    import aiohttp
    import socketio

CONNECT_S = 5
ANSWER_S = 2.0
FIRST_DELAY_S = 0.1
LONGEST_DELAY_S = 1.0
SETTLE_S = 0.5

Answer = dict[str, Any]


class LinkDown(Exception):
    """No answer: the connection broke, or the server was silent for too long."""


class ServerUnreachable(Exception):
    """A device server that cannot be reached; says where and why."""

    def __init__(self, address: str, reason: str) -> None:
        super().__init__(f"the device server at {address} cannot be reached: {reason}")
        self.address = address
        self.reason = reason


class Denied(ServerUnreachable):
    """It is there and does not let us in; asking again at once would not help."""


class Link:
    """Connect, tell when it is up or down, connect again.

    `on_up` runs on every new connection before anybody else may use it: there the client finds out
    whom it is talking to. A fresh Socket.IO client serves each connection, so that nothing of a
    broken one (callbacks, half a binary message, a reconnect of its own) reaches into the next.
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
        self._auth = {} if token is None else {"token": token}
        self._events = events
        self._on_up = on_up
        self._on_down = on_down
        self._sio: socketio.AsyncClient | None = None
        self._http: aiohttp.ClientSession | None = None
        self._broken = asyncio.Event()
        self._waiting: set[asyncio.Future[Answer]] = set()
        self._keeper: asyncio.Task[None] | None = None
        self._settled = asyncio.Event()
        self._settled.set()

    async def open(self, timeout_s: float) -> None:
        """Connect for the first time; raises ServerUnreachable."""
        import aiohttp

        self._http = aiohttp.ClientSession()
        first = asyncio.get_running_loop().create_future()
        self._keeper = asyncio.create_task(self._keep(first))
        try:
            async with asyncio.timeout(timeout_s):
                await first
        except TimeoutError:
            await self.close()
            raise ServerUnreachable(self.url, self.refusal or "no answer") from None
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        """Disconnect, and leave no task."""
        if self._keeper is not None:
            # Cancelled in the middle of its handshake, aiohttp would leave the connection behind.
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(SETTLE_S):
                    await self._settled.wait()
            self._keeper.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._keeper
            self._keeper = None
        if self._http is not None:
            await self._http.close()
            self._http = None

    async def _keep(self, first: asyncio.Future[None]) -> None:
        delay = FIRST_DELAY_S
        while True:
            try:
                await self._connect()
                await self._on_up()
                self.up.set()
                if not first.done():
                    first.set_result(None)
                delay = FIRST_DELAY_S
                await self._broken.wait()
            except Exception as fault:  # whatever went wrong, the next connection is another chance
                self.refusal = getattr(fault, "reason", str(fault))
                if isinstance(fault, Denied) and not first.done():
                    first.set_exception(fault)
            finally:
                await self._drop()
            await asyncio.sleep(delay * random.uniform(0.8, 1.2))
            delay = min(2 * delay, LONGEST_DELAY_S)

    async def _connect(self) -> None:
        import socketio
        from socketio.exceptions import ConnectionError as Unconnected

        self._broken.clear()
        sio = socketio.AsyncClient(
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
        self._settled.clear()
        try:
            async with asyncio.timeout(CONNECT_S):
                await sio.connect(
                    self.url,
                    auth=self._auth,
                    transports=["websocket"],
                    namespaces=[NAMESPACE],
                    wait_timeout=CONNECT_S,
                )
        except TimeoutError:
            raise ServerUnreachable(self.url, f"no answer within {CONNECT_S:g} s") from None
        except (Unconnected, OSError, ValueError) as fault:
            if words:
                raise Denied(self.url, words[-1]) from fault
            raise ServerUnreachable(self.url, str(fault)) from fault
        finally:
            self._settled.set()

    def _break(self, sio: "socketio.AsyncClient") -> None:
        if sio is not self._sio:
            return
        self._broken.set()
        for future in self._waiting:
            if not future.done():
                future.set_exception(LinkDown(f"the connection to {self.url} broke"))

    async def _drop(self) -> None:
        """Forget a connection, whether it broke or is not wanted any more."""
        was_up = self.up.is_set()
        self.up.clear()
        sio, self._sio = self._sio, None
        for future in self._waiting:
            if not future.done():
                future.set_exception(LinkDown(f"the connection to {self.url} is closed"))
        if was_up:
            self._on_down()
        if sio is not None:
            await _disconnect(sio)

    async def send(self, event: str, payload: Answer, answered: Callable[[Answer], None]) -> bool:
        """Send without waiting; False where there is no connection to send on.

        Takes no turn of the event loop: the message is queued when this returns.
        """
        sio = self._sio
        if sio is None or NAMESPACE not in sio.namespaces:
            return False
        await sio.emit(event, payload, namespace=NAMESPACE, callback=answered)
        return True

    async def call(self, event: str, payload: Answer, timeout_s: float = ANSWER_S) -> Answer:
        """Send and wait for the answer; raises LinkDown where none comes."""
        future: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()

        def answered(answer: Answer) -> None:
            if not future.done():
                future.set_result(answer)

        if not await self.send(event, payload, answered):
            raise LinkDown(f"there is no connection to {self.url}")
        self._waiting.add(future)
        try:
            async with asyncio.timeout(timeout_s):
                return await future
        except TimeoutError:
            raise LinkDown(f"{self.url} did not answer `{event}` within {timeout_s:g} s") from None
        finally:
            self._waiting.discard(future)


def accepted(answer: Answer, url: str) -> Answer:
    """The answer without its `ok`; ServerUnreachable where the server could not give one."""
    if not answer.get("ok"):
        raise ServerUnreachable(url, str(answer.get("message", "it gave no reason")))
    return {name: value for name, value in answer.items() if name != "ok"}


def _words(data: Any) -> str:
    return str(data.get("message", data)) if isinstance(data, dict) else str(data)


async def _disconnect(sio: "socketio.AsyncClient") -> None:
    """End a Socket.IO client, its socket, and the two tasks that it keeps behind them."""
    loops = [sio.eio.read_loop_task, sio.eio.write_loop_task]
    # A connection that is given up owes nobody an orderly end.
    with contextlib.suppress(Exception):
        async with asyncio.timeout(ANSWER_S):
            await sio.disconnect()
    # Where the server fell silent, python-engineio forgets the socket without closing it.
    with contextlib.suppress(Exception):
        async with asyncio.timeout(SETTLE_S):
            await sio.eio.ws.close()
    for task in loops:
        if task is not None and not task.done():
            task.cancel()
    await asyncio.gather(*(task for task in loops if task is not None), return_exceptions=True)
