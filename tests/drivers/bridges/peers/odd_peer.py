"""Instruments with habits of their own, each in a process of its own: `{"kind": "gauge"}`.

A gauge that is asked to hand out what it has acknowledged; a controller whose frames have no line
ends; a pump whose prompt says how it stands; a weather station that answers in several lines; a chiller
that writes tenths, bits and nothing at the end; a spectrometer that sends tables and bare binary data.
"""

import contextlib
import functools
import json
import operator
import socket
import struct
import sys
import threading
import time
from pathlib import Path

from bus_instruments import INSTRUMENTS


class Gauge:
    """`PR1` is acknowledged; ENQ fetches what it measured. The manual's own order, or nothing."""

    end = b"\r\n"
    asked = None

    def hears(self, line):
        if line == b"\x05":
            return b"0,+1.2300E-03\r\n" if self.asked == b"PR1" else b"\x15\r\n"
        self.asked = line
        if line.startswith(b"SP1,"):
            done("set", to=line[4:].decode())
        return b"\x06\r\n" if line == b"PR1" or line.startswith(b"SP1,") else b"\x15\r\n"


class Controller:
    """STX, name, value, ETX, check byte; EOT name ENQ asks; ACK or NAK is one byte."""

    end = b""

    def __init__(self):
        self.setting = 20.0

    def frames(self, data):
        while data:
            size = data.find(b"\x05") + 1 if data[:1] == b"\x04" else data.find(b"\x03") + 2
            if size < 2 or len(data) < size:
                return data
            yield data[:size]
            data = data[size:]
        return b""

    def hears(self, frame):
        if frame[:1] == b"\x04":
            body = b"%s%05.1f\x03" % (frame[1:3], 21.4 if frame[1:3] == b"PV" else self.setting)
            return b"\x02" + body + check(body)
        name, value, right = frame[1:3], frame[3:-2], check(frame[1:-1]) == frame[-1:]
        if not right or name != b"SP" or float(value) > 300:
            return b"\x15"
        self.setting = float(value)
        done("set", to=self.setting)
        return b"\x06"


class Pump:
    """Echoes nothing; its prompt is `:` at rest, `>` while it runs, `T*` when it has stalled."""

    end = b"\r"

    def __init__(self):
        self.prompt = b":"

    def hears(self, line):
        told = []
        match line.split():
            case [b"run"]:
                self.prompt = b">"
                done("run")
            case [b"stop"]:
                self.prompt = b":"
            case [b"block"]:
                self.prompt = b"T*"
            case [b"rate"]:
                told = [b"0.5 ml/min"]
            case [b"diag"]:
                told = [b"volume 1.25 ml", b"time 90 s"]
            case []:
                pass
            case _:
                told = [b"Unknown command"]
        return b"".join(b"\n" + one + b"\r" for one in told) + b"\n" + self.prompt


class Station:
    """Answers in lines, the last of which says END; sends lines of its own in between."""

    end = b"\n"

    def hears(self, line):
        if line == b"ALL":
            return b"TEMP 21.5 C\n!wind\nHUM 40 %\nWIND 3.5 m/s\nEND\n"
        if line == b"LOG":
            return b"0;21.5\n60;21.6\n120;21.9\nEND\n"
        return b"?\n"


class Chiller:
    """Tenths, a status in hexadecimal, no line end in its answers, errors until they are asked for."""

    end = b"\r"

    def __init__(self):
        self.target, self.error = 200, "E00"

    def hears(self, line):
        match line[:2], line[2:]:
            case b"RT", _:
                return b"%04d" % self.target
            case b"ST", _:
                return b"2A"
            case b"MO", _:
                return b"F2"
            case b"SM", mode:
                done("mode", to=mode.decode())
            case b"WT", given if given.isdigit() and int(given) <= 500:
                self.target = int(given)
                done("target", to=self.target)
            case b"WT", _:
                self.error = "E07"
            case b"ER", _:
                told, self.error = self.error, "E00"
                return told.encode()
        return b""


class Spectrometer:
    """A table of two columns, and the same counts as they lie in its memory."""

    end = b"\n"

    def hears(self, line):
        if line == b"SPEC?":
            return b"400.0\t12\n400.5\t15\n401.0\t13\n.\n"
        return struct.pack("<4H", 10, 2570, 13, 65535)


class Potentiostat:
    """Takes a script; two lines of its own, then rows of packed numbers with prefixes."""

    end = b"\n\n"

    def hears(self, script):
        done("script", lines=script.count(b"\n") + 1)
        return b"e\nM0000\nPda7FFFE0Cm;ba80004D2n\nPda8000000m;ba8000006u\n*\n\n"


class Keyed:
    """Each connection has a key, and no command goes without it; blocks begin with their length."""

    end = b"\r"
    keys = 0

    def hears(self, line):
        if line == b"HELLO":
            self.keys += 1
            return b"KEY K%d\r" % self.keys
        key, _, command = line.partition(b";")
        if key != b"K%d" % self.keys:
            return b"ERR KEY\r"
        if command.startswith(b"DOSE"):
            done("dose", key=key.decode())
            return b"OK\r"
        if command == b"TRACE?":
            return struct.pack("<I3f", 12, 0.5, -1.25, 0.125)
        return b"21.5\r" if command == b"T?" else b"ERR COMMAND\r"


class Vessel(Keyed):
    """A key is good for two commands."""

    left = 0

    def hears(self, line):
        self.left = 3 if line == b"HELLO" else self.left
        self.left -= 1
        return super().hears(line) if self.left >= 0 else b"ERR KEY\r"


OWN = (Gauge, Controller, Pump, Station, Chiller, Spectrometer, Potentiostat, Keyed, Vessel)
KINDS = {one.__name__.lower(): one for one in (*OWN, *INSTRUMENTS)}


def check(body):
    return bytes([functools.reduce(operator.xor, body, 0)])


def done(what, **more):
    with (FOLDER / "done.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps({"done": what, **more}) + "\n")


def frames(there, data):
    """Whole lines or frames of what has come, and what is left of it."""
    if not getattr(there, "end", b""):
        left = data
        size = 0
        for frame in there.frames(data):
            size += len(frame)
            yield frame
        return left[size:]
    *lines, left = data.split(there.end)
    yield from (line.strip(b"\n") for line in lines)
    return left


@contextlib.contextmanager
def alone(there):
    """On one line nobody asks while another is answered; who does is written down."""
    there.asking = getattr(there, "asking", 0) + 1
    if there.asking > 1:
        done("collision")
    try:
        yield
    finally:
        there.asking -= 1


def chat(connection, line):
    with contextlib.suppress(OSError):
        while True:
            connection.sendall(line)
            time.sleep(0.03)


def serve(connection, there, lock):
    left = b""
    with connection:
        connection.sendall(getattr(there, "greets", b""))
        if chatter := getattr(there, "chatter", b""):
            threading.Thread(target=chat, args=(connection, chatter), daemon=True).start()
        while data := connection.recv(4096):
            whole = frames(there, left + data)
            while True:
                try:
                    frame = next(whole)
                except StopIteration as end:
                    left = end.value
                    break
                with alone(there), lock:
                    time.sleep(getattr(there, "takes_s", 0))
                    told = there.hears(frame)
                connection.sendall(told)


if __name__ == "__main__":
    FOLDER = Path(sys.argv[1])
    there, lock = (
        KINDS[json.loads(Path(sys.argv[2]).read_text("utf-8"))["kind"]](),
        threading.Lock(),
    )
    done("on")
    there.done = done
    listener = socket.create_server(("127.0.0.1", 0))
    half = FOLDER / "where.part"
    half.write_text(f"127.0.0.1:{listener.getsockname()[1]}", encoding="utf-8")
    half.replace(FOLDER / "where")
    while True:
        connection, _ = listener.accept()
        threading.Thread(target=serve, args=(connection, there, lock), daemon=True).start()
