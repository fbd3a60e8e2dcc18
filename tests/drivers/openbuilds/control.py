"""OpenBuilds CONTROL 1.0.390 as measured: a Socket.IO server with a queue in front of a GRBL peer.

It acknowledges nothing, asks `?` every 0.2 s and tells `status` every 0.1 s (so its Idle is often
false), says `jobComplete` when all is sent, adds a `$G` after a line with G90, stands still after an
error until it is cleared (a locked board, its status 5, hears what it is sent), and ignores `pause`
outside jobs. A report whose inputs have changed, the reset button among them, makes it stop the
board. It counts a port as connected when it is open, while the board still boots and loses what is
sent, and closes it if no banner comes; a report of `Alarm` is its status 5. FluidNC's answer to
`$CD` is an event of its own.
"""

import asyncio
import contextlib
import os
import re
import tty
from collections import deque

import socketio

from labrun.drivers.server.listen import bind, listening


class Control:
    """`async with Control(peer) as control:` serves it at `control.url`."""

    def __init__(self, peer, *, port=0):
        self.peer = peer
        self.port = port
        self.heard = []
        self.connection = 0
        self.alarm = ""  # kept until it is cleared, whoever connects meanwhile
        self.run = "Pending"
        self.hasty = False  # a command came before its first report
        self.work = dict.fromkeys("xyz", 0.0)
        self.offset = dict.fromkeys("xyz", 0.0)
        self.overrides = {"feedOverride": 100, "rapidOverride": 100, "spindleOverride": 100}
        self.active = ""
        self.inputs = []
        self.queue = deque()
        self.sent = None
        self.told = True  # whether it tells `status`
        self.boots_for_long = False
        self.gives_up_s = (
            0.0  # it closes a port on which nothing has responded by then; 2 s on the real one
        )
        self.completed = 0
        self.platform = ""
        self.configuration = []
        self.file = None
        self.asks_from = 0.0
        self.asks_after_s = 0.3  # 2 s on the real one
        self.rest = b""

    async def __aenter__(self):
        # The real one shakes hands by polling, too; no answer is ever an acknowledgement.
        self.sio = socketio.AsyncServer(async_mode="asgi", cors_allowed_origins=[])
        for name in ("connectTo", "runCommand", "stop", "clearAlarm", "serialInject", "pause"):
            self.sio.on(name, getattr(self, f"_{name}"))
        self.sio.on("jogTo", self._jog_to)
        listener = bind("127.0.0.1", self.port)
        self.port = listener.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self._serving = listening(socketio.ASGIApp(self.sio), listener, None)
        await self._serving.__aenter__()
        self._tasks = [asyncio.create_task(self._tell()), asyncio.create_task(self._ask())]
        return self

    async def __aexit__(self, *_):
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._close_port()
        await self.sio.shutdown()
        await self._serving.__aexit__(None, None, None)

    # -- what it tells ------------------------------------------------------------------------

    async def _tell(self):
        while True:
            if self.told:
                await self.sio.emit("status", self._status())
            await asyncio.sleep(0.1)

    async def _ask(self):
        while True:
            if asyncio.get_running_loop().time() > self.asks_from:
                self._write(b"?")
            await asyncio.sleep(0.2)

    def _status(self):
        return {
            "machine": {
                "firmware": {"platform": self.platform},
                "position": {"work": dict(self.work), "offset": dict(self.offset)},
                "overrides": dict(self.overrides),
                "inputs": self.inputs,
            },
            "comms": {
                "connectionStatus": self.connection,
                "runStatus": self.run,
                "queue": len(self.queue),
                "interfaces": {"ports": [], "activePort": self.active, "activeBaud": 115200},
                "alarm": self.alarm,
            },
        }

    def _emit(self, event, data):
        task = asyncio.get_running_loop().create_task(self.sio.emit(event, data))
        self._tasks.append(task)

    # -- what it is told ----------------------------------------------------------------------

    async def _connectTo(self, _, data):  # noqa: N802 - the event's name
        self.heard.append(("connectTo", data))
        if self.connection == 0:
            self.connection = 1
            await asyncio.sleep(0.2)  # 2 s on the real one
            with contextlib.suppress(OSError):
                self.file = os.open(data["port"], os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
                tty.setraw(self.file)
                attributes = tty.tcgetattr(self.file)
                attributes[4] = attributes[5] = tty.B115200
                tty.tcsetattr(self.file, tty.TCSANOW, attributes)
                asyncio.get_running_loop().add_reader(self.file, self._read)
                self.active = data["port"]
                self.asks_from = asyncio.get_running_loop().time() + self.asks_after_s
            self.connection = 0 if self.file is None else 2
            if self.gives_up_s:
                await asyncio.sleep(self.gives_up_s)
                self._close_port()

    async def _runCommand(self, _, data):  # noqa: N802
        self.heard.append(("runCommand", data))
        self.hasty |= self.run == "Pending"
        if self.connection == 0:
            return
        for line in data.split("\n"):
            text = line.split(";")[0].strip()
            if text:
                self.queue.append(text)
                if re.search("G90|G21|G54|M3", text):
                    self.queue.append("$G")
        self.run = "Running"
        self._send()

    async def _stop(self, _, data):
        self.heard.append(("stop", data))
        if data.get("jog"):
            self._write(b"\x85")
            return
        self.queue.clear()
        self.sent = None
        if not data.get("abort"):
            self._write(b"!")
        await asyncio.sleep(0.2)
        self._write(b"\x18")
        self.connection, self.run, self.alarm = 2, "Stopped", ""

    async def _clearAlarm(self, _, data):  # noqa: N802
        self.heard.append(("clearAlarm", data))
        self.alarm = ""
        if data == 2:
            self.queue.clear()
            self.sent = None
            self._write(b"\x18")
            await asyncio.sleep(0.5)
            self.connection = 2
            if self.boots_for_long:
                return  # it boots, and loses what it is sent
        self._write(b"$X\n")

    async def _serialInject(self, _, data):  # noqa: N802
        self.heard.append(("serialInject", data))
        self._write(data.encode())

    async def _pause(self, _, data=None):
        if self.connection == 3:
            self._write(b"!")

    async def _jog_to(self, _, data):
        self.queue.append(f"$J=G91G210X{data['x']}F{data['feed']}")
        self._send()

    # -- the controller -----------------------------------------------------------------------

    def _write(self, data):
        if self.file is not None:
            with contextlib.suppress(OSError):
                os.write(self.file, data)

    def _send(self):
        if self.sent is None and self.queue and self.connection > 1:
            self.sent = self.queue.popleft()
            # Its `?` of every 0.2 s often goes out with the line, and overtakes it: a false Idle.
            self._write(self.sent.encode() + b"\n" + (b"?" if "X" in self.sent else b""))
            self._emit("queueCount", [len(self.queue), 0])
            if not self.queue:
                self.completed += 1
                self._emit("jobComplete", {"completed": True, "failed": True})

    def _read(self):
        try:
            data = os.read(self.file, 4096)
        except OSError:
            data = b""
        if not data:
            self._close_port()
            return
        *lines, self.rest = (self.rest + data).split(b"\n")
        for line in lines:
            if text := line.decode("ascii", "replace").strip():
                self._hear(text)

    def _close_port(self):
        if self.file is not None:
            asyncio.get_running_loop().remove_reader(self.file)
            os.close(self.file)
        self.file, self.connection, self.active = None, 0, ""  # runStatus stays as it was
        self.queue.clear()
        self.sent = None

    def _hear(self, text):
        self._emit("data", {"command": self.sent or "", "response": text, "type": "info"})
        if text.startswith("Grbl"):
            self.platform = "FluidNC" if "FluidNC" in text else "gnea"
        if text.startswith("<"):
            self._report(text)
        elif text == "ok":
            line, self.sent = self.sent, None
            if line == "$CD":
                self._emit("fluidncConfig", "\n".join(self.configuration))
            if line is not None:
                self._emit("ok", line)
                self._emit("jobComplete", {"completed": True, "failed": True})
                self._send()
            if not self.queue:
                self.connection = 2  # "finished", whatever it was before
        elif found := re.fullmatch(r"error:(\d+)", text):
            self.connection = 5
            self._emit("toastError", f"error: {found[1]} - in words [ {self.sent} ]")
        elif self.sent == "$CD":
            self.configuration.append(text)
        elif found := re.fullmatch(r"ALARM:(\d+)", text):
            self.connection, self.alarm = 5, f"{found[1]} - in words."
            if found[1] != "5":
                self._emit("toastErrorAlarm", f"ALARM: {found[1]} - in words [ {self.sent} ]")

    def _report(self, text):
        fields = dict(part.partition(":")[::2] for part in text.strip("<>").split("|")[1:])
        if "WCO" in fields:
            self.offset = dict(zip("xyz", map(float, fields["WCO"].split(",")), strict=True))
        if "Ov" in fields:
            self.overrides = dict(
                zip(self.overrides, map(int, fields["Ov"].split(",")), strict=True)
            )
        machine = map(float, fields["MPos"].split(","))
        self.work = {a: v - self.offset[a] for a, v in zip("xyz", machine, strict=True)}
        self.run = text[1:].partition("|")[0]
        if self.run == "Alarm":
            self.connection = 5
        before, self.inputs = self.inputs, list(fields.get("Pn", ""))
        if self.inputs != before and "R" in self.inputs:  # a button that is pressed, or wired so
            self._tasks.append(asyncio.get_running_loop().create_task(self._stop(None, {})))
