"""The wire between an engine and a device server: late, cut, stalled, and with lost and double messages."""

import asyncio
import contextlib
from collections.abc import Callable
from contextvars import Context, copy_context
from random import Random
from typing import Any

from ...drivers.client.link import Answer, Link, LinkDown, ServerUnreachable
from ...system.tasks import keep
from .process import Died, Process, living

LATENCY_S = 0.0002, 0.004


class Socket:
    """What a device server has in place of its Socket.IO server: `on`, `emit`, `shutdown`."""

    def __init__(self, process: Process) -> None:
        self.process = process
        self.handlers: dict[str, Callable[..., Any]] = {}
        self.sessions: dict[str, Session] = {}

    def on(self, event: str, handler: Callable[..., Any], namespace: str) -> None:
        """Register a handler."""
        self.handlers[event] = handler

    async def emit(self, event: str, payload: Answer, namespace: str, to: str = "") -> None:
        """Send an event to one client, or to all."""
        for name, session in list(self.sessions.items()):
            if to in ("", name):
                session.to_client(lambda link: link.heard(event, dict(payload)))

    async def shutdown(self) -> None:
        """Close every connection."""
        for session in list(self.sessions.values()):
            session.close()


class Network:
    """Who listens where, and how bad the wire is; `loss` is the share of messages lost or doubled."""

    def __init__(self, random: Random, loss: float) -> None:
        self.random = random
        self.loss = loss
        self.sockets: dict[str, Socket] = {}
        self.cut_until: dict[str, float] = {}
        self.stalled_until: dict[str, float] = {}
        self.count = 0

    def cut(self, url: str, for_s: float) -> None:
        """Break every connection; none is made for some time."""
        self.cut_until[url] = asyncio.get_running_loop().time() + for_s
        self.drop(url)

    def drop(self, url: str) -> None:
        """Break every connection."""
        for session in list(self.sockets[url].sessions.values()) if url in self.sockets else ():
            session.close()

    def late(self, url: str, after: float) -> float:
        """When a message arrives that is sent now, after an earlier one."""
        now = asyncio.get_running_loop().time() + self.random.uniform(*LATENCY_S)
        arrives = max(now, self.stalled_until.get(url, 0.0))
        return arrives if self.random.random() < self.loss else max(arrives, after)

    def copies(self) -> int:
        """How often a message arrives."""
        return self.random.choice((0, 2)) if self.random.random() < self.loss else 1


class Session:
    """One connection; nothing of it arrives after its end."""

    def __init__(self, network: Network, url: str, link: "SimulatedLink", socket: Socket) -> None:
        network.count += 1
        self.name = f"session-{network.count}"
        self.network, self.url, self.link, self.socket = network, url, link, socket
        self.open = True
        self._there = self._back = 0.0
        self._client: Context = copy_context()
        socket.sessions[self.name] = self

    def to_server(self, event: str, payload: Answer, answered: Callable[[Answer], None]) -> None:
        """A request, whose answer comes back."""
        for _ in range(self.network.copies()):
            self._there = self.network.late(self.url, self._there)
            asyncio.get_running_loop().call_at(self._there, self._arrive, event, payload, answered)

    def _arrive(self, event: str, payload: Answer, answered: Callable[[Answer], None]) -> None:
        if self.open and self.socket.process.alive:
            self.socket.process.spawn(event, self._answer(event, dict(payload), answered))

    async def _answer(
        self, event: str, payload: Answer, answered: Callable[[Answer], None]
    ) -> None:
        answer = await self.socket.handlers[event](self.name, payload)
        self.to_client(lambda link: answered(answer))

    def to_client(self, act: Callable[["SimulatedLink"], None]) -> None:
        """An answer or an event; the process that sends it may be dead by now."""
        if not (self.open and self.socket.process.alive):
            return
        for _ in range(self.network.copies()):
            self._back = self.network.late(self.url, self._back)
            asyncio.get_running_loop().call_at(self._back, self._deliver, act, context=self._client)

    def _deliver(self, act: Callable[["SimulatedLink"], None]) -> None:
        if self.open and self.link.process.alive:
            with contextlib.suppress(Died):
                act(self.link)

    def close(self) -> None:
        """Both sides notice."""
        if self.open:
            self.open = False
            del self.socket.sessions[self.name]
            if self.socket.process.alive:
                left = self.socket.handlers["disconnect"](self.name)
                self.socket.process.spawn("disconnect", left)
            if self.link.process.alive:
                self._client.copy().run(self.link.broken)


class SimulatedLink(Link):
    """A link of the client over the simulated wire."""

    network: Network

    def __init__(self, *parts: Any) -> None:
        super().__init__(*parts)
        self.process = living()
        self.session: Session | None = None

    async def open(self, timeout_s: float) -> None:
        first: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._keeper = keep(f"the link to {self.url}", lambda: self._keep(first))
        await asyncio.wait({first}, timeout=timeout_s)
        if not first.done():
            await self.close()
            raise ServerUnreachable(self.url, "no response")

    async def _connect(self) -> None:
        self._broken.clear()
        network = self.network
        await asyncio.sleep(network.random.uniform(*LATENCY_S))
        socket = network.sockets.get(self.url)
        now = asyncio.get_running_loop().time()
        if socket is None or now < network.cut_until.get(self.url, 0.0):
            raise ServerUnreachable(self.url, "refused")
        self.session = Session(network, self.url, self, socket)
        await socket.handlers["connected"](self.session.name)

    def broken(self) -> None:
        """The connection is no more."""
        self._break(self._sio)  # pyright: ignore[reportArgumentType] - none here

    def heard(self, event: str, payload: Answer) -> None:
        """An event from the server."""
        if event in self._events:
            self._events[event](payload)

    async def _drop(self) -> None:
        was_up = self.up.is_set()
        self.up.clear()
        session, self.session = self.session, None
        for future in self._waiting:
            if not future.done():
                future.set_exception(LinkDown(f"the connection to {self.url} is closed"))
        if was_up:
            self._on_down()
        if session is not None:
            session.close()

    async def send(self, event: str, payload: Answer, answered: Callable[[Answer], None]) -> bool:
        living()
        if self.session is None or not self.session.open:
            return False
        self.session.to_server(event, payload, answered)
        return True
