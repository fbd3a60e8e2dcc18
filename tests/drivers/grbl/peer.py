"""A GRBL controller on a pseudo-terminal, as measured on the real firmware.

`ok` means queued; opening boots it and what comes before the banner is lost; a receive buffer of
128 bytes overruns silently; `?` overtakes lines; `G4 P0` is answered when all motion has ended; an
alarm says nothing more until a reset, and one that comes too early is swallowed. It runs in a
thread, `speed` times faster than the real one, and remembers where the axes truly were and when.
"""

import contextlib
import math
import os
import pty
import re
import select
import termios
import threading
import time
import tty
from collections import deque
from pathlib import Path

from labrun.drivers.simulated.twins.axis import Move

SETTINGS = {
    0: 10, 10: 1, 13: 0, 20: 0, 21: 1, 22: 1, 23: 3, 27: 5.0, 32: 0,
    100: 199.1, 101: 199.1, 102: 199.1, 110: 2500.0, 111: 2500.0, 112: 2500.0,
    120: 150.0, 121: 150.0, 122: 150.0, 130: 810.0, 131: 730.0, 132: 90.0,
}  # fmt: skip
BOOT_S, SWALLOW_S = 1.2, 0.5
PREPARED_S = 0.06  # of the way is out of the planner, in six segments that nothing changes any more
RX, PLANNER = 128, 15
HAL_SAYS = (
    "AXS:3:XYZ", "NEWOPT:ENUMS,RT+,HOME,TC,SED", "FIRMWARE:grblHAL", "SIGNALS:D",
    "NVS STORAGE:*EEPROM", "DRIVER:Simulator", "DRIVER VERSION:260324",
)  # fmt: skip
AXES = "XYZ"


class Peer:
    """Start it, give `path` to a driver, look at `truth` afterwards."""

    def __init__(
        self,
        *,
        speed=20.0,
        hal=False,
        fluid=False,
        tells_late=False,
        homes_at=(0.0, 0.0, 0.0),
        boots_on_open=True,
        noise=None,
        settings=None,
        homing_s=None,
    ):
        self.speed = speed
        self.hal = hal
        self.fluid = fluid
        self.tells_late = tells_late  # that it is not homed: not before it is asked something
        self._untold = False
        self.boots_on_open = boots_on_open
        self.noise = noise  # bytes put in front of every third line that it says
        self.settings = {**SETTINGS, **(settings or {})}
        self.homing_s = 0.3 * speed if homing_s is None else homing_s  # 16.6 on the real one
        self.steps = [0, 0, 0]
        self.heard = []  # every line and real-time byte, in order
        self.motions = []  # (begin, end) of each stretch of motion, wall clock
        self.stands = []  # (wall clock, true position) after each stretch
        self.overrun = 0
        self.hit_at = None  # machine X at which a limit switch is hit
        self.runs_dry_at = (
            None  # machine X at which its step buffer is empty: Idle, short of its end
        )
        self.held_late = False  # its hold button is pressed in the last moment of the next move
        self.silent = False
        self.homing_fails = (
            0  # 9: it finds no switch along one and a half times its travel; 8: stuck
        )
        self.aborts_as = 6  # by a reset as it homes; 8 while it leaves its switch
        self.eats_ok_of = None  # a line whose next `ok` is lost
        self.refuses = {}  # line -> the error that it answers instead of obeying
        self.reset_at = None  # machine X at which its reset button is pressed, and held
        self.reset_pressed = False  # grblHAL is not unlocked meanwhile
        self.emergency = False  # pressed; grblHAL obeys no reset as long as it is
        self.startup = []  # what its start-up lines say, after a boot and after homing
        self.zero_where_homed = False  # built with HOMING_FORCE_SET_ORIGIN
        self.homes_at = homes_at  # FluidNC's mpos_mm: from there each axis has its travel
        self.offset = [0.0, 0.0, 0.0]
        self.surface = None  # machine Z at which the probe touches
        self.probes_half = False  # it ends half way, as real firmware whose step buffer ran dry
        self.feed = self.rapid = 100
        self.loop_s = 0.002  # how long it may be until its loop comes round to a flag
        self.outputs = set()
        self.buttons = ""  # of its own: R, H, S
        self.garbles = []  # (what, by what noise makes of it) in its next line that has it
        self._said = 0
        self._flagged = {}
        self.loses_questions = 0  # so many `?` from now on are eaten by noise
        self._late_banner = False
        self._ends = threading.Event()
        self.plug()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    # -- the cable ----------------------------------------------------------------------------

    def plug(self):
        """Put a pseudo-terminal there; `path` stays the same."""
        self.master, slave = pty.openpty()
        tty.setraw(slave)
        name = os.ttyname(slave)
        self.path = getattr(self, "path", None) or f"/tmp/labrun-grbl-{os.getpid()}-{id(self):x}"
        Path(self.path).unlink(missing_ok=True)
        Path(self.path).symlink_to(name)
        os.close(slave)
        self._open = False
        self._power_on(silently=True)

    def unplug(self):
        """Pull the cable: the port's file goes, and reading fails."""
        Path(self.path).unlink()
        os.close(self.master)
        self.master = None

    def close(self):
        self._ends.set()
        self._thread.join(5)
        if self.master is not None:
            self.unplug()

    # -- time and place -----------------------------------------------------------------------

    def now(self):
        return time.monotonic() * self.speed

    @property
    def place(self):
        """Where the axes truly are, mm in machine coordinates."""
        return [steps / self.settings[100 + i] for i, steps in enumerate(self.steps)]

    def moving_at(self, wall):
        return any(begin < wall < end for begin, end in self.motions)

    def stood_at(self, wall):
        """The true place at a moment when it stood."""
        return [place for at, place in self.stands if at <= wall][-1]

    # -- life ---------------------------------------------------------------------------------

    def _power_on(self, *, silently=False):
        self.state = "Idle" if self.hal or not int(self.settings[22]) else "Alarm"
        if not silently:
            self.steps = [0, 0, 0]
        self._clear()
        self._ready_at = math.inf if silently else self.now() + BOOT_S

    def _clear(self):
        self.outputs = set()
        self.rx = deque()
        self.line = b""
        self.queue = deque()
        self.block = None
        self.move = None
        self.hold = None
        self.dead_at = None
        self.reset_allowed = False
        self.wco_in = 0
        self.homing_until = None
        self.target = list(self.steps)
        self._braking = None
        self._ends_held = False
        self._soft_trip = None
        self._dry = False
        self._answer_later = None

    def _run(self):
        while not self._ends.is_set():
            master = self.master
            if master is None:
                time.sleep(0.005)
                continue
            poll = select.poll()
            poll.register(master, select.POLLIN)
            flags = dict(poll.poll(1)).get(master, 0)
            up = not flags & (select.POLLHUP | select.POLLERR | select.POLLNVAL)
            if up and not self._open:
                self._opened()
            self._open = up
            if flags & select.POLLIN:  # also what was sent before the port was closed
                with contextlib.suppress(OSError):
                    self._receive(os.read(master, 4096))
            elif not up:
                time.sleep(0.001)
            self._live()

    def _opened(self):
        if self.boots_on_open:
            self._power_on()
        else:
            self._ready_at = min(self._ready_at, self.now())

    def _garbled(self):
        """Whether the other side speaks at another rate."""
        with contextlib.suppress(termios.error, OSError, TypeError):
            return termios.tcgetattr(self.master)[5] != termios.B115200
        return False

    def _live(self):
        """Let time pass: boot, homing, motion, the end of an alarm's half second."""
        now = self.now()
        if self._ready_at <= now and self._ready_at:
            self._ready_at = 0
            if self.boots_on_open or self._late_banner:
                powered, self._late_banner = not self._late_banner, False
                self._banner(powered=powered)
        if self._ready_at:
            return
        if self.dead_at is not None and not self.reset_allowed and now >= self.dead_at + SWALLOW_S:
            self.say("[MSG:Emergency stop]" if self.emergency else "[MSG:Reset to continue]")
            self.reset_allowed = True
        if self.homing_until is not None and now >= self.homing_until:
            self._homed()
        self._drive(now)
        self._parse()

    def _banner(self, *, powered=False):
        hint = "'$' or '$HELP'" if self.hal else "'$'"
        if self.fluid:
            self.say("\r\nGrbl 4.0 [FluidNC v4.0.5 (wifi) '$' for help]")
        else:
            self.say(f"\r\n{'GrblHAL 1.1f' if self.hal else 'Grbl 1.1h'} [{hint} for help]")
        if self.state == "Alarm" and self.fluid:
            self._untold = powered
            if not self.tells_late:
                self._tell_unhomed()
        elif self.state == "Alarm":
            self.say("[MSG:'$H'|'$X' to unlock]")
        else:
            self._start_up()

    def _tell_unhomed(self):
        if self._untold:
            self.say("[MSG:INFO: ALARM: Unhomed]")
            self.say("ALARM:14")
        self._untold = False

    def _start_up(self):
        for words in self.startup:
            self.say(words)

    def say(self, text):
        if self.silent or self.master is None:
            return
        if self.fluid and text.startswith("ALARM:"):
            self.say("[MSG:INFO: ALARM: in words]")
        for what, noise in self.garbles[:1]:
            if what in text:
                text = text.replace(what, noise)
                del self.garbles[0]
        data = text.encode() + b"\r\n"
        self._said += 1
        if self.noise and self._said % 3 == 0:
            data = self.noise + data
        if self._garbled():
            data = bytes((byte * 7 + 131) & 0xFF | 0x80 for byte in data)
        if self.fluid and text.startswith("error:"):
            data += b"[MSG:ERR: in words]\r\n"
        with contextlib.suppress(OSError, TypeError):
            os.write(self.master, data)

    # -- receiving ----------------------------------------------------------------------------

    def _receive(self, data):
        if self._ready_at or self.silent or self._garbled():
            return  # it boots, hangs, or hears nothing but noise
        if self.fluid:  # bytes above 127 are UTF-8, and nothing where they are not
            data = data.decode("utf-8", "ignore").encode("latin-1", "ignore")
        for value in data:
            byte = bytes([value])
            if byte in b"?!~\x18\x84\x85\x90\x91\x92\x93\x94\x95\x96\x97":
                self._at_once(byte)
            elif self.dead_at is None:
                if len(self.rx) >= RX:
                    self.overrun += 1
                else:
                    self.rx.append(value)

    def _at_once(self, byte):
        value = byte[0]
        self.heard.append({b"?": "?", b"!": "!", b"~": "~"}.get(byte, byte.hex()))
        if byte == b"\x18":
            self._reset()
        elif self.dead_at is not None or self.homing_until is not None:
            return
        elif byte >= b"\x90":
            self._override(value)
        elif byte == b"?" and self.loses_questions:
            self.loses_questions -= 1
        elif byte == b"?":
            self._report()
        elif byte == b"!" and self.state in ("Run", "Idle"):
            self._brake("Hold")
        elif byte in b"!\x85" and self.state == "Jog":
            self._brake("Idle")  # a feed hold ends a jog
        elif byte == b"\x84":
            self.say("[MSG:Check Door]")
            self._brake("Door")
        elif byte == b"~" and self.state in ("Hold:0", "Door:0"):
            self.state = "Run" if self.move or self.queue or self.block else "Idle"
            self._go_on()

    def _override(self, value):
        if time.monotonic() - self._flagged.get(value, 0.0) < self.loop_s:
            return  # a flag that is set already: the real one's loop has not come round to it
        self._flagged[value] = time.monotonic()
        change = {0x91: 10, 0x92: -10, 0x93: 1, 0x94: -1}
        if value >= 0x95:
            self.rapid = {0x95: 100, 0x96: 50, 0x97: 25}[value]
        else:
            feed = self.feed + change[value] if value in change else 100
            self.feed = min(200, max(10, feed))
        self.wco_in = 1  # told with the next report

    def _reset(self):
        if self.emergency or (self.dead_at is not None and not self.reset_allowed):
            return  # swallowed
        was_moving = self.move is not None and self.state not in ("Hold:0",)
        homing = self.homing_until is not None
        if self.dead_at is None and (was_moving or homing):
            self._stand()
            self.say(f"ALARM:{self.aborts_as if homing else 3}")
            self.state = "Alarm"
            self._clear()
            self._late_banner, self._ready_at = True, self.now() + SWALLOW_S
            return
        if self.dead_at is not None or self.state == "Sleep":
            self.state = "Alarm"
        elif self.state != "Alarm":
            self.state = "Idle"
        if self.move is not None:
            self._stand()
        if self.block is not None and not self.hal:
            self.say("ok")  # GRBL returns from the line that it was in as if it had been executed
        self._clear()
        self._banner()

    def _alarm(self, code):
        self._stand()
        self.say(f"ALARM:{code}")
        self.state, self.dead_at, self.reset_allowed = "Alarm", self.now(), False
        self.rx.clear()
        self.queue.clear()
        self.block = None

    def press(self):
        """The emergency stop, as grblHAL takes it."""
        self.emergency = True
        self._alarm(10)

    def _report(self):
        state = self.state
        if state == "Run" and not self.move and not self.queue:
            state = "Idle"
        place = [self._length(v) for v in self.place]
        work = [self._length(v - o) for v, o in zip(self.place, self.offset, strict=True)]
        kind = "MPos" if int(self.settings[10]) & 1 else "WPos"
        fields = [f"{kind}:{','.join(place if kind == 'MPos' else work)}"]
        if self.hal or int(self.settings[10]) & 2:
            fields.append(f"Bf:{PLANNER - len(self.queue)},{RX - len(self.rx)}")
        speed = self.move[0].speed_at(self.now() - self.move[1]) * 60 if self.move else 0
        fields.append(f"FS:{speed:.0f},0")
        if pins := "P" * self._touches() + self.buttons:
            fields.append(f"Pn:{pins}")
        if self.wco_in == 0:
            fields.append("WCO:" + ",".join(self._length(v) for v in self.offset))
        elif self.wco_in == 1:
            fields.append(f"Ov:{self.feed},{self.rapid},100" + ("|A:|TLR:0" if self.hal else ""))
        self.wco_in = (self.wco_in + 1) % (30 if self.move else 10)
        self.say(f"<{state}|{'|'.join(fields)}>")

    def _touches(self):
        return self.surface is not None and self.place[2] <= self.surface + 0.002

    def _length(self, mm):
        return f"{mm / 25.4:.4f}" if self.settings[13] else f"{mm:.3f}"

    # -- lines --------------------------------------------------------------------------------

    def _parse(self):
        """Take lines out of the buffer as far as the planner and what runs allow."""
        while self.dead_at is None and self.homing_until is None:
            if self.block is not None:
                if self.block() is False:
                    return
                self.block = None
            if self.state in ("Hold:0", "Hold:1", "Door:0", "Sleep") or len(self.queue) >= PLANNER:
                return
            if self.state == "Jog" and self._braking is not None:
                return  # what comes while it brakes waits, and is done afterwards
            while self.rx and not self.line.endswith(b"\n"):
                self.line += bytes([self.rx.popleft()])
            if not self.line.endswith(b"\n"):
                return
            text, self.line = self.line.strip().decode("ascii", "replace"), b""
            self.heard.append(text)
            self._tell_unhomed()
            self._obey(text)

    def _ok(self, text=""):
        if self.eats_ok_of and re.search(self.eats_ok_of, text):
            self.eats_ok_of = None
            return
        self.say("ok")

    def _obey(self, text):
        line = re.sub(r"\(.*?\)|;.*|\s", "", text).upper()
        if len(text) > 80:
            return self.say("error:11")
        if line in self.refuses:
            return self.say(f"error:{self.refuses[line]}")
        if line.startswith("$J="):
            return self._jog(line[3:], text)
        if line.startswith("$"):
            return self._dollar(line, text)
        if self.state in ("Alarm", "Jog"):
            return self.say("error:9")
        if self.state == "Check":
            return self._ok(text)
        words = re.findall(r"([A-Z])(-?\d*\.?\d*)", line)
        if any(not value for _, value in words):
            return self.say("error:2")
        values = {letter: float(value) for letter, value in words if letter != "G"}
        codes = {float(value) for letter, value in words if letter == "G"}
        if codes - {0, 1, 4, 10, 17, 20, 21, 38.3, 53, 54, 90, 91, 93, 94}:
            return self.say("error:20")
        if "M" in values:
            return self._switch(values["M"], text)
        if 38.3 in codes:
            return self._probe(values, codes)
        if 4 in codes or 10 in codes:
            self.block = lambda: self._when_still(codes, values, text)
            return None
        if 1 in codes and not values.get("F"):
            return self.say("error:22")
        if set(values) & set(AXES):
            if self.settings[20] and not self._in_travel(self._target(values, codes)):
                self._soft_trip = True
                self.block = lambda: self._when_braked()
                if not self.move:
                    self._alarm(2)
                return None
            self._queue(values, codes, values.get("F") if 1 in codes else None)
        self._ok(text)
        return None

    def _switch(self, number, text):
        if number not in (3, 5, 8, 9):  # M7 is not built in
            return self.say("error:20")
        self.outputs -= {3} if number == 5 else {8} if number == 9 else set()
        # In laser mode a spindle is dark outside of G1, and answered with `ok`.
        self.outputs |= {number} & ({8} if self.settings[32] else {3, 8})
        return self._ok(text)

    def _probe(self, values, codes):
        if self._touches():
            self._alarm(4)
            return
        target = self._target(values, codes)
        touched = self.surface is not None and target[2] <= self.surface <= self.place[2]
        if touched:
            values = {
                **values,
                "Z": self.surface - (0 if 91 not in codes else self._target({}, [])[2]),
            }
        elif self.probes_half:
            values = {**values, "Z": values["Z"] / 2}
        self._queue(values, codes, values["F"])

        def ended():
            if self.move or self.queue:
                return False
            place = ",".join(self._length(v) for v in self.place)
            self.say(f"[PRB:{place}:{int(touched)}]")
            self._ok("G38.3")
            return True

        self.block = ended

    def _when_braked(self):
        if self.move or self.queue:
            return False
        self._alarm(2)
        return False

    def _when_still(self, codes, values, text):
        """`G4` and `G10 L20` wait until all earlier motion has ended, or is held and out of the planner."""
        if not (self._ends_held and self.state == "Hold:1"):
            if self.move or self.queue or self.state not in ("Idle", "Run"):
                return False
            self.state = "Idle"
        if 10 in codes:
            for axis in set(values) & set(AXES):
                i = AXES.index(axis)
                self.offset[i] = self.place[i] - values[axis]
            self.wco_in = 0
        self._ok(text)
        return True

    def _dollar(self, line, text):
        waits = line in ("$$", "$H", "$I", "$SLP") or re.match(r"\$\d+=", line)
        if waits and self.state not in ("Idle", "Alarm"):
            return self.say("error:8")
        if self.fluid and (found := re.fullmatch(r"\$/AXES/(\w)/HOMING/MPOS_MM", line)):
            if found[1] not in AXES:
                return self.say("error:3")
            self.say(f"{text}={self.homes_at[AXES.index(found[1])]:.3f}")
            return self._ok(text)
        if self.fluid and line == "$CD":
            self.say("axes:")
            for letter, place in zip(AXES, self.homes_at, strict=True):
                for text_ in (f"  {letter.lower()}:", "    homing:", f"      mpos_mm: {place:.3f}"):
                    self.say(text_)
            return self._ok(text)
        if line == "$$":
            for number, value in self.settings.items():
                whole = isinstance(value, int)
                self.say(f"${number}={value}" if whole else f"${number}={value:.3f}")
            return self._ok(text)
        if found := re.fullmatch(r"\$(\d+)=(\d+\.?\d*)", line):
            if int(found[1]) not in self.settings:
                return self.say("error:3")
            self.settings[int(found[1])] = type(self.settings[int(found[1])])(float(found[2]))
            return self._ok(text)
        if line == "$G":
            self.say("[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]")
            return self._ok(text)
        if line == "$I":
            letters = "VZ" if self.zero_where_homed else "V"
            kind = "4.0 FluidNC v4.0.5" if self.fluid else f"1.1{'f' if self.hal else 'h'}.20190830"
            self.say(f"[VER:{kind}:]")
            buffers = ",35,1024,3,0" if self.hal else ",15,128"
            self.say("[OPT:PHS]" if self.fluid else f"[OPT:{letters}{buffers}]")
            for name in HAL_SAYS if self.hal else ():
                self.say(f"[{name}]")
            return self._ok(text)
        if line == "$SLP":
            self.say("[MSG:Sleeping]")
            self._ok(text)
            self.state = "Sleep"
            return None
        if line == "$C":
            if self.state != "Check":
                self.say("[MSG:Enabled]")
                self.state = "Check"
                return self._ok(text)
            self.say("[MSG:Disabled]")
            self._ok(text)
            return self._reset()
        if line == "$X" and self.reset_pressed:
            return self.say("error:18")
        if line == "$X":
            if self.state == "Alarm":
                self.say("[MSG:Caution: Unlocked]")
                self.state = "Idle"
            return self._ok(text)
        if line == "$H":
            if not int(self.settings[22]):
                return self.say("error:5")
            self.state = "Home"
            self.homing_until = self.now() + self.homing_s
            self.motions.append([time.time(), math.inf])
            return None
        return self.say("error:3")

    def _homed(self):
        self.homing_until = None
        self.motions[-1][1] = time.time()
        if self.homing_fails:
            way = 1 if not int(self.settings[23]) >> 2 & 1 else -1
            by = 1.5 * self.settings[132] if self.homing_fails == 9 else -self.settings[27]
            self.steps[2] += round(way * by * self.settings[102])
            self.stands.append((time.time(), self.place))
            self.say(f"ALARM:{self.homing_fails}")
            if not self.hal:
                self.say("ok")
            self.state = "Alarm"
            self._clear()
            self._banner()
            return
        for i in range(3):
            plus = not int(self.settings[23]) >> i & 1
            travel, off = self.settings[130 + i], self.settings[27]
            place = 0.0 if self.zero_where_homed else -off if plus else -(travel - off)
            place = self.homes_at[i] if self.fluid else place
            self.steps[i] = math.floor(place * self.settings[100 + i])
        self.target = list(self.steps)
        self.stands.append((time.time(), self.place))
        self.state = "Idle"
        self._start_up()
        self._ok("$H")

    def _jog(self, line, text):
        if self.state not in ("Idle", "Jog"):
            return self.say("error:8")
        words = dict(re.findall(r"([XYZF])(-?\d+\.?\d*)", line))
        codes = {float(v) for v in re.findall(r"G(\d+)", line)}
        if "F" not in words:
            return self.say("error:22")
        values = {letter: float(value) for letter, value in words.items()}
        if self.settings[20] and not self._in_travel(self._target(values, codes)):
            return self.say("error:15")
        self._queue(values, codes, values["F"])
        self.state = "Jog"
        return self._ok(text)

    # -- motion -------------------------------------------------------------------------------

    def _target(self, values, codes):
        target = [steps / self.settings[100 + i] for i, steps in enumerate(self.target)]
        for axis in set(values) & set(AXES):
            i = AXES.index(axis)
            if 91 in codes:
                target[i] += values[axis]
            else:
                target[i] = values[axis] + (0 if 53 in codes else self.offset[i])
        return target

    def _in_travel(self, target):
        for i, place in enumerate(target):
            to_plus = (self.zero_where_homed or self.fluid) and int(self.settings[23]) >> i & 1
            slop = 1 / self.settings[100 + i] if self.fluid else 0
            place -= self.homes_at[i] if self.fluid else 0
            off = self.settings[27]
            both = self.hal and self.settings[21] and not self.zero_where_homed
            if both and not off - self.settings[130 + i] <= place <= -off:
                return False
            if not -slop <= (place if to_plus else -place) <= self.settings[130 + i] + slop:
                return False
        return True

    def _queue(self, values, codes, feed):
        target = self._target(values, codes)
        self.target = [round(v * self.settings[100 + i]) for i, v in enumerate(target)]
        self.queue.append((tuple(self.target), feed))
        self._dry = False
        if self.state == "Idle":
            self.state = "Run"

    def _drive(self, now):
        if self.move is not None:
            move, began = self.move
            way = move.travelled(now - began)
            if self._braking is not None:
                at, state = self._braking
                way = min(way, move.braked_at(at - began))
                if now - at >= move.speed_at(at - began) / move.acceleration:
                    self._set(move.point(move.braked_at(at - began)))
                    self._braked(move, state)
                    return
            self._set(move.point(way))
            if self.held_late and self._is_prepared():
                self.held_late = False
                self._brake("Hold")
            if self.runs_dry_at is not None and self.place[0] >= self.runs_dry_at:
                self.runs_dry_at, self._dry, self.state = None, True, "Idle"
                self.queue.appendleft((self._end, move.speed * 60))
                self._stand()
            elif self.hit_at is not None and self.place[0] >= self.hit_at:
                self._alarm(1)
            elif self.reset_at is not None and self.place[0] >= self.reset_at:
                self.reset_at, self.reset_pressed = None, True
                self._reset()
            elif way >= move.length:
                self.steps = list(self._end)
                self._stand()
                if self._ends_held:
                    self.state, self._ends_held = "Hold:0", False
        elif self._braking is not None:
            state, self._braking = self._braking[1], None
            self.state = state if state == "Idle" else f"{state}:0"
        if (
            self.move is None
            and self.queue
            and not self._dry
            and not self.state.startswith(("Hold", "Door", "Alarm"))
        ):
            self._begin(*self.queue.popleft())
        elif self.move is None and not self.queue and self.state in ("Run", "Jog"):
            self.state = "Idle"

    def _begin(self, target, feed):
        self._end = target
        end = [steps / self.settings[100 + i] for i, steps in enumerate(target)]
        speed = self.settings[110] / 60 if feed is None else min(feed, self.settings[110]) / 60
        move = Move(tuple(self.place), tuple(end), speed, self.settings[120])
        if move.length:
            self.move = (move, self.now())
            self.motions.append([time.time(), math.inf])
        else:
            self.steps = list(target)

    def _set(self, point):
        self.steps = [round(v * self.settings[100 + i]) for i, v in enumerate(point)]

    def _stand(self):
        if self.move is not None:
            self.move = None
            self.motions[-1][1] = time.time()
            self.stands.append((time.time(), self.place))
        self._braking = None

    def _is_prepared(self):
        """Whether its planner has nothing more of what moves."""
        if self.move is None or self.queue:
            return False
        move, began = self.move
        return move.duration_s - (self.now() - began) < PREPARED_S

    def _brake(self, state):
        if state == "Hold" and self._is_prepared():
            self._ends_held = True
        else:
            self._braking = (self.now(), state)
        if state != "Idle":
            self.state = f"{state}:1"

    def _braked(self, move, state):
        end = self._end
        self._stand()
        if state == "Idle":
            self.queue.clear()
            self.target = list(self.steps)
            self.state = "Idle"
            return
        self.state = f"{state}:0"
        if tuple(self.steps) != tuple(end):
            self.queue.appendleft((end, move.speed * 60))

    def _go_on(self):
        self._braking = None
        self._dry = False
