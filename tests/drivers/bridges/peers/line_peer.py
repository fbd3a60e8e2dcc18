"""An instrument of its own process: `python line_peer.py FOLDER HABITS.json`, over TCP, UDP or a pty.

It appends every real execution to FOLDER/done.jsonl and outlives whoever talks to it. Its habits
are those of real instruments: banner, echo, prompt, terminators, slow answers, units, other lines.
"""

import contextlib
import functools
import json
import operator
import os
import socket
import sys
import threading
import time
from pathlib import Path

HABITS = {
    "over": "tcp", "banner": "", "banner_s": 0.0, "echo": False, "echo_end": "", "prompt": "", "end": "\n",
    "unit": "", "chatter": "", "work_s": 0.0, "answer_s": 0.0, "idn": "ACME,DM-1,0042,1.0",
    "closes": False, "error_query": True, "checksum": False, "login": False, "deaf": 0, "noise": "",
    "help": False, "to_port": None,
}  # fmt: skip

HELP = b""":ABORt/nquery/
*IDN?/qonly/
:MEASure:VOLTage:DC?/qonly/
:VOLTage:RANGe
:SYSTem:ERRor?/qonly/
:OUTPut[:STATe]
"""


class Instrument:
    """What it is, apart from any connection."""

    def __init__(self, folder, habits):
        self.folder, self.habits = folder, {**HABITS, **habits}
        self.lock, self.aborted = threading.Lock(), threading.Event()
        self.errors, self.count, self.range, self.output, self.sweeping = [], 0, 10.0, False, None
        self.heard = 0
        self.done("on")

    def done(self, what, **more):
        with (self.folder / "done.jsonl").open("a", encoding="utf-8") as file:
            file.write(json.dumps({"done": what, **more}) + "\n")

    def answer(self, line):
        """The answer to a line, None for none; abort is heard while something else goes on."""
        name, _, given = line.strip().partition(" ")
        if name.upper() == "ABOR":
            self.aborted.set()
            return None
        with self.lock:
            time.sleep(self.habits["answer_s"])
            return self._perform(name.upper(), given.strip())

    def _perform(self, name, given):
        match name:
            case "*IDN?":
                return self.habits["idn"]
            case "EER?" if self.habits["error_query"]:  # as some supplies have it: its number alone
                return (self.errors.pop(0) if self.errors else "0").partition(",")[0]
            case "SYST:ERR?" if self.habits["error_query"]:
                return self.errors.pop(0) if self.errors else '0,"No error"'
            case "*OPC?":
                return self._sweep_over()
            case "MEAS:VOLT:DC?":
                unit = self.habits["unit"]
                return f"{1250 if unit.strip() == 'mV' else 1.25:+.4E}{unit}"
            case "VOLT:RANG":
                return self._set_range(given)
            case "VOLT:RANG?":
                return f"{self.range:g}"
            case "OUTP":
                self.output = given in ("1", "ON")
                self.done("output", on=self.output)
                return None
            case "OUTP?":
                return str(int(self.output))
            case "DISP":
                time.sleep(self.habits["work_s"])
                self.count += 1
                self.done("dispense", given=given)
                return None
            case "COUN?":
                return str(self.count)
            case "INIT":
                self.aborted.clear()
                self.sweeping = time.monotonic() + self.habits["work_s"]
                self.done("init")
                return None
            case "OVER?":
                return "+9.90000000E+37"
            case "NAN?":
                return "+9.91000000E+37"
            case "LIST?":
                return "1.0,2.5,-3E0"
            case "SYST:HELP:HEAD?" if self.habits["help"]:
                return b"#3%03d" % len(HELP) + HELP
            case "WORDS?":
                return '1.5,"none, or so",2'
            case "PAIR?":
                return "0.5,ON"
            case "CURV?":
                return b"#18" + bytes([0x3F, 0x80, 0, 0, 0x0A, 0x0D, 0, 0x23])
            case "GO":  # a line protocol: an answer at once, another when it is done
                return self._go(given)
        if self.habits["error_query"]:
            self.errors.append('-113,"Undefined header"')
            return None
        return "?1 unknown command"

    def _set_range(self, given):
        if not 0.1 <= float(given) <= 1000:
            self.errors.append('-222,"Data out of range"')
            return
        self.range = float(given)
        self.done("range", to=self.range)
        return

    def _sweep_over(self):
        if self.sweeping is not None:
            over = self.aborted.wait(max(0.0, self.sweeping - time.monotonic()))
            self.done("abort" if over else "sweep")
            self.sweeping = None
        return "1"

    def _go(self, given):
        if float(given) > 100:
            return "ERR JAMMED"
        self.count += 1
        self.done("go", given=given)
        return f"OK {self.count}" + self.habits["end"] + f"DONE at {given} mm"


class Link:
    """One connection: `write(bytes)` sends, `hear(bytes)` is what came."""

    def __init__(self, instrument, write):
        self.instrument, self.habits, self._write = instrument, instrument.habits, write
        self._left, self._queue, self._there = b"", [], threading.Event()
        threading.Thread(target=self._work, daemon=True).start()
        self._asked = ["login: ", "password: "] if self.habits["login"] else []
        if self._asked:
            self.write(self._asked[0].encode())
        time.sleep(self.habits["banner_s"])
        if self.habits["banner"]:
            self.say(self.habits["banner"])
        self.prompt()
        if self.habits["chatter"]:
            threading.Thread(target=self._chat, daemon=True).start()

    def say(self, text):
        for line in text.split(self.habits["end"]):
            sums = "*" + xor(line + self.habits["noise"]) if self.habits["checksum"] else ""
            self.write((line + sums).encode("latin-1") + self.habits["end"].encode())

    def write(self, data):
        with contextlib.suppress(OSError):  # nobody listens; what it has begun it still does
            self._write(data)

    def prompt(self):
        if self.habits["prompt"]:
            self.write(self.habits["prompt"].encode())

    def _chat(self):
        while True:
            self.say(self.habits["chatter"])
            time.sleep(0.05)

    def hear(self, data):
        *lines, self._left = (self._left + data).replace(b"\r", b"\n").split(b"\n")
        for line in filter(None, lines):
            text = line.decode("latin-1")
            if text.strip().upper() == "ABOR":
                self.instrument.answer(text)
            else:
                self._queue.append(text)
                self._there.set()

    def _work(self):
        while True:
            self._there.wait()
            self._there.clear()
            while self._queue:
                text = self._queue.pop(0)
                self.instrument.heard += 1
                if self.instrument.heard <= self.habits["deaf"]:
                    continue
                if self._asked:
                    self._enter(text)
                    continue
                if self.habits["echo"]:
                    self.write(
                        (text + (self.habits["echo_end"] or self.habits["end"])).encode("latin-1")
                    )
                if self.habits["checksum"]:
                    text, _, sums = text.rpartition("*")
                    if sums != xor(text):
                        self.say("?2 checksum")
                        continue
                answer = self.instrument.answer(text)
                if isinstance(answer, bytes):
                    self.write(answer + self.habits["end"].encode())
                elif answer is not None:
                    self.say(answer)
                self.prompt()

    def _enter(self, text):
        """Two questions without line ends, which are sent while it waits."""
        wanted = {"login: ": "lab", "password: ": "secret"}[self._asked.pop(0)]
        if text != wanted:
            self.say("go away")
            self._asked = ["login: ", "password: "]
        self.write(self._asked[0].encode() if self._asked else b"welcome\n")


def xor(text):
    """The bytes of a text, in exclusive or: two digits."""
    return f"{functools.reduce(operator.xor, text.encode('latin-1'), 0):02X}"


def over_tcp(instrument, port):
    listener = socket.create_server(("127.0.0.1", port))
    tell(instrument, f"127.0.0.1:{listener.getsockname()[1]}")
    while True:
        connection, _ = listener.accept()
        threading.Thread(target=serve, args=(instrument, connection), daemon=True).start()


def serve(instrument, connection):
    link = Link(instrument, connection.sendall)
    with connection:
        if instrument.habits["closes"]:
            connection.settimeout(0.4)
        while True:
            try:
                data = connection.recv(4096)
            except OSError:
                return
            if not data:
                return
            link.hear(data)


def over_udp(instrument, port):
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.bind(("127.0.0.1", port))
    tell(instrument, f"udp://127.0.0.1:{listener.getsockname()[1]}")
    links = {}
    while True:
        data, who = listener.recvfrom(4096)
        if who not in links:
            to = (who[0], instrument.habits["to_port"] or who[1])
            links[who] = Link(instrument, lambda out, to=to: listener.sendto(out, to))
        links[who].hear(data)


def over_pty(instrument, _):
    import tty  # Windows has none

    master, slave = os.openpty()
    tty.setraw(slave)
    link = Link(instrument, lambda data: os.write(master, data))
    tell(instrument, os.ttyname(slave))
    while True:
        link.hear(os.read(master, 4096))


def tell(instrument, where):
    half = instrument.folder / "where.part"
    half.write_text(where, encoding="utf-8")
    half.replace(instrument.folder / "where")


if __name__ == "__main__":
    folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
    there = Instrument(folder, habits)
    ways = {"tcp": over_tcp, "udp": over_udp, "pty": over_pty}
    ways[there.habits["over"]](there, int(habits.get("port", 0)))
