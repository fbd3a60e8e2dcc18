"""Bytes to and from an instrument: TCP, UDP, a WebSocket, a serial port, or whatever VISA reaches.

TCP and serial ports are streams that are always listened to, so that a banner, a late answer or an
unsolicited line is seen when it comes. VISA is asked in a thread of its own.
"""

import asyncio
import contextlib
import errno
import socket
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from ...system.extras import needed
from ...system.tasks import end, spawn
from ..serial_io.condition import Condition
from ..serial_io.open_port import OpenPort
from ..serial_io.port import SerialPort
from .resource import Resource

REFUSED_AGAIN_S = 0.25
CALM_S, MOST_CALMS = 0.1, 20
"""What comes within this time after connecting is a banner."""
MOST = 256 * 1024 * 1024
"""Bytes that are kept of an instrument that nobody listens to."""


class Channel:
    """`received` grows while it is open; `fault` says why it is not."""

    def __init__(self, resource: Resource) -> None:
        self.resource = resource
        self.received = bytearray()
        self.heard_at = float("-inf")
        self.news = Condition()
        self.is_open = False
        self.fault = "it is not open"
        self.late = b""
        """What was still to come of an answer that had been given up, when it was opened again."""
        self._owed_until = float("-inf")

    def owes(self, timeout_s: float) -> None:
        """Note that an answer was given up: on a line that goes on when it is closed, it may still come."""
        self._owed_until = asyncio.get_running_loop().time() + timeout_s

    async def skip_late_answer(self) -> None:
        """Let pass what is still to come of an answer that was given up; raises OSError."""
        left = self._owed_until - asyncio.get_running_loop().time()
        self._owed_until, self.late = float("-inf"), b""
        if left > 0 and await self.more(left):
            await self.quiet()
            self.late = bytes(self.received)
            self.received.clear()

    def late_words(self) -> str:
        """That it came, for a message; empty if it did not."""
        return (
            f"; an earlier answer, {self.late[:60]!r}, came too late: a longer `timeout`?"
            if self.late
            else ""
        )

    async def open(self, timeout_s: float) -> None:
        """Connect; raises OSError with the reason."""
        raise NotImplementedError

    async def close(self) -> None:
        """Disconnect."""
        self.is_open = False

    async def write(self, data: bytes) -> None:
        """Send; raises OSError if the connection is gone."""
        raise NotImplementedError

    async def more(self, timeout_s: float) -> bool:
        """Wait for more bytes; False if none came. Raises OSError if the connection is gone."""
        before = len(self.received)
        await self.news.until(lambda: len(self.received) > before or not self.is_open, timeout_s)
        if len(self.received) > before:
            return True
        if not self.is_open:
            raise OSError(f"{self.resource}: {self.fault}")
        return False

    async def quiet(self) -> None:
        """Wait until nothing comes any more for a moment, unless it never stops."""
        for _ in range(MOST_CALMS):
            if not await self.more(CALM_S):
                break

    def take(self, data: bytes) -> None:
        """What came in."""
        self.received += data[: MOST - len(self.received)]
        self.heard_at = asyncio.get_running_loop().time()
        self.news.set()

    def lost(self, fault: str) -> None:
        """The other end is gone."""
        self.is_open, self.fault = False, fault
        self.news.set()


class _Listener(asyncio.Protocol, asyncio.DatagramProtocol):
    def __init__(self, channel: Channel, host: str = "") -> None:
        self._channel: Channel | None = channel
        self._host = host

    def data_received(self, data: bytes) -> None:
        if self._channel is not None:
            self._channel.take(data)

    def datagram_received(self, data: bytes, addr: Any) -> None:
        if self._host in ("", addr[0]):
            self.data_received(data if data.endswith((b"\n", b"\r")) else data + b"\n")

    def error_received(self, exc: Exception) -> None:
        if self._channel is not None:
            self._channel.lost(f"nothing is there ({exc})")

    def connection_lost(self, exc: Exception | None) -> None:
        if self._channel is not None:
            self._channel.lost(f"the connection was closed{f' ({exc})' if exc else ''}")

    def forget(self) -> None:
        self._channel = None


class Network(Channel):
    """TCP or UDP; its answers come to the port that has asked, or to another one of ours."""

    _transport: Any = None
    _listener: _Listener
    _to: Any = None

    def __init__(self, resource: Resource, local_port: int | None = None) -> None:
        super().__init__(resource)
        self._local_port = local_port

    async def open(self, timeout_s: float) -> None:
        await self.close()
        self.received.clear()
        loop, at = asyncio.get_running_loop(), self.resource
        self._listener = _Listener(self)
        until = loop.time() + timeout_s
        try:
            async with asyncio.timeout_at(until):
                if self._local_port is not None:
                    await self._listen_at(self._local_port)
                elif at.kind == "udp":
                    self._transport, _ = await loop.create_datagram_endpoint(
                        lambda: self._listener, remote_addr=(at.host, at.port)
                    )
                else:
                    self._transport = await self._connected(until)
        except TimeoutError as fault:
            raise OSError(
                f"{at} does not answer within {timeout_s:g} s: is it on, and is this its address?"
            ) from fault
        except OSError as fault:
            raise OSError(f"{at} cannot be reached: {_reason(fault)}") from fault
        self.is_open = True
        if at.kind == "udp":
            await self.skip_late_answer()

    async def _listen_at(self, port: int) -> None:
        """Hear what this instrument sends to a port of ours, from whichever of its own."""
        loop, at = asyncio.get_running_loop(), self.resource
        found = await loop.getaddrinfo(at.host, at.port, type=socket.SOCK_DGRAM)
        family, _, _, _, self._to = found[0]
        self._listener = _Listener(self, self._to[0])
        everywhere = "::" if family == socket.AF_INET6 else "0.0.0.0"
        self._transport, _ = await loop.create_datagram_endpoint(
            lambda: self._listener, local_addr=(everywhere, port)
        )

    async def _connected(self, until: float) -> Any:
        """An instrument with one place for a client refuses until it has seen the last one leave."""
        loop, at = asyncio.get_running_loop(), self.resource
        while True:
            try:
                made = await loop.create_connection(lambda: self._listener, at.host, at.port)
                return made[0]
            except ConnectionRefusedError:
                if loop.time() + 2 * REFUSED_AGAIN_S > min(until, loop.time() + 1.0):
                    raise
                until = min(until, loop.time() + 1.0)
                await asyncio.sleep(REFUSED_AGAIN_S)

    async def close(self) -> None:
        await super().close()
        if self._transport is not None:
            self._listener.forget()
            self._transport.abort()  # nothing that was typed before may go out later
            self._transport = None

    async def write(self, data: bytes) -> None:
        if not self.is_open:
            raise OSError(f"{self.resource}: {self.fault}")
        if self.resource.kind == "udp":
            self._transport.sendto(data, self._to)
        else:
            self._transport.write(data)


class Messages(Channel):
    """A WebSocket: a message that comes is a line, and a line is sent as a message of text."""

    _socket: Any = None
    _hearing: asyncio.Task[None] | None = None

    async def open(self, timeout_s: float) -> None:
        from websockets.asyncio.client import connect
        from websockets.exceptions import WebSocketException

        await self.close()
        self.received.clear()
        try:
            self._socket = await connect(
                self.resource.name, open_timeout=timeout_s, close_timeout=CALM_S,
                ping_interval=None, max_size=MOST, proxy=None,  # an instrument is no web page
            )  # fmt: skip
        except TimeoutError as fault:
            raise OSError(f"{self.resource} does not answer within {timeout_s:g} s") from fault
        except (OSError, WebSocketException) as fault:
            why = _reason(fault) if isinstance(fault, OSError) else fault
            raise OSError(f"{self.resource} cannot be reached: {why}") from fault
        self.is_open = True
        self._hearing = spawn(f"hear {self.resource}", self._hear(self._socket))

    async def _hear(self, socket: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        with contextlib.suppress(ConnectionClosed):
            while True:
                message = await socket.recv()
                data = message.encode() if isinstance(message, str) else message
                self.take(data if data.endswith((b"\n", b"\r")) else data + b"\n")
        self.lost("the connection was closed")

    async def close(self) -> None:
        await super().close()
        socket, self._socket = self._socket, None
        await end(self._hearing)
        if socket is not None:
            await socket.close()

    async def write(self, data: bytes) -> None:
        from websockets.exceptions import ConnectionClosed

        try:
            if not self.is_open:
                raise OSError(f"{self.resource}: {self.fault}")
            await self._socket.send(data.decode(errors="replace").rstrip("\r\n"))
        except ConnectionClosed as fault:
            raise OSError(f"{self.resource}: the connection was closed") from fault


class Serial(Channel):
    """A serial port."""

    def __init__(self, resource: Resource, port: SerialPort, flow: str) -> None:
        super().__init__(resource)
        self.port = port
        opened = partial(port.opened, rtscts=flow == "rtscts", xonxoff=flow == "xonxoff")
        self._bytes = OpenPort(port.name, opened, self.take, lambda fault: self.lost(str(fault)))

    async def open(self, timeout_s: float) -> None:
        await self.close()
        self.received.clear()
        await self._bytes.open()
        self.is_open = True
        await self.skip_late_answer()

    async def close(self) -> None:
        await super().close()
        await self._bytes.close()

    async def write(self, data: bytes) -> None:
        if not self.is_open:
            raise self.port.unplugged(self.fault)
        try:
            await self._bytes.send(data)
        except OSError as fault:
            self.lost(str(fault))
            raise self.port.unplugged(fault) from fault


class Visa(Channel):
    """USB, GPIB, VXI-11, HiSLIP, Prologix and others, by PyVISA; `library` is `@py` or another."""

    _session: Any = None
    _manager: Any = None

    def __init__(self, resource: Resource, library: str) -> None:
        super().__init__(resource)
        self._library = library
        self._worker = ThreadPoolExecutor(1, f"visa {resource}")

    async def open(self, timeout_s: float) -> None:
        await self.close()
        self.received.clear()
        try:
            await self._call(self._open, timeout_s)
        except Exception as fault:  # PyVISA's own, and ValueError, for what it cannot reach
            raise OSError(f"{self.resource} cannot be opened by VISA: {fault}") from fault
        self.is_open = True

    def _open(self, timeout_s: float) -> None:
        self._manager = needed("pyvisa").ResourceManager(self._library)
        self._session = self._manager.open_resource(
            self.resource.name, open_timeout=int(timeout_s * 1000)
        )

    async def _call(self, work: Any, *given: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._worker, work, *given)

    async def close(self) -> None:
        await super().close()
        manager, self._session, self._manager = self._manager, None, None
        if manager is not None:
            with contextlib.suppress(Exception):  # it may be gone already
                await self._call(manager.close)

    async def write(self, data: bytes) -> None:
        if self._session is None:
            raise OSError(f"{self.resource}: {self.fault}")
        try:
            await self._call(self._session.write_raw, data)
        except Exception as fault:  # VISA's own and its back ends'
            self.lost(str(fault))
            raise OSError(f"{self.resource} does not take what is sent: {fault}") from fault

    async def more(self, timeout_s: float) -> bool:
        if self._session is None:
            raise OSError(f"{self.resource}: {self.fault}")
        try:
            self.take(await self._call(self._read, max(timeout_s, 0.001)))
        except Exception as fault:  # as above
            if "VI_ERROR_TMO" in str(fault):
                return False
            self.lost(str(fault))
            raise OSError(f"{self.resource}: {fault}") from fault
        return True

    def _read(self, timeout_s: float) -> bytes:
        self._session.timeout = int(timeout_s * 1000) or 1
        data: bytes = self._session.read_raw()
        return data if data.endswith((b"\n", b"\r")) else data + b"\n"  # a message is a line

    async def clear(self) -> None:
        """Clear the device: what it is doing is given up, its buffers are emptied."""
        await self._call(self._session.clear)


REASONS = {
    errno.ECONNREFUSED: "nothing listens there; is it on, and is this its port?",
    errno.EHOSTUNREACH: "there is no way to it; is it on, and is the cable plugged in?",
    errno.EADDRINUSE: "another program on this computer already listens at its `local_port`",
}


def _reason(fault: OSError) -> str:
    return REASONS.get(fault.errno or 0, str(fault.strerror or fault))
