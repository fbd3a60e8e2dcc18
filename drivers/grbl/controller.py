"""Talk with a GRBL controller: lines and their answers, reports, alarms, boots."""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from ..news import News
from .faults import Alarmed, GrblFault, Lost, NotConnected, Refused, Restarted, Silent
from .port import Port
from .report import Report, ReportReader
from .said import Lines, Said, understand
from .settings import Settings
from .words import alarm_words

RESET, HOLD, RESUME, ASK, CANCEL_JOG = b"\x18", b"!", b"~", b"?", b"\x85"

ANSWER_S = 5.0
"""How long a line that is only queued waits for its `ok`."""

REPORT_S = 2.0
"""How long a `?` waits for its report; a controller answers it within milliseconds."""

RX_BYTES = 127
"""How many bytes may be on their way: what overruns the 128 of its buffer is lost silently."""


@dataclass(slots=True)
class _Line:
    text: str
    answer: asyncio.Future[None]


class Controller:
    """One controller on one port, as it is known now.

    `homed` is whether its position can be trusted, `alarm` why it cannot go on (empty where it
    can). Whatever waits here is told when the port is lost, an alarm comes or it boots.
    """

    def __init__(self, port: str, baud: int) -> None:
        self.port = Port(port, baud, self._take, self._lost)
        self.lines = Lines()
        self.reports = ReportReader()
        self.settings = Settings()
        self.report: Report | None = None
        self.firmware = ""
        self.homed = False
        self.alarm = ""
        self.lost = "it has not been opened yet"
        self.message = ""
        self.mute = ""  # why nobody knows how it is, though its port is there
        self.reports_heard = 0
        self.boots = 0
        self.dead = False  # from an alarm to the boot that follows, it answers nothing
        self.deaf = False  # while it homes it does not answer `?`
        self.wants_reset = False
        self.heard_at = 0.0
        self.overheard: deque[str] = deque(maxlen=5)
        self.stopping: asyncio.Task[None] | None = None
        self.on_alarm: Callable[[], None] = lambda: None
        self.on_report: Callable[[], None] = lambda: None
        self._told: list[str] = []
        self._reset_asked = False
        self._in_flight: deque[_Line] = deque()
        self._news = News()
        self.until = self._news.until

    def write(self, data: bytes) -> None:
        """Bytes that are obeyed at once, past all lines; nothing where the port is lost."""
        if not self.lost:
            self.port.write(data)

    def reset(self) -> None:
        """Ctrl-X; the boot that follows is ours and no accident."""
        self._reset_asked = True
        self.write(RESET)

    def room_for(self, line: str) -> bool:
        """Whether its buffer surely takes this line too."""
        return sum(len(one.text) + 1 for one in self._in_flight) + len(line) + 1 <= RX_BYTES

    def say(self, line: str) -> asyncio.Future[None]:
        """Send a line; the future ends with its `ok` or raises a GrblFault."""
        if self.lost:
            raise NotConnected(self.lost)
        answer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        answer.add_done_callback(_seen)
        self._in_flight.append(_Line(line, answer))
        self.port.write(line.encode("ascii") + b"\n")
        return answer

    async def ask(self, line: str, seconds: float = ANSWER_S) -> list[str]:
        """Send a line and wait for its `ok`; the settings and texts that came before it."""
        self._told = []
        answer = self.say(line)
        try:
            async with asyncio.timeout(seconds):
                await answer
        except TimeoutError:
            self.forget(answer)
            raise Silent(f"it did not answer within {seconds:g} s; {self.last_words}") from None
        return self._told

    def forget(self, answer: asyncio.Future[None]) -> None:
        """Nobody waits for this answer any more."""
        self._in_flight = deque(one for one in self._in_flight if one.answer is not answer)

    async def look(self, seconds: float = REPORT_S) -> Report:
        """A report made after this call; raises Silent or Lost."""
        if self.lost:
            raise Lost(self.lost)
        before = self.reports_heard
        self.write(ASK)
        if not await self.until(lambda: self.reports_heard > before or bool(self.lost), seconds):
            self.mute = (
                f"it did not answer `?` within {seconds:g} s; {self.last_words}. "
                f"Is it switched on, and its cable in?"
            )
            raise Silent(self.mute)
        if self.lost or self.report is None:
            raise Lost(self.lost)
        return self.report

    @property
    def last_words(self) -> str:
        """What it said last, for a sentence."""
        if not self.overheard:
            return "it has said nothing"
        return f"its last words were `{self.overheard[-1]}`"

    def silent_s(self) -> float:
        """For how long nothing readable has come."""
        return asyncio.get_running_loop().time() - self.heard_at

    def connected(self) -> None:
        """The port is open; nothing that was known of an earlier connection holds."""
        self.lost, self.dead, self.deaf, self.wants_reset = "", False, False, False
        self.report, self.lines, self.message, self.mute = None, Lines(), "", ""
        self.reports = ReportReader()
        self.heard_at = asyncio.get_running_loop().time()
        self.overheard.clear()
        self._reset_asked = True  # opening the port boots most boards

    def configure(self, settings: Settings) -> None:
        """Take in its settings; a boot that comes from here on is one that nobody asked for."""
        self.settings = settings
        self._reset_asked = False
        self.reports.inches = settings.inches
        self.reports.offset = None  # what was told before may be read wrongly

    def disconnected(self, why: str) -> None:
        """The port is closed, and all that waited is told why."""
        self.lost = self.lost or why
        self.homed = False
        self._fail(Lost(self.lost))
        self._news.set()

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
        self._news.set()

    def _hear(self, said: Said) -> None:
        match said.kind:
            case "ok" if self._in_flight:
                self._settle(None)
            case "error" if self._in_flight:
                self._settle(Refused(said.code))
            case "report":
                self._hear_report(said.text)
            case "alarm":
                self._hear_alarm(said.code)
            case "banner":
                self._hear_boot(said.text)
            case "message":
                self.message = said.text
                self.wants_reset = self.wants_reset or said.text == "Reset to continue"
            case "setting" | "options":
                self._told.append(said.text)
            case _:
                pass

    def _settle(self, fault: GrblFault | None) -> None:
        answer = self._in_flight.popleft().answer
        if not answer.done():
            answer.set_result(None) if fault is None else answer.set_exception(fault)

    def _fail(self, fault: GrblFault) -> None:
        while self._in_flight:
            self._settle(fault)

    def _hear_report(self, text: str) -> None:
        report = self.reports.read(text)
        if report is not None:
            self.report, self.mute = report, ""
            self.reports_heard += 1
            self.on_report()

    def _hear_alarm(self, code: int) -> None:
        # An `ok` that comes after this is no success: nobody is left to take it.
        self.alarm, self.homed, self.dead = alarm_words(code), False, True
        self._fail(Alarmed(code))
        self.on_alarm()

    def _hear_boot(self, firmware: str) -> None:
        self.boots += 1
        self.firmware = firmware
        self.dead, self.deaf, self.wants_reset = False, False, False
        why = f"it started anew: `{firmware}`"
        if not self._reset_asked:
            why += ". Look at its reset button, its emergency stop and its power, and home it"
            self.homed = False
            self.alarm = self.alarm or (
                "it started anew by itself (reset button, emergency stop, or its power failed); "
                "where it stands is not known. Home it"
            )
        self._fail(Restarted(why))
        self._reset_asked = False


def _seen(answer: asyncio.Future[None]) -> None:
    """A fault that nobody waited for is no leak."""
    if not answer.cancelled():
        answer.exception()
