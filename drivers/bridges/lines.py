"""Lines of text with an instrument, whatever its habits: banner, echo, prompt, terminators, blocks."""

import asyncio
import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from ...schemas.model import Model
from ...schemas.patterns import regular_expression
from ...schemas.quantity import Duration, seconds
from ..driver import Place
from ..serial_io.port import read_port
from .channel import CALM_S, Channel, Messages, Network, Serial, Visa
from .checksum import Checksum
from .config import LISTED, Pattern, pattern
from .number_forms import decimals, number_bytes, size_of
from .resource import Wire, read_resource

MOST_LINES = 1_000_000
TAIL = 4096
"""Bytes of a line by which it is seen that it has begun."""
MOST_FRAME = 16 * 1024 * 1024
"""Bytes of a frame; a length beyond it is none."""


ENDS = {"CR": "\r", "LF": "\n", "CRLF": "\r\n", "\\r": "\r", "\\n": "\n", "\\r\\n": "\r\n"}
"""By name, and as YAML reads them without double quotes."""
End = Annotated[str, AfterValidator(lambda value: ENDS.get(value, value))]


class Terminator(Model):
    """What ends a line: one that is sent, one that is read; or how long nothing comes after it.

    `begin` is what stands before either.
    """

    begin: End = ""
    write: End = "\n"
    read: Annotated[End, Field(min_length=1)] | None = None
    silence: Duration | None = None


class Exchange(Model):
    """What is said first, and what is sent then."""

    after: Pattern | None = None
    send: str | None = None


class LengthFrame(Model):
    """A frame that says how long it is: `more` bytes follow those that its length counts.

    The length is put into what is sent and taken out of what comes, unless it is not `sent`: then it
    stands in the lab's texts.
    """

    length: str
    at: int = Field(default=0, ge=0)
    more: int = 0
    start: str = ""
    sent: bool = True

    @field_validator("length")
    @classmethod
    def _is_a_whole_number(cls, value: str) -> str:
        size_of(value)
        if "f" in value:
            raise ValueError(f"a length is a whole number such as u1, >u2, not {value}")
        return value

    def put(self, line: bytes, sums: Checksum | None, end: str) -> bytes:
        """What is sent, with its length in it, to which the checksum and the end will be added."""
        if not self.sent:
            return line
        at = self._at(sums)
        number = len(line) + (0 if sums is None else sums.size) + len(end) - self.at - self.more
        return line[:at] + number_bytes(number, self.length).encode("latin-1") + line[at:]

    def without(self, line: bytes, sums: Checksum | None) -> bytes:
        """What has come, without its length; its checksum has been taken off."""
        at = self._at(sums)
        return line[:at] + line[at + size_of(self.length) :] if self.sent else line

    def _at(self, sums: Checksum | None) -> int:
        return self.at - sums.size if sums is not None and sums.first else self.at

    def taken(self, buffer: bytearray) -> bytes | None:
        """A whole frame, taken out of what has come; what comes before its `start` is dropped."""
        start = self.start.encode("latin-1")
        while True:
            if (begin := buffer.find(start)) < 0:
                return None
            del buffer[:begin]
            head = self.at + size_of(self.length)
            if len(buffer) < head:
                return None
            counted = bytes(buffer[self.at : head]).decode("latin-1")
            size = head + int(decimals(counted, {"bytes": self.length})[0]) + self.more
            if head <= size <= MOST_FRAME:
                break
            del buffer[: len(start) or len(buffer)]  # it began elsewhere
        if len(buffer) < size:
            return None
        frame = bytes(buffer[:size])
        del buffer[:size]
        return frame


class LineConfig(Wire):
    """Where the instrument is, and its habits."""

    terminator: str | Terminator | None = None
    encoding: Literal["ascii", "latin-1", "utf-8"] = "latin-1"
    decimal: Literal[".", ","] = "."
    echo: bool = False
    prompt: Annotated[list[str], LISTED] = Field(default_factory=list)
    frame: Annotated[str | LengthFrame, AfterValidator(pattern)] | None = None
    banner: Pattern | None = None
    expired: Pattern | None = None
    login: list[Exchange] = Field(default_factory=list)
    checksum: Checksum | None = None
    escapes: dict[str, str] = Field(default_factory=dict)
    ignore: Pattern | None = None
    pause: Duration | None = None
    pace: Duration | None = None
    local_port: int | None = Field(default=None, gt=0, lt=65536)
    visa_library: str = "@py"
    flow: Literal["none", "rtscts", "xonxoff"] = "none"

    @model_validator(mode="after")
    def _is_a_stream(self) -> "LineConfig":
        if self.pace is not None and read_resource(self.resource).kind not in ("tcp", "serial"):
            raise ValueError(
                "a `pace` is kept on serial ports and by TCP; elsewhere a line is sent whole"
            )
        if any("\n" in one or "\r" in one for one in self.prompts):
            raise ValueError("a `prompt` is one line, or the end of one: of several, say the last")
        if self.local_port is not None and read_resource(self.resource).kind != "udp":
            raise ValueError("a `local_port` is where answers by UDP come: udp://10.0.0.5:1024")
        return self

    @property
    def terminators(self) -> Terminator:
        """Sent is a line feed, and any line end is read, unless they are given."""
        if isinstance(self.terminator, str):
            return Terminator(write=self.terminator, read=self.terminator or None)
        return self.terminator or Terminator()

    @property
    def prompts(self) -> list[str]:
        """Each that may stand there."""
        return [one.strip() for one in self.prompt]

    @property
    def prompt_is_line(self) -> bool:
        """Whether the prompt is a line of its own, as `=>\\r\\n` is."""
        return any(one != one.rstrip("\r\n") for one in self.prompt)


class NoAnswer(Exception):
    """Nothing came in time, or not what was waited for; the text says what did."""


class Expired(NoAnswer):
    """It answers that nobody is logged in any more, and so has done nothing."""


class Lines:
    """One instrument's dialogue. Only one asks at a time; whoever asks holds `turn`."""

    def __init__(self, place: Place, config: LineConfig) -> None:
        self.resource = read_resource(config.resource)
        self.channel = channel_of(place, config)
        self.turn = asyncio.Lock()
        self._device = place.device
        self._config = config
        self._end = config.terminators
        self.prompted = ""
        """Which of several prompts came last."""
        self._cut = False
        """Whether the line that is coming has lost its beginning."""
        self._ignore = regular_expression(config.ignore) if config.ignore else None
        self._frame = config.frame
        self._binary = bool(config.frame is not None or config.escapes or self._end.begin)
        """Whether an answer is bytes, none of which is only blank."""
        self.listening_for: Any = None
        """The answer of an action that only listens: such a line is heard though `ignore` has it."""
        self._silence_s = seconds(self._end.silence) if self._end.silence is not None else None
        self._pause_s = seconds(config.pause) if config.pause is not None else 0.0
        self._pace_s = seconds(config.pace) if config.pace is not None else 0.0
        self._sending = asyncio.Lock()

    @property
    def is_open(self) -> bool:
        return self.channel.is_open

    async def open(self, timeout_s: float) -> None:
        """Connect and let the banner pass; raises OSError."""
        await self.channel.open(timeout_s)
        try:
            await self._pass_banner(timeout_s)
        except (OSError, NoAnswer) as fault:
            await self.close()
            raise OSError(str(fault)) from fault

    async def _pass_banner(self, timeout_s: float) -> None:
        until = asyncio.get_running_loop().time() + timeout_s
        if self._config.banner is not None:
            await self._said(self._config.banner, until, "greet with")
        for step in self._config.login:
            if step.after is not None:
                await self._said(step.after, until, "say")
            if step.send is not None:
                self.channel.received.clear()
                await self.at_once(step.send)
        if self.resource.kind != "visa":  # which is only read when it has been asked
            await self.channel.quiet()
            self.forget()

    async def _said(self, words: str, until: float, verb: str) -> None:
        """Wait for words that need no line end; raises NoAnswer."""
        wanted = regular_expression(words)
        while not wanted.search(self._decoded(self.channel.received)):
            if not await self.channel.more(until - asyncio.get_running_loop().time()):
                said = self._decoded(self.channel.received).strip() or "nothing"
                raise NoAnswer(f"{self} did not {verb} {words!r}, but {said!r}")

    async def close(self) -> None:
        """Disconnect: a late answer must not be taken for a later one."""
        await self.channel.close()

    async def send(self, text: str) -> None:
        """Send a line, and let the instrument echo it; raises OSError or NoAnswer."""
        self.listening_for = None
        if self._pause_s:
            await asyncio.sleep(self._pause_s)
        if self.resource.kind != "visa":
            for _ in range(2):  # what has come but was not taken in yet
                await asyncio.sleep(0)
            self.forget()
        await self.at_once(text)

    def forget(self) -> None:
        """Drop what has come; of a line that is still coming the rest is no line either."""
        buffer = self.channel.received
        if buffer and self._frame is None and not self._config.prompt:
            begun = self._ending().split(bytes(buffer[-TAIL:]))[-1].strip(b"\0 \t")
            age_s = asyncio.get_running_loop().time() - self.channel.heard_at
            self._cut = bool(begun) and age_s < CALM_S
        buffer.clear()

    async def at_once(self, text: str) -> None:
        """Send a line without waiting for anybody's turn: an abort."""
        data = self._summed(text) + self._end.write.encode("latin-1")
        size = 1 if self._pace_s else max(1, len(data))
        async with self._sending:
            for at in range(0, len(data), size):
                await self.channel.write(data[at : at + size])
                await asyncio.sleep(self._pace_s)

    def _summed(self, text: str) -> bytes:
        line, sums = self._encoded(text), self._config.checksum
        if isinstance(self._frame, LengthFrame):
            line = self._frame.put(line, sums, self._end.write if self._end.read else "")
        if sums is not None:
            line = sums.added(line)
        for sign, instead in self._escapes:
            line = line.replace(sign, instead)
        return self._end.begin.encode("latin-1") + line

    @property
    def _escapes(self) -> list[tuple[bytes, bytes]]:
        """What stands instead of which bytes; first the one that all of them begin with."""
        said = [(a.encode("latin-1"), b.encode("latin-1")) for a, b in self._config.escapes.items()]
        return sorted(said, key=lambda one: not one[1].startswith(one[0]))

    def pattern(self, words: str) -> Any:
        """An expression for an answer; of one in bytes, a dot is any of them."""
        return regular_expression(f"(?s){words}" if self._binary else words)

    async def finish(self, text: str, timeout_s: float) -> str:
        """After a line without an answer: its echo, and all up to the prompt, which is returned."""
        until = asyncio.get_running_loop().time() + timeout_s
        if self._config.echo:
            await self._pass_echo(text, until)
        if not self._config.prompt:
            return ""
        return "\n".join(await self._until_prompt(until))

    async def answer(self, text: str, timeout_s: float) -> str:
        """The next answer to `text`: a line, or all lines up to the prompt. Raises NoAnswer, OSError."""
        until = asyncio.get_running_loop().time() + timeout_s
        if self._config.echo:
            await self._pass_echo(text, until)
        return await self.next_answer(until)

    async def next_answer(self, until: float) -> str:
        """As `answer`, up to this time; a prompt alone is a late one, since a question has an answer."""
        if not self._config.prompt:
            return await self._line(until)
        while not (told := await self._until_prompt(until)):
            pass
        return "\n".join(told)

    async def _pass_echo(self, text: str, until: float) -> None:
        """Drop what it repeats, which ends as what is sent does; one that does not is forgiven."""
        buffer, sent = self.channel.received, re.escape(self._summed(text).strip())
        ends = {"\r\n", "\r", "\n", self._end.read or "\n", self._end.write}
        end, begin = (
            b"|".join(
                re.escape(one.strip(" ").encode("latin-1")) for one in sorted(marks, key=len)[::-1]
            )
            for marks in (ends, {*ends - {""}, *(self._config.prompts or "\n")})
        )
        begun = rb"(?:^|%s) *%s" % (begin, sent)
        while (found := re.search(rb"%s *(?:%s)" % (begun, end), buffer)) is None:
            whole = [self._decoded(line) for line in self._ending().split(bytes(buffer))[:-1]]
            if any(line.strip() and not self._ignored(line) for line in whole):
                found = re.search(begun, buffer)  # its answer stands behind it, on the same line
                break
            await self._more(until)
        if found is not None:
            del buffer[: found.end()]
            self._cut = False

    async def lines_after(
        self, first: str, wanted: int | str, timeout_s: float, *, json: bool = False
    ) -> list[str]:
        """An answer of so many lines, or up to one that a pattern finds.

        That is not part of it, unless it is the last bracket of JSON.
        """
        until = asyncio.get_running_loop().time() + timeout_s
        told = [first]
        last = regular_expression(wanted) if isinstance(wanted, str) else None
        most = wanted if isinstance(wanted, int) else MOST_LINES
        while len(told) < most and (last is None or last.search(told[-1]) is None):
            try:
                told.append(await self._line(until))
            except NoAnswer as fault:
                lines = f"{len(told)} lines, the last {told[-1][:80]!r}"
                raise NoAnswer(f"answered {lines}, and then {fault}") from fault
        whole = last is None or (json and told[-1].strip() in ("}", "]"))
        return told if whole else told[:-1]

    async def next_line(self, timeout_s: float) -> str:
        """One more line; raises NoAnswer, OSError."""
        return await self._line(asyncio.get_running_loop().time() + timeout_s)

    async def _line(self, until: float) -> str:
        wrong: NoAnswer | None = None
        while True:
            line = self._taken_line()
            if line is None and self._silence_s is not None and await self._is_over():
                line = self._decoded(self.channel.received)
                self.channel.received.clear()
            try:
                if line is None:
                    await self._more(until)
                elif (line if self._binary else line.strip()) and not self._ignored(line):
                    return self._checked(line)
            except NoAnswer as fault:
                if line is None or self.listening_for is None:
                    raise wrong or fault from fault
                wrong = fault  # of a stream, frames that are taken from the middle of two
                if self._frame is not None:
                    self.channel.received[:0] = self._encoded(line)[1:]

    async def _is_over(self) -> bool:
        """Something has come, and nothing more comes for as long as the lab says."""
        return bool(self.channel.received) and not await self.channel.more(self._silence_s or 0.0)

    def _ignored(self, line: str) -> bool:
        if self._ignore is None or self._ignore.search(line) is None:
            return False
        return self.listening_for is None or self.listening_for.fullmatch(line.strip()) is None

    def _checked(self, line: str) -> str:
        """The line without checksum and length; raises NoAnswer if the checksum is another line's."""
        sums, kept = self._config.checksum, self._encoded(line)
        if self._escapes:
            kept = self._unescaped(kept)
        if sums is not None and sums.answers:
            if self._frame is not None and not sums.first:  # the end stands behind its checksum
                kept = kept.removesuffix((self._end.read or "").encode("latin-1"))
            checked = sums.taken(kept if self._binary else kept.strip(b"\r\n"))
            if checked is None:
                raise NoAnswer(f"sent {line[:80]!r}, and its checksum is not that of the line")
            kept = checked
        if isinstance(self._frame, LengthFrame):
            kept = self._frame.without(kept, sums)
        return self._decoded(kept) if self._binary or sums is not None else line

    def _unescaped(self, line: bytes) -> bytes:
        meant = {instead: sign for sign, instead in self._escapes}
        found = re.compile(b"|".join(re.escape(one) for one in meant), re.DOTALL)
        return found.sub(lambda one: meant[one[0]], line)

    def _taken_line(self) -> str | None:
        buffer = self.channel.received
        if isinstance(self._frame, LengthFrame):
            whole = self._frame.taken(buffer)
            return None if whole is None else self._decoded(whole)
        if self._frame is not None:  # a pattern sees one sign for each byte
            framed = self.pattern(self._frame).search(buffer.decode("latin-1"))
            if framed is None:
                return None
            line = self._decoded(buffer[framed.start() : framed.end()])
            del buffer[: framed.end()]
            return line
        found = self._ending().search(buffer)
        if found is not None and self._cut and self._silence_s is None:
            del buffer[: found.end()]
            self._cut, found = False, self._ending().search(buffer)
        if found is None or self._silence_s is not None:
            return None
        line = self._decoded(buffer[: found.start()])
        del buffer[: found.end()]
        if self._end.begin:
            return line.rpartition(self._end.begin)[2]
        return line.strip("\0\r\n" if not (self._end.read or "").strip("\r\n") else "\0")

    def _ending(self) -> "re.Pattern[bytes]":
        end = self._end.read
        return re.compile(rb"\r\n|\n|\r" if end is None else re.escape(end.encode("latin-1")))

    async def _until_prompt(self, until: float) -> list[str]:
        prompts = self._config.prompts
        while True:
            *lines, last = self._ending().split(bytes(self.channel.received))
            if self._config.prompt_is_line and lines and not last.strip():
                last = lines.pop()
            if (prompt := self._decoded(last).strip()) in prompts:
                self.channel.received.clear()
                told = [self._decoded(line).strip() for line in lines]
                kept = [one for one in told if one and one not in prompts]
                if len(prompts) == 1:  # a device that echoes at its prompt shows both in one line
                    kept = [one.removeprefix(prompt).strip() for one in kept]
                kept = [one for one in kept if one and not self._ignored(one)]
                if prompts[1:]:  # which of several it is says how the instrument stands
                    self.prompted, kept = prompt, kept or [prompt]
                return [self._checked(one) for one in kept]
            await self._more(until)

    async def counted_bytes(self, text: str, kind: str, count: int, timeout_s: float) -> bytes:
        """So many bytes, or as many as a number such as `<u4` before them says; raises NoAnswer, OSError."""
        until = asyncio.get_running_loop().time() + timeout_s
        if self._config.echo:
            await self._pass_echo(text, until)
        head = size_of(kind) if kind else 0
        if kind:
            counted = (await self._at_least(head, until)).decode("latin-1")
            count = int(decimals(counted, {"bytes": kind})[0])
        if count > MOST_FRAME:
            raise NoAnswer(f"answered {self.heard[:60]!r}, which says that {count} bytes follow")
        return (await self._at_least(head + count, until, taken=True))[head:]

    def shown(self, text: str) -> str:
        """As a message shows it: of bytes none as a letter with an accent."""
        return ascii(text) if self._binary else repr(text)

    @property
    def heard(self) -> str:
        """What has come and was not taken."""
        return self._decoded(self.channel.received).strip()

    async def block(self, text: str, timeout_s: float) -> bytes:
        """A binary block of IEEE 488.2: `#` digits, length, data; `#0` goes on to the line's end."""
        until = asyncio.get_running_loop().time() + timeout_s
        buffer = self.channel.received
        while (start := buffer.find(b"#")) < 0:
            if (line := self._taken_line()) and line.strip() not in ("", text.strip()):
                raise NoAnswer(f"answered {line[:60]!r}, which is no binary block")
            await self._more(until)
        head = start + 2
        digits = (await self._at_least(head, until))[-1:]
        if digits == b"0":
            while not buffer.endswith(b"\n"):
                await self._more(until)
            data = bytes(buffer[head:-1])
            buffer.clear()
            return data
        begin = head + int(digits) if digits.isdigit() else head
        counted = (await self._at_least(begin, until))[head:]
        if not counted.isdigit():
            raise NoAnswer(f"answered {self._decoded(buffer[:60])!r}, which is no binary block")
        return (await self._at_least(begin + int(counted), until, taken=True))[begin:]

    async def _at_least(self, size: int, until: float, *, taken: bool = False) -> bytes:
        """The first bytes of what comes, so many; left where they are unless `taken`."""
        while (told := len(self.channel.received)) < size:
            try:
                await self._more(until)
            except NoAnswer:
                if not told:
                    raise
                raise NoAnswer(f"sent {told} of {size} bytes: {self.heard[:60]!r}") from None
        data = bytes(self.channel.received[:size])
        if taken:
            del self.channel.received[:size]
        return data

    async def _more(self, until: float) -> None:
        left = until - asyncio.get_running_loop().time()
        if left <= 0 or not await self.channel.more(left):
            without = "a whole `frame`" if self._frame else "a line end"
            without = "its `prompt`" if self._config.prompt else without
            told = (
                f"sent {self.shown(self.heard[:80])} without {without}"
                if self.heard
                else "was silent"
            )
            raise NoAnswer(told)

    def _encoded(self, text: str) -> bytes:
        return text.encode(self._config.encoding, "replace")

    def _decoded(self, data: bytes | bytearray) -> str:
        return bytes(data).decode(self._config.encoding, "backslashreplace")

    def __str__(self) -> str:
        return f"{self._device} at {self.resource}"


def channel_of(place: Place, config: LineConfig) -> Channel:
    """The bytes to and from what a config names; not open yet."""
    resource = read_resource(config.resource)
    if resource.kind == "visa":
        return Visa(resource, config.visa_library)
    if resource.kind == "ws":
        return Messages(resource)
    if resource.kind != "serial":
        return Network(resource, config.local_port)
    keys = ("baud", "bits", "parity", "stop_bits")
    framing: dict[str, Any] = {key: getattr(config, key) for key in keys}
    there = Place(place.device, {"port": resource.name, **framing}, {}, place.folder, place.world)
    return Serial(resource, read_port(there), config.flow)
