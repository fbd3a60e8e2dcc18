"""An instrument that speaks in frames of bytes: `python frame_peer.py FOLDER HABITS.json`, over TCP.

It begins with noise, sends in pieces, tells what nobody asked for, is busy, refuses, and drops a
connection in the middle of an answer. It appends every real execution to FOLDER/done.jsonl.
"""

import json
import socketserver
import struct
import sys
import threading
import time
from pathlib import Path

HABITS = {"work_s": 0.0, "event_s": 0.05, "cuts": 0}
STEP_S = 0.02


def crc(body):
    """CRC-16 of Modbus, low byte first."""
    left = 0xFFFF
    for byte in body:
        left ^= byte
        for _ in range(8):
            left = left >> 1 ^ (0xA001 if left & 1 else 0)
    return struct.pack("<H", left)


def frame(head, body):
    whole = bytes([len(body)]) + body
    return bytes([head]) + whole + crc(whole)


class Instrument:
    """What it is, apart from any connection."""

    def __init__(self, folder, habits):
        self.folder, self.habits = folder, {**HABITS, **habits}
        self.level, self.shots, self.answers = 0.0, 0, 0
        self.lock, self.halted = threading.Lock(), threading.Event()

    def done(self, what, **more):
        with (self.folder / "done.jsonl").open("a", encoding="utf-8") as file:
            file.write(json.dumps({"done": what, **more}) + "\n")

    def act(self, command, data):
        """Status and data of the answer to a command."""
        match command:
            case 0x10 if struct.unpack("<f", data)[0] > 55:
                return 1, b""
            case 0x10:
                (self.level,) = struct.unpack("<f", data)
                self.done("level", to=self.level)
                return 0, data
            case 0x11:
                return 0, struct.pack("<f", self.level)
            case 0x13 if not self.lock.acquire(blocking=False):
                return 2, b""
            case 0x13:
                self.halted.clear()
                halted = self.halted.wait(self.habits["work_s"])
                if not halted:
                    self.shots += 1
                    self.done("fire")
                self.lock.release()
                return (4 if halted else 0), b""
            case 0x12:
                return 0, struct.pack("<I", self.shots)
            case 0x14:
                self.halted.set()
                self.level = 0.0
                self.done("standby")
                return 0, b""
        return 9, b""


class Link(socketserver.StreamRequestHandler):
    """One connection."""

    def handle(self):
        self.there, self.sending = self.server.there, threading.Lock()
        self.wfile.write(b"\x00\x5a\x5a")
        threading.Thread(target=self.events, daemon=True).start()
        while len(head := self.rfile.read(2)) == 2:
            rest = self.rfile.read(head[1] + 2)
            body = head[1:] + rest[:-2]
            right = head[:1] == b"\xa5" and rest[-2:] == crc(body)
            threading.Thread(target=self.answer, args=(body[1:] if right else b"\0",)).start()

    def answer(self, body):
        status, data = self.there.act(body[0], body[1:])
        whole = frame(0x5A, bytes([body[0], status]) + data)
        self.there.answers += 1
        if self.there.answers == self.there.habits["cuts"]:
            self.send(whole[:3])
            self.connection.shutdown(2)
        else:
            self.send(whole)

    def events(self):
        while self.send(frame(0x5A, b"\xe0\x00" + struct.pack("<f", self.there.level))):
            time.sleep(self.there.habits["event_s"])

    def send(self, whole):
        """In two pieces; False if nobody listens, and what it has begun it still does."""
        try:
            with self.sending:
                self.wfile.write(whole[:3])
                time.sleep(STEP_S)
                self.wfile.write(whole[3:])
        except (OSError, ValueError):
            return False
        return True


class Server(socketserver.ThreadingTCPServer):
    """Connections that end with the process."""

    daemon_threads = True
    block_on_close = False


if __name__ == "__main__":
    folder, habits = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text("utf-8"))
    server = Server(("127.0.0.1", 0), Link)
    server.there = Instrument(folder, habits)
    server.there.done("on")
    half = folder / "where.part"
    half.write_text(f"127.0.0.1:{server.server_address[1]}", encoding="utf-8")
    half.replace(folder / "where")
    server.serve_forever()
