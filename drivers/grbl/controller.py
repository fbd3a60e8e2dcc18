"""Talk to a GRBL controller: lines and their answers, reports, alarms, boots."""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

from ..motion.faults import Lost, MotionFault, NotConnected, Restarted, Silent
from ..serial_io.any_port import lost_words, open_port
from ..serial_io.condition import Condition
from ..serial_io.open_port import OpenPort
from .faults import Alarmed, GrblRefused, reset_in_homing
from .firmware import Firmware, firmware_of
from .parse_line import Lines, ParsedLine, understand
from .report import Report, ReportReader
from .settings import Settings

RESET, HOLD, RESUME, ASK, CANCEL_JOG = b"\x18", b"!", b"~", b"?", b"\x85"

ANSWER_S = 5.0
"""How long a line that is only queued waits for its `ok`."""

REPORT_S = 2.0
"""How long a `?` waits for its report; a controller answers it within milliseconds."""

MARK = "$G"
"""Answered at any time, by `[GC:...]` and an `ok`: what was sent before it has been answered by then."""

AGAIN_S = 0.5
"""A `?` that has no report by then is sent again."""

RX_BYTES = 127 - len(MARK) - 1
"""How many bytes may be in transit: bytes beyond the 128 of its buffer are lost silently."""


class Contact(Enum):
    """Whether it hears and answers, as a person would say it."""

    CLOSED = "its port is not open"
    READY = "it responds"
    SILENT = "it did not respond to the last `?`, so its state is unknown"
    HOMING = "it is homing, and does not respond to `?` meanwhile"
    ALARMED = "it does not respond from an alarm to the boot that follows"
    WANTS_RESET = "since an alarm it waits for a reset"


@dataclass(slots=True)
class Line:
    """A line that was sent: its answer, and the settings and texts that came before that."""

    text: str
    answer: asyncio.Future[None]
    told: list[str] = field(default_factory=list)
    forgotten: bool = False


class Controller:
    """One controller on one port, as currently known.

    `homed` is whether its position can be trusted, `alarm` why it cannot continue (empty if it
    can). `why` says more than `contact` where it is closed or silent. Everything that waits here is
    notified when the port is lost, on an alarm or on a boot.
    """

    def __init__(self, port: str, baud: int) -> None:
        self.baud = baud
        self.port = OpenPort(
            port,
            lambda: open_port(port, baud),
            self._take,
            lambda fault: self._lost(lost_words(port, fault)),
        )
        self.lines = Lines()
        self.reports = ReportReader()
        self.settings = Settings()
        self.report: Report | None = None
        self.firmware = ""
        self.homed = False
        self.alarm = ""
        self.contact = Contact.CLOSED
        self.why = "it has not been opened yet"
        self.message = ""
        self.reports_heard = 0
        self.boots = 0
        self.heard_at = 0.0
        self.overheard: deque[str] = deque(maxlen=12)  # grblHAL says nine of itself
        self.stopping: asyncio.Task[None] | None = None
        self.on_alarm: Callable[[], None] = lambda: None
        self.on_report: Callable[[], None] = lambda: None
        self._reset_asked = False
        self._in_flight: deque[Line] = deque()
        self._condition = Condition()
        self.until = self._condition.until

    @property
    def kind(self) -> Firmware:
        """Which firmware it has told of: GRBL, until it has told of another."""
        return firmware_of(self.firmware)

    @property
    def lost(self) -> str:
        """Why its port is not open; empty if it is."""
        return self.why if self.contact is Contact.CLOSED else ""

    @property
    def dead(self) -> bool:
        """Whether it does not respond because of an alarm."""
        return self.contact in (Contact.ALARMED, Contact.WANTS_RESET)

    def write(self, data: bytes) -> None:
        """Send bytes that take effect at once, ahead of all lines; nothing if the port is lost."""
        if not self.lost:
            self.port.write(data.decode("latin-1").encode() if self.kind.utf8 else data)

    def reset(self) -> None:
        """Send Ctrl-X; the boot that follows is then expected."""
        self._reset_asked = True
        self.write(RESET)

    def room_for(self, line: str) -> bool:
        """Whether its buffer is certain to have room for this line."""
        return sum(len(one.text) + 1 for one in self._in_flight) + len(line) + 1 <= RX_BYTES

    def say(self, line: str) -> asyncio.Future[None]:
        """Send a line; the future ends with its `ok` or raises a MotionFault."""
        return self.send(line).answer

    def send(self, text: str) -> Line:
        """Send a line, which has its answer, and then what was told before it."""
        if self.lost:
            raise NotConnected(self.lost)
        owed = next((one for one in reversed(self._in_flight) if one.forgotten), None)
        if owed is not None and owed.text != MARK:
            self._send(MARK).forgotten = True
        return self._send(text)

    def _send(self, text: str) -> Line:
        line = Line(text, asyncio.get_running_loop().create_future())
        line.answer.add_done_callback(_seen)
        self._in_flight.append(line)
        self.port.write(text.encode("ascii") + b"\n")
        return line

    async def ask(self, line: str, seconds: float = ANSWER_S) -> list[str]:
        """Send a line and wait for its `ok`; return the settings and texts that came before it."""
        asked = self.send(line)
        try:
            async with asyncio.timeout(seconds):
                await asked.answer
        except TimeoutError:
            self.forget(asked.answer)
            raise Silent(f"it did not respond within {seconds:g} s; {self.last_words}") from None
        return asked.told

    def forget(self, answer: asyncio.Future[None]) -> None:
        """Stop waiting for this answer. It keeps its place: one that comes late settles no other line.

        Whether it is late or was lost in noise shows at the answer to the mark that is sent next.
        """
        for line in self._in_flight:
            line.forgotten |= line.answer is answer

    async def look(self, seconds: float = REPORT_S) -> Report:
        """A report made after this call; raises Silent or Lost."""
        if self.lost:
            raise Lost(self.lost)
        before = self.reports_heard
        clock = asyncio.get_running_loop().time
        end = clock() + seconds
        heard = False
        while not heard and (left := end - clock()) > 0:
            self.write(ASK)  # again, too: noise may have eaten one
            heard = await self.until(
                lambda: self.reports_heard > before or bool(self.lost), min(AGAIN_S, left)
            )
        if not heard:
            why = (
                f"it did not respond to `?` within {seconds:g} s; {self.last_words}. "
                f"Is it switched on, and its cable plugged in?"
            )
            if self.contact in (Contact.READY, Contact.SILENT):
                self.contact, self.why = Contact.SILENT, why
            raise Silent(why)
        if self.lost or self.report is None:
            raise Lost(self.lost)
        return self.report

    @property
    def last_words(self) -> str:
        """What it sent last, for a message."""
        if not self.overheard:
            return "it has sent nothing"
        return f"it last sent `{self.overheard[-1]}`"

    def silent_s(self) -> float:
        """Seconds since the last readable bytes."""
        return asyncio.get_running_loop().time() - self.heard_at

    def connected(self) -> None:
        """Note that the port is open; what was known from an earlier connection is void."""
        self.contact = Contact.READY
        self.report, self.lines, self.message = None, Lines(), ""
        self.reports = ReportReader()
        self.heard_at = asyncio.get_running_loop().time()
        self.overheard.clear()
        self._reset_asked = True  # opening the port boots most boards

    def configure(self, settings: Settings) -> None:
        """Store its settings; a boot from here on is unexpected."""
        self.settings = settings
        self._reset_asked = False
        self.reports.inches = settings.inches
        self.reports.offset = None  # earlier reports may have been misread

    def disconnected(self, why: str) -> None:
        """Note that the port is closed, and pass the reason to all that wait."""
        if not self.lost:
            self.contact, self.why = Contact.CLOSED, why or Contact.CLOSED.value
        self.homed = False
        self._fail(Lost(self.lost))
        self._condition.set()

    def _lost(self, why: str) -> None:
        if not self.lost:
            self.disconnected(why)

    def _take(self, data: bytes) -> None:
        for line in self.lines.cut(data):
            self.heard_at = asyncio.get_running_loop().time()
            said = understand(line)
            if said.kind not in ("report", "ok", "setting", "options"):
                self.overheard.append(line[:80])
            self._hear(said)
        self._condition.set()

    def _hear(self, said: ParsedLine) -> None:
        match said.kind:
            case "ok" if self._in_flight:
                self._settle(None)
            case "error" if self._in_flight:
                self._settle(GrblRefused(said.code, self.kind))
            case "report":
                self._hear_report(said.text)
            case "alarm":
                self._hear_alarm(said.code)
            case "banner":
                self._hear_boot(said.text)
            case "message":
                self.message = said.text
                if self.dead and said.text == "Reset to continue":
                    self.contact = Contact.WANTS_RESET
            case "modes" if any(line.text == MARK for line in self._in_flight):
                while self._in_flight[0].text != MARK:
                    self._settle(Silent("its answer was lost in noise"))
            case "setting" | "options" | "probe" if self._in_flight:
                self._in_flight[0].told.append(said.text)
            case _:
                pass

    def _settle(self, fault: MotionFault | None) -> None:
        answer = self._in_flight.popleft().answer
        if not answer.done():
            answer.set_result(None) if fault is None else answer.set_exception(fault)

    def _fail(self, fault: MotionFault) -> None:
        while self._in_flight:
            self._settle(fault)

    def _hear_report(self, text: str) -> None:
        report = self.reports.read(text)
        if report is not None:
            self.report = report
            if self.contact is Contact.SILENT:
                self.contact = Contact.READY
            self.reports_heard += 1
            self.on_report()

    def _hear_alarm(self, code: int) -> None:
        if self._reset_asked and self.contact is Contact.HOMING:
            code = reset_in_homing(code)
        self.alarm, self.homed = self.kind.alarm(code), False
        if code == self.kind.unhomed:
            return
        # An `ok` that comes after this is not a success: nothing waits for it any more.
        if self.contact is not Contact.WANTS_RESET:
            self.contact = Contact.ALARMED
        self._fail(Alarmed(code, self.kind))
        self.on_alarm()

    def _hear_boot(self, firmware: str) -> None:
        self.boots += 1
        self.firmware = firmware
        self.contact = Contact.READY
        why = f"it restarted: `{firmware}`"
        if not self._reset_asked:
            why += ". Check its reset button, emergency stop and power, and home it"
            self.homed = False
            self.alarm = self.alarm or (
                "it restarted unexpectedly (reset button, emergency stop, or power failure); "
                "its position is unknown. Home it"
            )
        self._fail(Restarted(why))
        self._reset_asked = False


def _seen(answer: asyncio.Future[None]) -> None:
    """Mark an exception that nothing waits for as retrieved."""
    if not answer.cancelled():
        answer.exception()
