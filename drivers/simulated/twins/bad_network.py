"""Injected network faults: a proxy that disturbs traffic between an engine and a device server.

It speaks enough Engine.IO and Socket.IO to know where one packet ends, so that what it loses, holds
back or delivers twice is always a whole event with all of its bytes. The n-th packet of the c-th
connection meets the same fate under the same seed, whatever the clock says.
"""

import asyncio
import contextlib
import random
import re
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from ....system.tasks import end, first_of, spawn

if TYPE_CHECKING:
    from aiohttp import web

    from ....system.websocket import WebSocket

HOLD_S = 0.3
"""The longest time that a packet is held back so that later ones overtake it."""

CONNECT_S = 5.0
END_S = 0.2
TICK_S = 0.001

Frame = str | bytes


@dataclass(frozen=True, slots=True)
class WireFaults:
    """Chances per packet (events and acks; never pings or the connect handshake), drawn from `seed`."""

    seed: int = 1
    drop_request: float = 0.0
    """An event to the server is lost."""
    drop_reply: float = 0.0
    """An ack or event from the server is lost."""
    duplicate: float = 0.0
    """Delivered twice, either way; the second time a moment later."""
    reorder: float = 0.0
    """Held back for a moment, so that later ones overtake it."""
    hang: float = 0.0
    """The whole connection freezes for `hang_s`, pings included."""
    hang_s: float = 3.0
    cut: float = 0.0
    """The connection is broken at once, and what was on its way is lost."""


KINDS = ("drop_request", "drop_reply", "duplicate", "reorder", "hang", "cut")
TOLD = ("event", "ack")


@dataclass(frozen=True, slots=True)
class Packet:
    """One message of Socket.IO: its text and the bytes that belong to it."""

    frames: tuple[Frame, ...]

    @property
    def kind(self) -> str:
        """`event`, `ack`, or `other` for handshakes and pings, which are left alone."""
        first = self.frames[0]
        return {"42": "event", "45": "event", "43": "ack", "46": "ack"}.get(
            first[:2] if isinstance(first, str) else "", "other"
        )


class Packing:
    """Puts the frames of one direction together again."""

    def __init__(self) -> None:
        self._frames: list[Frame] = []
        self._missing = 0

    def add(self, frame: Frame) -> Packet | None:
        """The packet that this frame completes; None while some of its bytes are on their way."""
        if isinstance(frame, str) and not frame.startswith("4"):
            return Packet((frame,))  # a ping may come between a message and its bytes
        if isinstance(frame, str):
            announced = re.match(r"4[56](\d+)-", frame)
            self._frames.clear()
            self._missing = int(announced[1]) if announced else 0
        else:
            self._missing -= 1
        self._frames.append(frame)
        return Packet(tuple(self._frames)) if self._missing <= 0 else None


class Stillness:
    """For how long nothing may pass."""

    def __init__(self) -> None:
        self._until = 0.0
        self._ended = asyncio.Event()

    def last(self, seconds: float) -> None:
        """Start now for this long, or longer if that was already requested."""
        self._until = max(self._until, asyncio.get_running_loop().time() + seconds)

    def end(self) -> None:
        """End it now."""
        self._until = 0.0
        self._ended.set()

    def holds(self) -> bool:
        """True while nothing may pass."""
        return self._until > asyncio.get_running_loop().time()

    async def over(self) -> None:
        """Wait for its end, which may be put off meanwhile."""
        while self.holds():
            self._ended.clear()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout_at(self._until):
                    await self._ended.wait()


class FaultyWire:
    """Listens on 127.0.0.1 for engines and relays between them and their device server.

    `done` counts the random faults; an explicit `cut` or `freeze` is not included. `target` and
    `faults` may be changed; a new target applies to connections made from then on.
    """

    def __init__(self, target: str, faults: WireFaults, port: int = 0) -> None:
        self.target = target
        self.faults = faults
        self.url = ""
        self.done: Counter[str] = Counter()
        self.stillness = Stillness()
        self._port = port
        self._made = 0
        self._runner: web.ServerRunner | None = None
        self._connections: dict[asyncio.Task[Any], Connection | None] = {}

    async def open(self) -> str:
        """Listen; returns the address for engines."""
        from aiohttp import web

        self._runner = web.ServerRunner(
            web.Server(self._serve, access_log=None), shutdown_timeout=END_S, handle_signals=False
        )
        try:
            await self._runner.setup()
            await web.TCPSite(self._runner, "127.0.0.1", self._port, reuse_address=True).start()
            self._port = self._runner.addresses[0][1]
        except BaseException:  # a cancel as well
            await self.close()
            raise
        self.url = f"http://127.0.0.1:{self._port}"
        return self.url

    async def close(self) -> None:
        """Break every connection and stop listening."""
        runner, self._runner = self._runner, None
        if runner is not None:
            for site in list(runner.sites):
                await site.stop()
        await end(*self._connections)
        if runner is not None:
            await runner.cleanup()

    def cut(self) -> None:
        """Break every connection now."""
        for connection in self._connections.values():
            if connection is not None:
                connection.cut()

    def freeze(self, seconds: float) -> None:
        """Let nothing through, either way, for this long; new connections wait as well."""
        self.stillness.last(seconds)

    async def _serve(self, request: "web.BaseRequest") -> "web.StreamResponse":
        """One engine's connection, from its first byte to its last."""
        import aiohttp
        from aiohttp import web

        near = web.WebSocketResponse(compress=False, max_msg_size=0, timeout=END_S)
        if not near.can_prepare(request):
            return web.Response(status=400, text="only WebSocket passes here\n")
        task = asyncio.current_task()
        assert task is not None
        self._connections[task] = None
        orderly = False
        try:
            await self.stillness.over()
            if request.transport is None:
                raise ConnectionResetError("the engine gave up meanwhile")
            async with _reached(self.target, request.path_qs) as far:
                await near.prepare(request)
                self._made += 1
                connection = self._connections[task] = Connection(self, self._made, near, far)
                orderly = await connection.last()
        except (OSError, aiohttp.ClientError):
            pass  # the server is not there, or gone: the engine finds its connection closed
        finally:
            del self._connections[task]
            if not orderly and request.transport is not None:
                request.transport.abort()
        return near if near.prepared else web.Response(status=502)


@asynccontextmanager
async def _reached(target: str, path: str) -> AsyncIterator["WebSocket"]:
    """A connection to the device server; leaving the block breaks it without a word."""
    import aiohttp

    from ....system.websocket import WebSocket

    async with aiohttp.ClientSession(ws_response_class=WebSocket) as session:
        async with asyncio.timeout(CONNECT_S):
            url = f"{target.rstrip('/')}{path}"
            far = cast(WebSocket, await session.ws_connect(url, max_msg_size=0))
        try:
            yield far
        finally:
            far.drop()


class Connection:
    """One engine and its server, until either of them or chance ends it."""

    def __init__(self, wire: FaultyWire, number: int, near: Any, far: Any) -> None:
        self._wire = wire
        self._stillness = Stillness()
        self._broken = asyncio.Event()
        self._ways = (Way(self, "up", number, near, far), Way(self, "down", number, far, near))

    @property
    def faults(self) -> WireFaults:
        """The faults that currently apply."""
        return self._wire.faults

    async def last(self) -> bool:
        """Return when it is over; False where it was cut, with all that was on its way."""
        listening = [spawn(f"listening, {way.name}", way.listen()) for way in self._ways]
        carrying = [spawn(f"carrying, {way.name}", way.carry()) for way in self._ways]
        broken = spawn("the end of a connection", self._broken.wait())
        try:
            await first_of({*carrying, broken})
            return not self.is_cut
        finally:
            await end(*listening, *carrying, broken)

    def cut(self) -> None:
        """Over, now."""
        self._broken.set()

    @property
    def is_cut(self) -> bool:
        """True when nothing passes any more."""
        return self._broken.is_set()

    def hang(self) -> None:
        """Nothing passes for a while."""
        self._stillness.last(self.faults.hang_s)

    def count(self, fault: str) -> None:
        """One more of a kind."""
        self._wire.done[fault] += 1

    async def passable(self) -> None:
        """Wait until something may pass."""
        while self._stillness.holds() or self._wire.stillness.holds():
            await self._stillness.over()
            await self._wire.stillness.over()


class Way:
    """One direction of a connection: packets in, their fates drawn, packets out."""

    def __init__(
        self, connection: Connection, name: str, number: int, source: Any, sink: Any
    ) -> None:
        self.name = name
        self._connection = connection
        self._source = source
        self._sink = sink
        self._lossy = (
            {"event": "drop_request"} if name == "up" else dict.fromkeys(TOLD, "drop_reply")
        )
        self._chance = random.Random(f"{connection.faults.seed}/{number}/{name}")
        self._queue: asyncio.Queue[Packet | None] = asyncio.Queue()
        self._last_due = 0.0

    async def listen(self) -> None:
        """Take in all that the source says, to its end."""
        packing = Packing()
        with contextlib.suppress(OSError):
            async for message in self._source:
                packet = packing.add(message.data) if isinstance(message.data, Frame) else None
                if packet is not None and not self._connection.is_cut:
                    self._meet(packet)
        loop = asyncio.get_running_loop()
        self._put(None, max(0.0, self._last_due - loop.time()) + TICK_S)

    def _meet(self, packet: Packet) -> None:
        """Draw a packet's fate and act on it."""
        if packet.kind not in TOLD:
            self._put(packet)
            return
        # All are drawn for every packet, so that one chance more does not shift the others.
        drawn = {fault: self._chance.random() for fault in KINDS}
        late_s, later_s = (self._chance.uniform(0, HOLD_S) for _ in range(2))
        if self._befalls("cut", drawn):
            self._connection.cut()
            return
        if self._befalls("hang", drawn):
            self._connection.hang()
        if packet.kind in self._lossy and self._befalls(self._lossy[packet.kind], drawn):
            return
        self._put(packet, late_s if self._befalls("reorder", drawn) else 0.0)
        if self._befalls("duplicate", drawn):
            self._put(packet, later_s)

    def _befalls(self, fault: str, drawn: dict[str, float]) -> bool:
        befalls = drawn[fault] < getattr(self._connection.faults, fault)
        if befalls:
            self._connection.count(fault)
        return befalls

    def _put(self, packet: Packet | None, delay_s: float = 0.0) -> None:
        if delay_s == 0.0:
            self._queue.put_nowait(packet)
            return
        loop = asyncio.get_running_loop()
        self._last_due = max(self._last_due, loop.time() + delay_s)
        loop.call_later(delay_s, self._queue.put_nowait, packet)

    async def carry(self) -> None:
        """Deliver what is due, whole packets one after the other, until the source has ended."""
        while (packet := await self._queue.get()) is not None:
            await self._connection.passable()
            if self._connection.is_cut:
                return
            # Who does not hear any more may still have said something that has to arrive.
            with contextlib.suppress(OSError):
                for frame in packet.frames:
                    await self._deliver(frame)
        await self._connection.passable()

    async def _deliver(self, frame: Frame) -> None:
        if isinstance(frame, str):
            await self._sink.send_str(frame)
        else:
            await self._sink.send_bytes(frame)
