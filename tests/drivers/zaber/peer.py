"""A chain of Zaber stages on a pseudo-terminal, as the maker's library speaks to them (ASCII, firmware 7).

Every command is answered at once, `BUSY` while the axis moves; a move that is given during a move takes
its place, from the speed that it has; `stop` brakes. Before homing an axis warns that it has no reference
(WR). A stall (FS) stays until warnings are cleared. Checksums and message ids are those of the protocol.
"""

import contextlib
import math
import os
import pty
import re
import select
import threading
import time
import tty
from pathlib import Path

COMMAND = re.compile(r"/(\d+)? ?(\d+)? ?(\d+)? ?(.*)$")
VELOCITY = 1.6384
MICROSTEP_MM = 0.00049609375
TRAVEL = 503_937  # 250 mm


class Axis:
    """One stage: where it is, how fast, and where it is sent, in microsteps and seconds."""

    def __init__(self, speed):
        self.maxspeed, self.accel = round(speed / MICROSTEP_MM * VELOCITY), 2050
        self.place, self.speed = 40_000.0, 0.0
        self.target, self.limit, self.rate = None, 0.0, 0.0
        self.homing = False
        self.flags, self.parked = {"WR"}, False
        self.path = []

    def send(self, target, rate, accel):
        self.target, self.limit = target, rate / VELOCITY
        self.rate = accel * 10_000 / VELOCITY

    def drive(self, seconds):
        if self.target is None:
            return
        left = self.target - self.place
        most = min(self.limit, math.sqrt(2 * self.rate * abs(left)))
        wanted = math.copysign(most, left)
        change = self.rate * seconds
        self.speed += max(-change, min(change, wanted - self.speed))
        step = self.speed * seconds
        if abs(left) <= max(abs(step), 1.0):
            self.place, self.speed, self.target = float(self.target), 0.0, None
            if self.homing:
                self.homing = False
                self.flags -= {"WR"}
        else:
            self.place += step

    def stop(self):
        self.homing = False
        if self.target is not None:
            way = self.speed**2 / (2 * self.rate)
            self.target = round(self.place + math.copysign(way, self.speed))


class Peer:
    """Start it, give `path` to a driver; look at `axes`, `heard` and `pins` afterwards."""

    def __init__(self, *, axes=3, speed=50.0, version="7.35.19000"):
        self.axes = {number: Axis(speed) for number in range(1, axes + 1)}
        self.version, self.heard, self.pins = version, [], {}
        self.mute = False
        self._ends = threading.Event()
        self.plug()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def plug(self):
        self.master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.path = getattr(self, "path", None) or f"/tmp/labrun-zaber-{os.getpid()}-{id(self):x}"
        Path(self.path).unlink(missing_ok=True)
        Path(self.path).symlink_to(os.ttyname(self._slave))
        self._rest = b""

    def unplug(self):
        Path(self.path).unlink()
        master, self.master = self.master, None
        os.close(master)
        os.close(self._slave)

    def close(self):
        self._ends.set()
        self._thread.join(5)
        if self.master is not None:
            self.unplug()

    def mm(self, number):
        return self.axes[number].place * MICROSTEP_MM

    def stall(self, number):
        """What is in the way has stopped it."""
        axis = self.axes[number]
        axis.target, axis.speed, axis.homing = None, 0.0, False
        axis.flags |= {"FS"}

    def power_off(self):
        for axis in self.axes.values():
            axis.target, axis.speed, axis.homing, axis.flags = None, 0.0, False, {"WR"}

    def _run(self):
        before = time.monotonic()
        while not self._ends.is_set():
            with contextlib.suppress(OSError, TypeError, ValueError):
                if self.master is None:
                    time.sleep(0.002)
                elif select.select([self.master], [], [], 0.002)[0]:
                    self._take(os.read(self.master, 4096))
            now = time.monotonic()
            while before < now:
                step = min(0.002, now - before)
                before += step
                for axis in self.axes.values():
                    axis.drive(step)
            for axis in self.axes.values():
                if axis.target is not None:
                    axis.path.append((now, axis.place))

    def _take(self, data):
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            text = line.decode().strip()
            self.heard.append(text)
            if not self.mute:
                self._answer(text)

    def _answer(self, text):
        text, colon, check = text.partition(":")
        assert not colon or (sum(text[1:].encode()) + int(check, 16)) % 256 == 0
        device, number, message, command = COMMAND.match(text).groups()
        number = int(number or 0)
        devices = list(self.axes) if int(device or 0) == 0 else [int(device)]
        for address in devices:
            if address in self.axes:
                flag, data = self._does(self.axes[address], address, command.strip())
                self._say(address, number, message, flag, data)

    def _say(self, address, number, message, flag, data):
        axis = self.axes[address]
        state = "IDLE" if axis.target is None else "BUSY"
        warning = min(axis.flags, key=lambda flag: "FWN".index(flag[0]), default="--")
        words = f"{address:02d} {number}{' ' + message if message else ''} {flag} {state} {warning} {data}"
        check = -sum(words.encode()) % 256
        os.write(self.master, f"@{words}:{check:02X}\r\n".encode())

    def _does(self, axis, address, command):
        """What a command is answered with: OK or RJ, and data."""
        word, *rest = command.split() or [""]
        match [word, *rest]:
            case [""]:
                pass
            case ["get", setting]:
                known = {
                    "pos": round(axis.place), "maxspeed": axis.maxspeed, "accel": axis.accel,
                    "limit.min": 0, "limit.max": TRAVEL, "version": self.version,
                    "comm.packet.size.max": 80, "comm.word.size.max": 50, "comm.command.packets.max": 1,
                    "parking.state": int(axis.parked),
                }  # fmt: skip
                return ("OK", known[setting]) if setting in known else ("RJ", "BADCOMMAND")
            case ["warnings"] | ["warnings", "clear"]:
                told = " ".join([f"{len(axis.flags):02d}", *sorted(axis.flags)])
                if rest:
                    axis.flags -= {"FS", "FO", "NI"}
                return "OK", told
            case ["home"] | ["move", "abs", *_] if axis.parked:
                return "RJ", "PARKED"
            case ["home"] | ["move", "abs", *_] if axis.flags & {"FO"}:
                return "RJ", "DRIVERDISABLED"
            case ["home"]:
                axis.homing = True
                axis.send(0, axis.maxspeed, axis.accel)
            case ["move", "abs", place, *numbers]:
                rate, accel = [*map(int, numbers), axis.maxspeed, axis.accel][:2]
                if not 0 <= int(place) <= TRAVEL or not 0 < rate <= axis.maxspeed * 1.01:
                    return "RJ", "BADDATA"
                if axis.target is not None:
                    axis.flags |= {"NI"}
                else:
                    axis.flags -= {"NI"}
                axis.homing = False
                axis.send(int(place), rate, accel)
            case ["stop"]:
                axis.stop()
            case ["driver", "enable"]:
                axis.flags -= {"FO"}
            case ["tools", "parking", way]:
                axis.parked = way == "park"
            case ["io", "set", "do", pin, value]:
                self.pins[address, int(pin)] = int(value)
            case _:
                return "RJ", "BADCOMMAND"
        return "OK", 0


def config_of(peer, axes="xyz"):
    """What a lab says of it."""
    stages = {
        name: {"device": number, "microstep_um": MICROSTEP_MM * 1000}
        for number, name in enumerate(axes, 1)
    }
    return {"port": peer.path, "stages": stages, "silence_s": 60.0}  # a busy machine is no silence
