"""The connection to the analyser server: one request at a time, and lost answers are reported."""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ...system.tasks import end, keep

if TYPE_CHECKING:
    import aiohttp
    import socketio

AGAIN_S = 1.0
FRESH_S = 3.0
"""The server sends its status twice a second, unless it is blocked (by find_buttons: 12 s)."""
LOG = logging.getLogger("labrun")
STATUSES = ("IDLE", "RUNNING")


class NotSent(Exception):
    """There is no connection, and nothing was sent."""


class AnswerLost(Exception):
    """It was sent, and the connection broke (or time ran out) before an answer came."""


class AnalyserLink:
    """Keeps a Socket.IO connection to the server; it reconnects by itself until it is closed."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.status: str | None = None
        self.export_path: str | None = None
        self.trouble = "not connected yet"
        self.connections = 0
        self.up = asyncio.Event()
        self._told = 0  # statuses of this connection
        self._told_at = float("-inf")
        self._asked_at = float("-inf")
        self._odd_status: Any = None
        self._sio: socketio.AsyncClient | None = None
        self._http: aiohttp.ClientSession | None = None
        self._broken = asyncio.Event()
        self._waiting: set[asyncio.Future[tuple[Any, ...]]] = set()
        self._keeper: asyncio.Task[None] | None = None

    async def open(self, timeout_s: float) -> None:
        """Connect, and check that it is the analyser server; raises OSError with the reason."""
        import aiohttp

        self._http = aiohttp.ClientSession()
        self._keeper = keep(f"the link to {self.url}", self._keep)
        try:
            async with asyncio.timeout(timeout_s):
                await self._heard()
        except TimeoutError:
            raise OSError(self._who_is_there(timeout_s)) from None

    async def _heard(self, times: int = 1) -> None:
        """Wait for a connection that has told its status so many times."""
        while self._broken.is_set() or not self.up.is_set() or self._told < times:
            if self._odd_status is not None:
                raise OSError(self._who_is_there(0))
            await asyncio.sleep(0.05)

    def _who_is_there(self, timeout_s: float) -> str:
        if self._odd_status is not None:
            return (
                f"{self.url} is not an analyser server: its status is {str(self._odd_status)[:60]}, where "
                f"IDLE or RUNNING is expected; port 3000 would be OpenBuilds CONTROL, 1234 the analyser"
            )
        if self.up.is_set():
            return (
                f"{self.url} speaks Socket.IO but sent no status IDLE or RUNNING within "
                f"{timeout_s:g} s: it is another server, or the analyser's hangs; restart that one"
            )
        return (
            f"the analyser server at {self.url} cannot be reached: {self.trouble}; is it running, "
            f"and is this its address?"
        )

    @property
    def idle(self) -> bool | None:
        """Whether the server has just reported that it is idle; None if it is silent.

        What it reported before the last request does not count.
        """
        fresh = asyncio.get_running_loop().time() - self._told_at < FRESH_S
        heard = fresh and self._told_at > self._asked_at and self.up.is_set()
        return self.status == "IDLE" if heard else None

    async def close(self) -> None:
        """Disconnect, and leave no task running."""
        await end(self._keeper)
        self._keeper = None
        if self._http is not None:
            await self._http.close()
            self._http = None

    async def renew(self, timeout_s: float) -> None:
        """Break the connection and wait for one that holds; raises OSError.

        One that breaks again before its second status is followed by the next.
        """
        self._odd_status = None
        self._broken.set()
        try:
            async with asyncio.timeout(timeout_s):
                await self._heard(2)
        except TimeoutError:
            raise OSError(self._who_is_there(timeout_s)) from None

    async def ask(
        self, event: str, data: Any, timeout_s: float,
        late: Callable[[tuple[Any, ...]], None] = lambda answer: None,
    ) -> tuple[Any, ...]:  # fmt: skip
        """The server's answer; raises NotSent or AnswerLost. An answer after that goes to `late`."""
        from socketio.exceptions import SocketIOError

        if not self.up.is_set() or self._sio is None:
            raise NotSent(f"there is no connection to {self.url} ({self.trouble})")
        answer: asyncio.Future[tuple[Any, ...]] = asyncio.get_running_loop().create_future()

        def answered(*parts: Any) -> None:
            if answer.done():
                late(parts)
            else:
                answer.set_result(parts)

        self._asked_at = asyncio.get_running_loop().time()
        try:
            await self._sio.emit(event, data, callback=answered)
        except SocketIOError as fault:
            raise NotSent(f"there is no connection to {self.url} ({fault})") from fault
        self._waiting.add(answer)
        try:
            async with asyncio.timeout(timeout_s):
                return await answer
        except TimeoutError:
            raise AnswerLost(f"no answer came within {timeout_s:g} s") from None
        finally:
            self._waiting.discard(answer)

    async def _keep(self) -> None:
        from socketio.exceptions import ConnectionError as Unconnected

        while True:
            try:
                await self._connect()
                await self._broken.wait()
            except Exception as fault:  # whatever it was, the next connection is another chance
                if not isinstance(fault, (Unconnected, OSError)):
                    LOG.exception("connecting to %s failed", self.url)
                self.trouble = _plainly(fault)
            finally:
                await self._drop()
            await asyncio.sleep(AGAIN_S)

    async def _connect(self) -> None:
        import socketio

        # A fresh client each time: nothing of a broken connection carries over into the next.
        sio = socketio.AsyncClient(
            reconnection=False, handle_sigint=False, http_session=self._http, request_timeout=20
        )
        self._sio = sio
        self.status, self._told, self._odd_status = None, 0, None
        self._broken.clear()

        def of_this(note: Callable[..., None]) -> Callable[..., None]:
            """What an earlier connection still delivers is not of this one."""
            return lambda *told: note(*told) if self._sio is sio else None

        sio.on("status", of_this(self._note_status))
        sio.on("export_path", of_this(self._note_path))
        sio.on("disconnect", of_this(self._note_break))
        await sio.connect(self.url, wait_timeout=20)
        self.connections += 1
        self.up.set()

    async def _drop(self) -> None:
        self.up.clear()
        if self._sio is not None:
            sio, self._sio = self._sio, None
            with contextlib.suppress(OSError):  # a broken connection may not close cleanly
                await sio.disconnect()

    def _note_status(self, status: Any = None, *_: Any) -> None:
        if status in STATUSES:
            self.status = status
            self._told += 1
            self._told_at = asyncio.get_running_loop().time()
        else:
            self._odd_status = status

    def _note_path(self, path: Any = None, *_: Any) -> None:
        self.export_path = str(path)

    def _note_break(self, *_: Any) -> None:
        self.trouble = "the connection broke"
        self.up.clear()
        for answer in self._waiting:
            if not answer.done():
                answer.set_exception(AnswerLost("the connection broke before an answer came"))
        self._broken.set()


def _plainly(fault: Exception) -> str:
    """A connection failure without the wrapping of three libraries."""
    words = str(fault) or type(fault).__name__
    if "Unexpected status code" in words:
        return f"what answers there is not a Socket.IO server ({words})"
    if words == "One or more namespaces failed to connect":
        return "it refuses the connection"
    return words
