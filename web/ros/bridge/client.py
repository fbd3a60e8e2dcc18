"""One connection: what a client sends is done or answered in the protocol's own terms."""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from .fragments import Fragments, cut
from .frames import Misformed, as_json, may, read
from .outbox import Outbox
from .rooms import Rooms

MOST_TASKS = 1000
LEVELS = ("none", "error", "warning", "info")
FAULT = "a fault in labrun itself kept this from being done; the log of `labrun ros` says more"
LOG = logging.getLogger(__name__)

Operation = Callable[["Client", dict[str, Any]], None]
Message = dict[str, Any]


class Client:
    """A client, for as long as its socket is open; the goals that it has sent go on after that."""

    def __init__(self, socket: ServerConnection, rooms: Rooms) -> None:
        self.rooms = rooms
        self.goals: dict[str, Any] = {}
        """The id that the client gave -> its goal, or what is to become one."""
        self.streams: dict[str, Any] = {}
        """The topic as the client spells it -> what is sent of it."""
        self.closing: list[Callable[[], None]] = []
        self._socket = socket
        self._outbox = Outbox()
        self._fragments = Fragments()
        self._level = "error"
        self._tasks: set[asyncio.Task[None]] = set()
        self._count = 0

    async def live(self, operations: dict[str, Operation]) -> None:
        """Serve it until it leaves."""
        sending = asyncio.create_task(self._outbox.drain_into(self._socket.send))
        watching = asyncio.create_task(self._hang_up_when_full())
        try:
            async for data in self._socket:
                self._take(data, operations)
                # A client that floods us takes turns with devices and others.
                await asyncio.sleep(0)
        except ConnectionClosed:
            pass
        finally:
            for close in self.closing:
                close()
            for task in (sending, watching, *self._tasks):
                task.cancel()
            await asyncio.gather(sending, watching, *self._tasks, return_exceptions=True)

    def send(self, message: Message, size: int | None = None, *, droppable: bool = False) -> None:
        """Send a message as JSON, in pieces where the client wants small ones."""
        self._count += 1
        for frame in cut(as_json(message), size, f"labrun-{self._count}"):
            self._outbox.put(frame, droppable=droppable and size is None)

    def send_bytes(self, frame: bytes) -> None:
        """Send a binary frame of a topic."""
        self._outbox.put(frame, droppable=True)

    def complain(self, words: str, id: Any = None, level: str = "error") -> None:
        """Say what is wrong with what the client sent."""
        if LEVELS.index(level) <= LEVELS.index(self._level):
            said = {"op": "status", "level": level, "msg": words}
            self.send(said if id is None else {**said, "id": id})

    def set_level(self, message: Message) -> None:
        """Which complaints it wants to hear."""
        level = may(message, "level", str, f"one of {', '.join(LEVELS)}")
        if level not in LEVELS:
            raise Misformed(f"`level` is one of {', '.join(LEVELS)}")
        self._level = level

    def do(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something that takes time, beside what the client sends next; raises Misformed."""
        if len(self._tasks) >= MOST_TASKS:
            work.close()
            raise Misformed(f"{MOST_TASKS} requests of yours wait already")
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _take(self, data: str | bytes, operations: dict[str, Operation]) -> None:
        message: Message = {}
        try:
            message = read(data)
            if message.get("op") == "fragment":
                whole = self._fragments.take(message)
                if whole is None:
                    return
                message = read(whole)
            op = message.get("op")
            if not isinstance(op, str) or op not in operations:
                raise Misformed(
                    f"there is no operation {str(op)[:80]!r} here; there are {', '.join(operations)}"
                )
            operations[op](self, message)
        except Misformed as fault:
            self.complain(str(fault), _id(message))
        except Exception:
            # One frame that we stumble over is no reason to hang up on a client with goals under way.
            LOG.exception("a frame of a client: %.300s", data)
            self.complain(FAULT, _id(message))

    async def _hang_up_when_full(self) -> None:
        await self._outbox.full.wait()
        # A parting word would wait behind all that it has not read.
        self._socket.transport.abort()


def _id(message: Message) -> Any:
    id = message.get("id")
    return id if isinstance(id, (str, int)) else None
