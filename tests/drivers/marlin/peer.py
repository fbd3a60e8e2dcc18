"""A Marlin on a pseudo-terminal, as its 2.0.9.7 and 2.1 (January 2023) were seen to behave.

Opening its port boots it, and what comes before its `start` is lost; it keeps four lines that
wait, no more; lines have numbers and checksums, and a wrong one is asked for again, but one that it
has had, 2.1 (`silent_on_repeats`) drops without a word; `ok` to a move
means that it is planned, and waits while sixteen are; M114 tells the end of what is planned, not
where the axes are; nothing is read while it homes or waits for standstill, except by an emergency
parser; after M112, or a homing that found no switch, it answers nothing until it is reset.
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
from collections import deque
from pathlib import Path

WORD = re.compile(r"([A-Z])(-?\d+(?:\.\d+)?)")
PLANNED, HELD_LINES = 16, 4
BOOT_S = 0.1  # a second or two on a real board
BUSY_S = 0.4  # 2.0 on the real one


class Peer:
    """Start it, give `path` to a driver, look at `stands` and `heard` afterwards."""

    def __init__(self, *, shift=0.0, speed=20.0, homing_s=0.2, emergency=True, boots_on_open=True):
        self.rates = [41.7 * speed, 41.7 * speed, 41.7 * speed]
        self.homing_s, self.emergency, self.boots_on_open = homing_s, emergency, boots_on_open
        self.place = [3.0, 4.0, 5.0]  # where it truly is
        self.offset = [-3.0, -4.0, -5.0]  # what it believes beside that
        self.shift = [
            0.0,
            0.0,
            0.0,
        ]  # the part of it that a G92 has made: its steps know nothing of it
        self.per_mm = [80.0, 80.0, 400.0]
        self.stands, self.heard = [], []
        self.surface = None
        self.homing_fails = False
        self.eats_ok_of = None
        self.silent_on_repeats = False
        self.oks_too_many = 0  # before its next answers to M114
        self.garbles = None  # a word: the next line with it arrives damaged
        self._ends = threading.Event()
        self.plug()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def plug(self):
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        self.path = getattr(self, "path", None) or f"/tmp/labrun-marlin-{os.getpid()}-{id(self):x}"
        Path(self.path).unlink(missing_ok=True)
        Path(self.path).symlink_to(os.ttyname(slave))
        os.close(slave)
        self._open = False
        self._reset()

    def unplug(self):
        Path(self.path).unlink()
        os.close(self.master)
        self.master = None

    def close(self):
        self._ends.set()
        self._thread.join(5)
        if self.master is not None:
            self.unplug()

    @property
    def move(self):
        """What it moves now; None if it stands."""
        return self.blocks[0] if self.blocks else None

    def _reset(self):
        self.blocks, self.lines, self.received = deque(), deque(), b""
        self.number, self.killed, self.relative, self.percent = 0, False, False, 100
        self.doing, self.said_busy, self.boots_until = None, 0.0, None
        self.told = [at + by for at, by in zip(self.place, self.offset, strict=True)]
        self.began = time.monotonic()

    def _run(self):
        while not self._ends.wait(0.003):
            with contextlib.suppress(OSError, TypeError, ValueError):
                self._look()

    def _look(self):
        if self.master is None:
            return
        poll = select.poll()
        poll.register(self.master, select.POLLIN | select.POLLHUP)
        events = dict(poll.poll(0)).get(self.master, 0)
        self._drive()
        if events & select.POLLHUP:
            self._open = False
        elif not self._open:
            self._open = True
            if self.boots_on_open:
                self._stand()
                self._reset()
                self.boots_until = time.monotonic() + BOOT_S
        if events & select.POLLIN:
            data = os.read(self.master, 4096)
            if self.boots_until is None:
                self._receive(data)
        if self.boots_until is not None and time.monotonic() >= self.boots_until:
            self.boots_until = None
            for line in ("start", "Marlin 2.0.9.7", "echo:; Linear Units:"):
                self.say(line)
        if not self.killed:
            self._work()

    def say(self, line):
        if not self.killed and self._open:
            os.write(self.master, line.encode() + b"\n")

    def _receive(self, data):
        *lines, self.received = (self.received + data).split(b"\n")
        for line in lines:
            text = line.decode().strip()
            self.heard.append(text)
            if self.garbles and self.garbles in text:
                self.garbles, text = None, text.replace("1", "7", 1)
            if self.emergency and text == "M112":
                self.say("Error:Printer halted. kill() called!")
                self._stand()
                self.killed = True
            elif len(self.lines) < HELD_LINES:
                self.lines.append(text)

    def _work(self):
        """The line under way, or the next ones."""
        if self.doing is not None:
            if not self.doing():
                if time.monotonic() - self.said_busy > BUSY_S:
                    self.said_busy = time.monotonic()
                    self.say("echo:busy: processing")
                return
            self.doing = None
            self._ok()
        while self.lines and self.doing is None and not self.killed:
            self._begin(self.lines.popleft())

    def _begin(self, text):
        if found := re.match(r"N(\d+) (.*)\*(\d+)$", text):
            number, check = int(found[1]), 0
            for byte in text[: text.rindex("*")].encode():
                check ^= byte
            if self.silent_on_repeats and number in (self.number - 1, self.number):
                return
            if check != int(found[3]) or number != self.number + 1:
                wrong = (
                    "Line Number is not Last Line Number+1"
                    if check == int(found[3])
                    else "checksum mismatch"
                )
                self.say(f"Error:{wrong}, Last Line: {self.number}")
                self.say(f"Resend: {self.number + 1}")
                self.say("ok")
                return
            self.number, text = number, found[2]
        self.line, self.said_busy = text, time.monotonic()
        self.doing = self._does(text)
        if self.doing is None:
            self._ok()
        elif self.doing():
            self.doing = None
            self._ok()

    def _ok(self):
        if self.eats_ok_of and self.eats_ok_of in self.line:
            self.eats_ok_of = None
        else:
            self.say("ok")

    def _does(self, text):
        """Carry out a line; what tells its end, where it takes a while."""
        code = re.match(r"\S\d*(?:\.\d+)?", text)[0]
        words = {name: float(value) for name, value in WORD.findall(text[len(code) :])}
        match code:
            case "G0" | "G1":
                base = self.told if self.relative else (0, 0, 0)
                end = [
                    self.told[i] if (w := words.get(a)) is None else base[i] + w
                    for i, a in enumerate("XYZ")
                ]
                speed = words.get("F", 0) / 60 * self.percent / 100

                def planned():
                    if len(self.blocks) >= PLANNED:
                        return False
                    self._plan(end, speed or math.inf)
                    return True

                return planned
            case "G28":
                self.lines_until = time.monotonic() + self.homing_s
                return self._homed
            case "G38.3":
                end = [
                    self.told[i] if (w := words.get(a)) is None else w for i, a in enumerate("XYZ")
                ]
                if self.surface is not None:
                    end[2] = max(end[2], self.surface)
                self._plan(end, words["F"] / 60)
                return lambda: not self.blocks
            case "M400":
                return lambda: not self.blocks
            case "M110":
                self.number = int(words.get("N", 0))
            case "M114":
                if self.oks_too_many:
                    self.oks_too_many -= 1
                    self.say("ok")
                    time.sleep(0.05)  # else both are read at once
                x, y, z = self.told
                a, b, c = (  # of what is planned, too
                    round((at - shift) * per_mm)
                    for at, shift, per_mm in zip(self.told, self.shift, self.per_mm, strict=True)
                )
                self.say(f"X:{x:.2f} Y:{y:.2f} Z:{z:.2f} E:0.00 Count X:{a} Y:{b} Z:{c}")
            case "M410":
                self.told = [p + by for p, by in zip(self.place, self.offset, strict=True)]
                self.blocks.clear()
            case "M92":
                self.per_mm = [
                    words.get(a, per_mm) for a, per_mm in zip("XYZ", self.per_mm, strict=True)
                ]
            case "G92":
                for i, axis in enumerate("XYZ"):
                    by = words.get(axis, self.told[i]) - self.told[i]
                    self.told[i], self.offset[i] = self.told[i] + by, self.offset[i] + by
                    self.shift[i] += by
            case "M115":
                self.say("FIRMWARE_NAME:Marlin 2.0.9.7 (test) PROTOCOL_VERSION:1.0")
                self.say(f"Cap:EMERGENCY_PARSER:{int(self.emergency)}")
            case "M503":
                x, y, z = self.rates
                a, b, c = self.per_mm
                self.say(f"echo:  M92 X{a:.2f} Y{b:.2f} Z{c:.2f} E500.00")
                self.say(f"echo:  M203 X{x:.2f} Y{y:.2f} Z{z:.2f} E25.00")
                self.say("echo:  M201 X3000.00 Y3000.00 Z3000.00 E10000.00")
                self.say("echo:  M204 P3000.00 R3000.00 T3000.00")
            case "M211":
                self.say("  M211 S1 ; ON")
                low, high = (
                    " ".join(
                        f"{a}{e + by:.2f}" for a, e, by in zip("XYZ", end, self.shift, strict=True)
                    )
                    for end in ((0, 0, 0), (200, 200, 100))
                )
                self.say(f"  Min:  {low}   Max:  {high}")
            case "M119":
                self.say("Reporting endstop status")
                self.say("x_min: open")
                self.say("z_max: TRIGGERED" if self.told[2] >= 100 else "z_max: open")
            case "M220":
                self.percent = words.get("S", self.percent)
                if "S" not in words:
                    self.say(f"FR:{self.percent:.0f}%")
            case "M118":
                self.say(text.partition(" ")[2])
            case "G90" | "G91":
                self.relative = code == "G91"
            case "M84" | "M3" | "M5":
                pass
            case _:
                self.say(f'echo:Unknown command: "{text}"')
        return None

    def _homed(self):
        if time.monotonic() < self.lines_until:
            return False
        if self.homing_fails:
            self.say("echo:Homing Failed")
            self.say("Error:Printer halted. kill() called!")
            self.killed = True
            return False
        self.place, self.offset, self.told = [0.0, 0.0, 100.0], [0.0] * 3, [0.0, 0.0, 100.0]
        self.shift = [0.0] * 3
        self.stands.append((time.time(), list(self.place)))
        return True

    def _plan(self, end, speed):
        start, self.told = self.told, end
        length = math.dist(start, end)
        if length:
            way = [(b - a) / length for a, b in zip(start, end, strict=True)]
            most = min(r / abs(w) for r, w in zip(self.rates, way, strict=True) if w)
            if not self.blocks:
                self.began = time.monotonic()
            self.blocks.append((start, end, length / min(speed, most)))

    def _drive(self):
        while self.blocks:
            start, end, seconds = self.blocks[0]
            part = min(1.0, (time.monotonic() - self.began) / seconds)
            at = [a + part * (b - a) for a, b in zip(start, end, strict=True)]
            self.place = [p - by for p, by in zip(at, self.offset, strict=True)]
            if part < 1.0:
                return
            self.blocks.popleft()
            self.began += seconds
            if not self.blocks:
                self._stand()

    def _stand(self):
        if self.blocks:
            self.blocks.clear()
        self.stands.append((time.time(), list(self.place)))
