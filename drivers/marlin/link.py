"""Talk to Marlin: numbered lines, one at a time, each answered before the next is sent.

Every line has a number and a checksum, so that one whose answer was lost in noise is sent again and
is still carried out once: Marlin answers a number that it has had by asking for the one after it, and
since 2.1 not at all. So an echo is asked for behind it, which comes when it was had.
"""

import asyncio
import re
from collections import deque

from ..motion.faults import Lost, MotionFault, NotConnected, NotThere, Restarted, Silent
from ..serial_io.any_port import lost_words, open_port
from ..serial_io.condition import Condition
from ..serial_io.open_port import OpenPort

SILENCE_S = 5.0
"""Marlin says `busy: processing` every two seconds as long as it works on a line."""
TRIES = 2
BOOTED = "start"
ECHO = "labrun asks"
RESEND = re.compile(r"(?:Resend:|rs)\s*N?(\d+)")
UNKNOWN = "Unknown command:"
STOPPED = re.compile(r"kill\(\) called|Printer halted|stopped due to errors", re.IGNORECASE)
REPEATED = re.compile(r"Line Number is not|checksum mismatch|No Checksum", re.IGNORECASE)
CODE = re.compile(r"\S\d*(?:\.\d+)?")
LONGEST = 512


class Link:
    """One Marlin on one port, as currently known.

    `homed` is whether its position can be trusted, `alarm` why it cannot continue (empty if it
    can), `halted` whether it answers nothing until it is restarted, `lost` why nothing can be sent.
    """

    def __init__(self, port: str, baud: int) -> None:
        self.baud = baud
        self.port = OpenPort(
            port,
            lambda: open_port(port, baud),
            self._take,
            lambda f: self._lost(lost_words(port, f)),
        )
        self.homed = False
        self.alarm = ""
        self.lost = "it has not been opened yet"
        self.halted = False
        self.boots = 0
        self.unreadable = 0
        self.heard: deque[str] = deque(maxlen=5)
        self._rest = b""
        self._number = 0
        self._line = ""
        self._told: list[str] = []
        self._answer: asyncio.Future[None] | None = None
        self._swallow = 0
        self._echo_for: asyncio.Future[None] | None = None
        self._echoes = 0
        self._turn = asyncio.Lock()
        self._heard_at = 0.0
        self._asked_boot = False
        self._condition = Condition()
        self.until = self._condition.until

    async def open(self, boot_s: float) -> None:
        """Open the port, and find Marlin there; raises OSError with the reason."""
        await self.port.open()
        self.lost, self._rest, self.unreadable, self._asked_boot = "", b"", 0, True
        self.homed = False
        self.heard.clear()
        before = self.boots
        await self.until(lambda: self.boots > before or bool(self.lost), boot_s)
        try:
            await self.ask("M110 N0", again=False)
            self._number = 0
            told = await self.ask("M115", again=False)
        except MotionFault as fault:
            raise OSError(f"{self.port.name}: {self._not_marlin(boot_s, fault)}") from fault
        if not any("FIRMWARE_NAME" in line for line in told):
            raise OSError(f"{self.port.name}: {self._not_marlin(boot_s, None)}")
        self._asked_boot = False

    @property
    def busy(self) -> bool:
        """Whether a line waits for its answer."""
        return self._turn.locked()

    async def close(self, why: str) -> None:
        """Release the port."""
        self._lost(why)
        await self.port.close()

    def at_once(self, line: str) -> None:
        """Send a line without a number, which only an emergency parser takes while it is busy."""
        if not self.lost:
            self._swallow += 1
            self.port.write(line.encode("ascii") + b"\n")

    async def ask(self, line: str, *, again: bool = True) -> list[str]:
        """Send a line and wait for its `ok`, as long as it says that it is busy; what it told before."""
        async with self._turn:
            if self.lost:
                raise NotConnected(self.lost)
            if again:
                self._number += 1
            self._line = _numbered(self._number, line) if again else line
            self._told = []
            answer = self._answer = asyncio.get_running_loop().create_future()
            try:
                await self._answered(answer, again=again)
            finally:
                self._answer = None
            told = self._told
        if any(UNKNOWN in one for one in told):
            code = CODE.match(line)
            raise NotThere(f"this Marlin was built without `{code[0] if code else line}`")
        return told

    async def _answered(self, answer: "asyncio.Future[None]", *, again: bool) -> None:
        clock = asyncio.get_running_loop().time
        for tried in range(TRIES if again else 1):
            self.port.write(self._line.encode("ascii") + b"\n")
            if tried:
                self._echo_for = answer
                self.port.write(f"M118 {ECHO}\n".encode("ascii"))
            self._heard_at = clock()
            while (left := self._heard_at + SILENCE_S - clock()) > 0:
                await asyncio.wait({answer}, timeout=left)
                if answer.done():
                    answer.result()
                    return
        raise Silent(f"it did not respond within {SILENCE_S:g} s; {self.last_words}")

    async def in_step(self) -> None:
        """Wait until no answer is owed: an `ok` too many or too few would answer the wrong line for ever."""
        async with self._turn:
            if self.lost:
                raise NotConnected(self.lost)
            self._swallow, before = 0, self._echoes
            self.port.write(f"M118 {ECHO}\n".encode("ascii"))
            await self.until(lambda: self._echoes > before or bool(self.lost), SILENCE_S)
            if self._echoes == before:
                raise Silent(f"it did not respond within {SILENCE_S:g} s; {self.last_words}")

    @property
    def last_words(self) -> str:
        """What it sent last, for a message."""
        return f"it last sent `{self.heard[-1]}`" if self.heard else "it has sent nothing"

    def _take(self, data: bytes) -> None:
        *whole, self._rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = self._rest[-LONGEST:]
        for line in whole:
            text = bytes(byte for byte in line if 0x20 <= byte < 0x7F).decode("ascii").strip()
            self.unreadable += len(line) - len(text)
            if text:
                self._hear(text)
        self._condition.set()

    def _hear(self, line: str) -> None:
        self._heard_at = asyncio.get_running_loop().time()
        if line == "ok" or line.startswith("ok "):
            if self._swallow:
                self._swallow -= 1
            else:
                self._settle(None)
            return
        self.heard.append(line[:80])
        if line == BOOTED:
            self._booted()
        elif line == ECHO:  # its `ok` follows
            self._echoes += 1
            if self._answer is None or self._answer.done() or self._answer is not self._echo_for:
                self._swallow += 1
        elif found := RESEND.match(line):
            self._again(int(found[1]))
        elif line.startswith("Error:"):
            self._error(line)
        elif not line.startswith("echo:busy") and self._answer is not None:
            self._told.append(line)

    def _error(self, line: str) -> None:
        if STOPPED.search(line):
            before = f"`{self.heard[-2]}`, " if len(self.heard) > 1 else ""
            self.homed, self.halted = False, True
            self.alarm = (
                f"it has halted itself ({before}`{line}`); unlock restarts it, then home it"
            )
            self._settle(MotionFault(self.alarm))
        elif not REPEATED.search(line):
            self._told.append(line)

    def _again(self, number: int) -> None:
        """It asks for a line again; an `ok` follows, which answers nothing."""
        self._swallow += 1
        if number == self._number + 1:
            self._settle(None)  # it has had the line: only the answer was lost
        elif number == self._number:
            self.port.write(self._line.encode("ascii") + b"\n")

    def _booted(self) -> None:
        self.boots += 1
        self._number, self._swallow, self.homed, self.halted = 0, 0, False, False
        if not self._asked_boot:
            self.alarm = (
                "it restarted (reset button, or power failure); its position is unknown. Home it"
            )
            self._settle(Restarted(self.alarm))

    def _settle(self, fault: MotionFault | None) -> None:
        if self._answer is not None and not self._answer.done():
            if fault is None:
                self._answer.set_result(None)
            else:
                self._answer.set_exception(fault)

    def _lost(self, why: str) -> None:
        if not self.lost:
            self.lost, self.homed = why, False
            self._settle(Lost(why))
            self._condition.set()

    def _not_marlin(self, boot_s: float, fault: MotionFault | None) -> str:
        if self.lost:
            return self.lost
        if self.unreadable > 4:
            return (
                f"it responds, but with unreadable bytes: {self.baud} baud is probably wrong (Marlin "
                f"speaks 115200 or 250000); set `baud` in the lab"
            )
        if self.heard:
            return f"it responds, but not as Marlin does: it sent `{self.heard[-1][:60]}`"
        return (
            f"it is open, but nothing on it responds: no `start` within {boot_s:g} s, and no answer to "
            f"M115 ({fault}); is the controller switched on, and {self.baud} baud its speed?"
        )


def _numbered(number: int, line: str) -> str:
    text = f"N{number} {line}"
    checksum = 0
    for byte in text.encode("ascii"):
        checksum ^= byte
    return f"{text}*{checksum}"
