"""Moonraker and Klipper behind it, as 0.11.0 and Klipper's own host and simulated board were seen to behave.

A line is answered when it is planned, `M400` when all has stood still, by its own clock, and
`QUERY_ENDSTOPS` by its board; a line waits for the one before it, an emergency stop does not; any
program may set relative moves (`G91`), let go of the motors (`M18`), or have a file printed; the news
of a halt and of a start come after the state that they tell; a restart that comes at once after a
halt ends in state error, as its board is not ready yet; a line that Klipper does not know is answered
as done, and told in a message beside; reports come four times a second; nobody is let in without the API key.
"""

import asyncio
import contextlib
import json
import math
import re
import threading
import time

from aiohttp import WSMsgType, web

WORD = re.compile(r"([A-Z])(-?\d+(?:\.\d+)?)")
REPORT_S = 0.25


class Peer:
    """Start it, give `url` to a driver, look at `stands` afterwards."""

    def __init__(self, *, speed=50.0, homing_s=0.2, api_key=None):
        self.speed, self.homing_s, self.api_key = speed, homing_s, api_key
        self.state, self.message, self.axes, self.factor = "ready", "Printer is ready", "", 1.0
        self.place, self.told, self.shift = [0.0] * 3, [0.0] * 3, [0.0, 0.0, 0.0]
        self.relative, self.prints = False, None
        self.restarts, self._is_news = 0, False
        self.is_gone = False  # its board; Klipper plans on
        self.blocks, self.stands, self.heard, self.sockets = [], [], [], set()
        self._ready, self._over = threading.Event(), None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._live()), daemon=True)
        self._thread.start()
        assert self._ready.wait(10)

    @property
    def move(self):
        return self.blocks or None

    def close(self):
        self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(10)

    async def _live(self):
        self._loop, self._over, self._turn = (
            asyncio.get_running_loop(),
            asyncio.Event(),
            asyncio.Lock(),
        )
        app = web.Application()
        app.router.add_get("/websocket", self._serve)
        runner = web.AppRunner(app, shutdown_timeout=0.1)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", 0)
        await site.start()
        self.url = f"http://127.0.0.1:{site._server.sockets[0].getsockname()[1]}"
        reporting = asyncio.create_task(self._report())
        moving = asyncio.create_task(self._drive())
        self._ready.set()
        await self._over.wait()
        for task in (reporting, moving):
            task.cancel()
        for socket in list(self.sockets):
            await socket.close()
        await runner.cleanup()

    async def _serve(self, request):
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        tasks, allowed = set(), self.api_key is None
        async for message in socket:
            if message.type is not WSMsgType.TEXT:
                continue
            call = json.loads(message.data)
            if call["method"] == "server.connection.identify":
                allowed = allowed or call["params"].get("api_key") == self.api_key
            if not allowed:
                error = {"code": -32602, "message": "Unauthorized"}
                await socket.send_json({"jsonrpc": "2.0", "error": error, "id": call["id"]})
                continue
            self.sockets.add(socket)
            tasks.add(asyncio.create_task(self._answer(socket, call)))
        self.sockets.discard(socket)
        return socket

    async def _answer(self, socket, call):
        try:
            told = {"result": await self._does(call["method"], call.get("params") or {})}
        except ValueError as fault:
            told = {"error": {"code": 400, "message": str(fault)}}
        with contextlib.suppress(ConnectionError):
            await socket.send_json({"jsonrpc": "2.0", **told, "id": call["id"]})

    async def _does(self, method, params):
        match method:
            case "server.connection.identify":
                return {"connection_id": 1}
            case "server.info":
                return {"klippy_connected": True, "klippy_state": self.state}
            case "printer.info":
                return {"state": self.state, "state_message": self.message}
            case "printer.objects.subscribe":
                return {"status": self._status()}
            case "printer.objects.query":
                if self._is_news:
                    self._is_news = False
                    await self._tell("notify_klippy_ready")
                await asyncio.sleep(REPORT_S / 2)
                settings = {"printer": {"max_z_velocity": self.speed, "max_z_accel": 3000.0}}
                return {"status": self._status() | {"configfile": {"settings": settings}}}
            case "printer.emergency_stop":
                await self._halt("Shutdown due to webhooks request")
                return "ok"
            case "printer.firmware_restart":
                await self._tell("notify_klippy_disconnected")
                self.restarts += 1
                if self.restarts < 2:
                    self.state = "error"
                    self.message = "MCU 'mcu' error during config: Can not update MCU"
                else:
                    self.state, self.message, self.axes = "ready", "Printer is ready", ""
                    self._is_news = True
                return "ok"
            case "printer.gcode.script":
                async with self._turn:
                    for line in params["script"].splitlines():
                        await self._line(line)
                    return "ok"
        raise ValueError("Method not found")

    async def _line(self, line):
        self.heard.append(line)
        code, words = (
            line.split()[0],
            {n: float(v) for n, v in WORD.findall(line.partition(" ")[2])},
        )
        if self.state != "ready":
            raise ValueError(self.message)
        match code:
            case "G28":
                end = time.monotonic() + self.homing_s
                while time.monotonic() < end:
                    await asyncio.sleep(0.01)
                    if self.state != "ready":
                        raise ValueError(self.message)
                self.place, self.told, self.axes = [0.0, 0.0, 100.0], [0.0, 0.0, 100.0], "xyz"
                self.stands.append(list(self.place))
            case "G0" | "G1":
                zero = self.told if self.relative else self.shift
                moved = enumerate("XYZ")
                end = [words[a] + zero[i] if a in words else self.told[i] for i, a in moved]
                if not all(-1e-6 <= value <= 200 for value in end):
                    raise ValueError(f"Move out of range: {end}")
                if self.axes != "xyz":
                    raise ValueError("Must home axis first")
                speed = min(self.speed, words.get("F", 1e9) / 60 * self.factor)
                if length := math.dist(self.told, end):
                    begins = self.blocks[-1][3] if self.blocks else time.monotonic()
                    self.blocks.append((self.told, end, begins, begins + length / speed))
                self.told = end
            case "M400" | "QUERY_ENDSTOPS":
                while self.blocks:  # noqa: ASYNC110 - a clock moves it
                    await asyncio.sleep(0.005)
                if code == "QUERY_ENDSTOPS" and self.is_gone:
                    await self._halt("Lost communication with MCU 'mcu'")
                    raise ValueError(self.message)
            case "M114":
                x, y, z = (at - by for at, by in zip(self.told, self.shift, strict=True))
                await self._tell("notify_gcode_response", f"X:{x:.3f} Y:{y:.3f} Z:{z:.3f} E:0.000")
            case "M220":
                self.factor = words["S"] / 100
            case "G90" | "G91":
                self.relative = code == "G91"
            case "M18":
                self.axes = ""
            case "M25":
                self.prints = None
            case "SET_PIN":
                pass
            case _:
                await self._tell("notify_gcode_response", f'// Unknown command:"{code}"')

    async def _halt(self, why):
        self.state, self.message, self.axes = "shutdown", why, ""
        self.blocks.clear()
        await self._tell("notify_status_update", {"webhooks": self._status()["webhooks"]}, 0.0)
        await self._tell("notify_klippy_shutdown")

    async def _tell(self, method, *params):
        for socket in list(self.sockets):
            with contextlib.suppress(ConnectionError):
                await socket.send_json({"jsonrpc": "2.0", "method": method, "params": list(params)})

    def _status(self):
        shown = [at - by for at, by in zip(self.told, self.shift, strict=True)]
        most = [200.0, 200.0, 100.0, 0]
        return {
            "toolhead": {
                "position": [*self.told, 0], "homed_axes": self.axes, "axis_minimum": [0.0] * 4,
                "axis_maximum": most, "max_velocity": self.speed, "max_accel": 3000.0,
            },
            "gcode_move": {
                "position": [*self.told, 0], "gcode_position": [*shown, 0], "speed_factor": self.factor,
            },
            "motion_report": {"live_position": [*self.place, 0], "live_velocity": 0},
            "webhooks": {"state": self.state, "state_message": self.message},
            "virtual_sdcard": {"is_active": bool(self.prints), "file_path": self.prints},
        }  # fmt: skip

    async def _report(self):
        while True:
            await asyncio.sleep(REPORT_S)
            await self._tell("notify_status_update", self._status(), 0.0)

    async def _drive(self):
        while True:
            await asyncio.sleep(0.003)
            while self.blocks:
                start, end, begins, ends = self.blocks[0]
                part = min(1.0, (time.monotonic() - begins) / (ends - begins))
                self.place = [a + part * (b - a) for a, b in zip(start, end, strict=True)]
                if part < 1.0:
                    break
                self.blocks.pop(0)
                if not self.blocks:
                    self.stands.append(list(self.place))
