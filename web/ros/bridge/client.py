"""One connection: each operation of a client is carried out or refused, as the protocol defines."""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from ....system.tasks import end, spawn
from .fragments import Fragments, cut
from .frames import Misformed, as_json, may, read
from .outbox import Outbox
from .rooms import Rooms

MOST_TASKS = 1000
LEVELS = ("none", "error", "warning", "info")
FAULT = "an internal error in labrun prevented this; see the log of `labrun ros`"
LOG = logging.getLogger(__name__)

Operation = Callable[["Client", dict[str, Any]], None]
Message = dict[str, Any]


class Client:
    """A client, while its socket is open; its goals continue after that."""

    def __init__(self, socket: ServerConnection, rooms: Rooms) -> None:
        self.rooms = rooms
        self.goals: dict[str, Any] = {}
        """The client's id -> its goal, or the goal being started."""
        self.streams: dict[str, Any] = {}
        """The topic as the client spells it -> its stream."""
        self.closing: list[Callable[[], None]] = []
        self._socket = socket
        self._outbox = Outbox()
        self._fragments = Fragments()
        self._level = "error"
        self._tasks: set[asyncio.Task[None]] = set()
        self._count = 0

    async def serve_until_gone(self, operations: dict[str, Operation]) -> None:
        """Serve it until it disconnects."""
        sending = spawn(
            "sending to a client",
            self._outbox.drain_into(self._socket.send),
            expected=(ConnectionClosed,),
        )
        watching = spawn("watching a client's outbox", self._hang_up_when_full())
        try:
            async for data in self._socket:
                self._take(data, operations)
                # A client that floods us must not starve devices and other clients.
                await asyncio.sleep(0)
        except ConnectionClosed:
            pass
        finally:
            for close in self.closing:
                close()
            await end(sending, watching, *self._tasks)

    def send(self, message: Message, size: int | None = None, *, droppable: bool = False) -> None:
        """Send a message as JSON, in fragments if the client wants them."""
        self._count += 1
        for frame in cut(as_json(message), size, f"labrun-{self._count}"):
            self._outbox.put(frame, droppable=droppable and size is None)

    def send_bytes(self, frame: bytes) -> None:
        """Send a binary frame of a topic."""
        self._outbox.put(frame, droppable=True)

    def complain(self, words: str, id: Any = None, level: str = "error") -> None:
        """Report what is wrong with a client's message."""
        if LEVELS.index(level) <= LEVELS.index(self._level):
            said = {"op": "status", "level": level, "msg": words}
            self.send(said if id is None else {**said, "id": id})

    def set_level(self, message: Message) -> None:
        """Set the level of status messages that the client wants."""
        level = may(message, "level", str, f"one of {', '.join(LEVELS)}")
        if level not in LEVELS:
            raise Misformed(f"`level` must be one of {', '.join(LEVELS)}")
        self._level = level

    def do(self, name: str, work: Coroutine[Any, Any, None]) -> None:
        """Start a long operation concurrently with the client's next messages; raises Misformed."""
        if len(self._tasks) >= MOST_TASKS:
            work.close()
            raise Misformed(f"you already have {MOST_TASKS} requests waiting")
        spawn(name, work, among=self._tasks)

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
                    f"unknown operation {str(op)[:80]!r}; known are {', '.join(operations)}"
                )
            operations[op](self, message)
        except Misformed as fault:
            self.complain(str(fault), _id(message))
        except Exception:  # one frame is no reason to disconnect a client with goals under way
            LOG.exception("a frame of a client: %.300s", data)
            self.complain(FAULT, _id(message))

    async def _hang_up_when_full(self) -> None:
        await self._outbox.full.wait()
        # A closing message would wait behind everything that it has not read.
        self._socket.transport.abort()


def _id(message: Message) -> Any:
    id = message.get("id")
    return id if isinstance(id, (str, int)) else None
