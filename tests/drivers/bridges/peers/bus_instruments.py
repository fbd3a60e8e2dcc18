"""Instruments of real protocols, by their manuals: binary frames, escapes, addresses, JSON, odd numbers.

`done` is set by whoever runs them.
"""

import binascii
import functools
import json
import operator
import re
import struct


def xor(data):
    return functools.reduce(operator.xor, data, 0)


class Stepper:
    """Trinamic's TMCL: nine bytes there and back, the last is their sum; status 100 is good."""

    at = 1200

    def frames(self, data):
        for start in range(0, len(data) - 8, 9):
            yield data[start : start + 9]

    def hears(self, frame):
        module, command, kind, _, value = struct.unpack(">BBBBi", frame[:8])
        status, told = 100, value
        if sum(frame[:8]) % 256 != frame[8]:
            status = 1
        elif command == 4 and abs(value) > 100000:
            status = 4
        elif command == 4:
            self.at = value
            self.done("move", to=value)
        elif command == 6:
            told = self.at if kind == 1 else 1
        answer = struct.pack(">BBBBi", 2, module, status, command, told)
        return answer + bytes([sum(answer) % 256])


class Bath:
    """Huber's PB commands: hundredths of a degree in hexadecimal, below zero as two's complement."""

    end = b"\r\n"
    set_point = b"07D0"

    def hears(self, line):
        if line == b"{M01****":
            return b"{S01F0D8\r\n"
        if line.startswith(b"{M00") and line != b"{M00****":
            self.set_point = line[4:]
            self.done("set", to=line[4:].decode())
        return b"{S00" + self.set_point + b"\r\n" if line.startswith(b"{M00") else b""


class Gauges:
    """Two of Pfeiffer's on one RS-485 line: address, action, parameter, length, data, sum; else silence."""

    end = b"\r"
    takes_s = 0.02

    def hears(self, line):
        if b"%03d" % (sum(line[:-3]) % 256) != line[-3:]:
            return b""
        address, action, parameter = line[:3], line[3:5], line[5:8]
        if address not in (b"001", b"002"):
            return b""
        data = line[10:-3]
        if parameter == b"740":
            data = b"100023" if address == b"001" else b"432110"
        elif parameter == b"041" and action == b"10":
            self.done("switch", address=address.decode(), to=data.decode())
        else:
            data = b"NO_DEF"
        told = address + b"10" + parameter + b"%02d" % len(data) + data
        return told + b"%03d" % (sum(told) % 256) + b"\r"


class IonPump:
    """Agilent's window protocol: STX, 80, window, 0 or 1, data, ETX, XOR in hexadecimal."""

    def frames(self, data):
        while (size := data.find(b"\x03") + 3) > 2 and len(data) >= size:
            yield data[:size]
            data = data[size:]

    def hears(self, frame):
        body, check = frame[1:-2], frame[-2:]
        if b"%02X" % xor(body) != check:
            return self.told(b"\x15")
        match body[1:4], body[4:5]:
            case b"812", b"0":
                return self.told(b"8120" + b"4.3E-08")
            case b"011", b"1":
                self.done("hv", to=body[5:-1].decode())
                return self.told(b"\x06")
            case _:
                return self.told(b"\x32")

    def told(self, data):
        body = b"\x80" + data + b"\x03"
        return b"\x02" + body + b"%02X" % xor(body)


class Manometer:
    """MKS's: no line ends, but `;FF`; refusals have numbers."""

    def frames(self, data):
        while (size := data.find(b";FF") + 3) > 2:
            yield data[:size]
            data = data[size:]

    def hears(self, frame):
        if frame == b"@253PR1?;FF":
            return b"@253ACK7.602E+2;FF"
        if found := re.fullmatch(rb"@253SP1!(.*);FF", frame):
            self.done("set", to=found[1].decode())
            return b"@253ACK" + found[1] + b";FF"
        return b"@253NAK160;FF"


class Syringe:
    """Cavro's and Hamilton's data terminal protocol: a status byte, whose bit 5 says that it is ready."""

    end = b"\r"
    busy, at = 0, 0

    def hears(self, line):
        error, data = 0, b""
        if line == b"/1Q":
            self.busy = max(0, self.busy - 1)
        elif line == b"/1?":
            data = b"%d" % self.at
        elif found := re.fullmatch(rb"/1A(\d+)R", line):
            if int(found[1]) > 3000:
                error = 3
            else:
                self.at, self.busy = int(found[1]), 3
                self.done("move", to=self.at)
        else:
            error = 2
        status = 0x40 | (0x20 if not self.busy else 0) | error
        return b"\xff/0" + bytes([status]) + data + b"\x03\r\n"


class Flow:
    """Sensirion's SHDLC: 7E at both ends, four bytes escaped, the inverted sum, floats."""

    escapes = ((0x7D, b"\x7d\x5d"), (0x7E, b"\x7d\x5e"), (0x11, b"\x7d\x31"), (0x13, b"\x7d\x33"))

    def frames(self, data):
        while (size := data.find(b"\x7e", 1) + 1) > 0:
            yield data[:size]
            data = data[size:]

    def hears(self, frame):
        plain = frame.strip(b"\x7e")
        for sign, instead in reversed(self.escapes):
            plain = plain.replace(instead, bytes([sign]))
        address, command, _, *data = plain[:-1]
        if 255 - sum(plain[:-1]) % 256 != plain[-1]:
            return b""
        told, state = b"", 0
        if command == 0x08:
            told = struct.pack(">f", 17.0) + b"\x7e\x7d\x11\x13"
        elif command == 0x00 and struct.unpack(">f", bytes(data[1:]))[0] <= 100:
            self.done("set", to=struct.unpack(">f", bytes(data[1:]))[0])
        else:
            state = 0x04
        told = bytes([address, command, state, len(told)]) + told
        told += bytes([255 - sum(told) % 256])
        for sign, instead in self.escapes:
            told = told.replace(bytes([sign]), instead)
        return b"\x7e" + told + b"\x7e"


class Stage:
    """Thorlabs' APT: six bytes, and more where the fifth says so; says by itself that it has arrived."""

    at = 2626

    def frames(self, data):
        while len(data) >= 6:
            size = 6 + (struct.unpack("<H", data[2:4])[0] if data[4] & 0x80 else 0)
            yield data[:size]
            data = data[size:]

    def hears(self, frame):
        match struct.unpack("<H", frame[:2])[0]:
            case 0x0411:
                return b"\x12\x04\x06\x00\x81\x50\x01\x00" + struct.pack("<i", self.at)
            case 0x0453:
                self.at = struct.unpack("<i", frame[8:12])[0]
                self.done("move", to=self.at)
                more = struct.pack("<iHHI", self.at, 0, 0, 0x0A0D20)
                return b"\x64\x04\x0e\x00\x81\x50\x01\x00" + more
        return b""


class Sketch:
    """An Arduino that says what it does: a boot banner, JSON lines, and lines for people in between."""

    end = b"\n"
    greets = b"\x00\x00ets Jan  8 2013,rst cause:2\r\n{boot: garbage\r\nheater 2.1 ready\r\n"
    target = 20.0

    def hears(self, line):
        asked = json.loads(line)
        if asked["cmd"] == "read":
            told = {"ok": True, "probes": [{"t": 21.5}, {"t": None}], "fan": "on"}
        elif asked["cmd"] == "heat" and asked["to"] <= 90:
            self.target = asked["to"]
            self.done("heat", to=self.target)
            told = {"ok": True}
        else:
            told = {"ok": False, "error": "too hot"}
        return b"[log] heard you\r\n" + json.dumps(told).encode() + b"\r\n"


class Service:
    """JSON, each message after its length in four bytes; it answers in pieces."""

    def frames(self, data):
        while len(data) >= 4 and len(data) >= 4 + (size := struct.unpack(">I", data[:4])[0]):
            yield data[: 4 + size]
            data = data[4 + size :]

    def hears(self, frame):
        asked = json.loads(frame[4:])
        told = {"result": {"x": 1.25, "y": [0.5, 1.5]}, "status": 0}
        if asked["method"] == "sweep":
            self.done("sweep", points=asked["params"]["points"])
        elif asked["method"] != "demod":
            told = {"status": 7, "message": "unknown method"}
        text = json.dumps(told).encode()
        return struct.pack(">I", len(text)) + text


class Acquisition:
    """openDAQ's: first the inverted sum in two bytes, then command, length, data, highest byte first."""

    def frames(self, data):
        while len(data) >= 4 and len(data) >= 4 + data[3]:
            yield data[: 4 + data[3]]
            data = data[4 + data[3] :]

    def hears(self, frame):
        if struct.pack(">H", ~sum(frame[2:]) & 0xFFFF) != frame[:2]:
            return b"\x00\xa0\xa0\x00"
        command, data = frame[2], frame[4:]
        if command == 24:
            self.done("out", to=struct.unpack(">h", data)[0])
        body = bytes([command, 2]) + (data if command == 24 else struct.pack(">h", -1300))
        return struct.pack(">H", ~sum(body) & 0xFFFF) + body


class Controller485:
    """Bronkhorst's ProPar in ASCII: hexadecimal, a float as its bytes, a status after a setting."""

    end = b"\r\n"

    def hears(self, line):
        if line == b":06030421402140":
            return b":0803022140" + binascii.hexlify(struct.pack(">f", 12.5)).upper() + b"\r\n"
        if line.startswith(b":0603010121"):
            self.done("set", to=int(line[11:], 16))
            return b":0403000005\r\n"
        return b":0403000404\r\n"


class Peristaltic:
    """Ismatec's: `*` without a line end for done, `#` for refused, a flow rate as mantissa and power."""

    end = b"\r"
    rate = b"1500-1"

    def hears(self, line):
        if line == b"1f":
            return self.rate + b"\r\n"
        if found := re.fullmatch(rb"1f(\d{4}[+-]\d)", line):
            self.rate = found[1]
            self.done("rate", to=self.rate.decode())
            return b"*"
        return b"^U1|overheated\r\n#"


class Dosing:
    """A5, its number, a length, a code, BCD or three bytes with a sign, two's complement of the sum."""

    rate, level = 1250, 0

    def frames(self, data):
        while len(data) > 3 and len(data) >= data[2] + 4:
            yield data[: data[2] + 4]
            data = data[data[2] + 4 :]

    def hears(self, frame):
        number, code, given, status, told = frame[1], frame[3], frame[4:-1], 0, b""
        if sum(frame[1:]) % 256:
            status = 0x16
        elif code == 1:
            told = bytes.fromhex(f"{self.rate:06d}")
        elif code == 2:
            self.rate = int(given.hex())
            self.done("rate", to=self.rate)
        elif code == 3 and abs(nl := int.from_bytes(given, "big", signed=True)) <= 500_000:
            self.level -= nl
            self.done("dose", nl=nl)
        elif code == 4:
            told = self.level.to_bytes(3, "big", signed=True)
        else:
            status = 0x15
        body = bytes([number | 0x80, len(told) + 1, status]) + told
        return b"\xa5" + body + bytes([-sum(body) % 256])


class Thermostat:
    """Repeats each line with CR and LF, and begins its answer in the same line or in the next."""

    end = b"\r"

    def hears(self, line):
        if line == b"PV?":
            return b"PV?+021.37 C\r\n"
        if not line.startswith(b"SP=") or float(line[3:]) > 200:
            return line + b"\r\n?RANGE\r\n"
        self.done("set", to=line[3:].decode())
        return line + b"\r\nOK\r\n"


class Mixer:
    """Says by itself what goes on, and never stops; a table, blanks between values, JSON in lines."""

    end = b"\n"
    chatter = b"*17 F=12.5 P=1.013 bar\r\n"

    def hears(self, line):
        match line.split():
            case [b"SET", _, to]:
                self.done("set", to=to.decode())
                return b"NAK\r\n" if float(to) > 500 else b""
            case [b"ALL"]:
                return b"BEGIN\r\nCH1 12.50 ml/min\r\n!ALARM 3\r\nCH2 0.50 ml/min\r\nEND\r\n"
            case [b"AIR"]:
                return b"21.5\t40  1013\r\n"
            case [b"JSON"]:
                return b'{\r\n "t": 21.5,\r\n "of": [\r\n  {"n": 1},\r\n  {"n": 2}\r\n ]\r\n}\r\n'
        return b"#1x\r\n"


class Weather:
    """Lufft's UMB: lengths, X.25's check without its inversion, an EOT behind it; one answer is damaged."""

    heard = 0

    def frames(self, data):
        while len(data) >= 7 and len(data) >= data[6] + 12:
            yield data[: data[6] + 12]
            data = data[data[6] + 12 :]

    def hears(self, frame):
        if self.summed(frame[:-3]) != frame:
            return b""
        self.heard += 1
        channel = frame[10:12]
        known = {100: 21.37, 200: 45.25}.get(int.from_bytes(channel, "little"))
        told = b"\x24" + channel
        if known is not None:
            told = b"\0" + channel + b"\x16" + struct.pack("<f", known)
        body = b"\x01\x10" + frame[4:6] + frame[2:4] + bytes([len(told) + 2])
        body += b"\x02\x23\x10" + told + b"\x03"
        whole = self.summed(body)
        return whole.replace(b"\x16", b"\x17") if self.heard == 1 else whole

    @staticmethod
    def summed(body):
        crc = 0xFFFF
        for byte in body:
            crc ^= byte
            for _ in range(8):
                crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
        return body + struct.pack("<H", crc) + b"\x04"


class Plc:
    """Omron's FINS by TCP: a handshake, words of the area DM; a float has its lowest word first."""

    level = b"\x00\x00\x41\xac"

    def frames(self, data):
        while len(data) >= 8 and len(data) >= 8 + (size := struct.unpack(">I", data[4:8])[0]):
            yield data[: 8 + size]
            data = data[8 + size :]

    def hears(self, frame):
        asked = frame[16:]
        if frame[11] == 0:
            body = struct.pack(">IIII", 1, 0, 10, 1)
        else:
            body = b"\0\0\0\x02\0\0\0\0\xc0\0\x02" + asked[6:9] + asked[3:6] + asked[9:12]
            body += b"\x11\x01" if asked[12] != 0x82 else b"\0\0"
            if asked[10:13] == b"\x01\x02\x82":
                self.level = asked[18:]
                self.done("fill", to=self.level.hex())
            elif asked[12] == 0x82:
                body += self.level
        return b"FINS" + struct.pack(">I", len(body)) + body


INSTRUMENTS = (
    Stepper, Bath, Gauges, IonPump, Manometer, Syringe, Flow, Stage, Sketch, Service, Acquisition,
    Controller485, Peristaltic, Dosing, Thermostat, Mixer, Weather, Plc,
)  # fmt: skip
