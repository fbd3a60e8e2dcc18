"""Parse one line of a GRBL controller, even with noise in front of it."""

import re
from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "ok",
    "error",
    "alarm",
    "banner",
    "report",
    "message",
    "setting",
    "options",
    "probe",
    "modes",
    "other",
]

LONGEST = 1024  # a line without an end is noise

PATTERNS: tuple[tuple[Kind, re.Pattern[str]], ...] = (
    ("banner", re.compile(r"(Grbl(?:HAL)? \d+\.\d+\w*) \[(FluidNC \S+)?.*")),
    ("report", re.compile(r"(<[A-Z][a-z]+(?::\d+)?\|[^<>]*>)$")),
    ("message", re.compile(r"\[MSG:(.*)\]$")),
    ("alarm", re.compile(r"ALARM:(\d+)$")),
    ("error", re.compile(r"error:(\d+)$")),
    ("options", re.compile(r"\[OPT:(.*)\]$")),
    ("probe", re.compile(r"\[PRB:(.*)\]$")),
    ("modes", re.compile(r"\[GC:(.*)\]$")),
    ("setting", re.compile(r"^\$((?:\d+|/axes/\S+)=\S+)")),
    # Noise may precede the `ok`; a text that ends so by chance contains a mark of its own kind.
    ("ok", re.compile(r"^[^|:=]*(ok)$")),
)


@dataclass(frozen=True, slots=True)
class ParsedLine:
    """A line by kind: `text` is its relevant part, `code` the number of an error or alarm."""

    kind: Kind
    text: str
    code: int = 0


def understand(line: str) -> ParsedLine:
    """The meaning of one line without its line end; anything unknown is `other`.

    A start-up line of the controller (`>G20:ok`, `>FOO:error:2`) is not an answer to our lines.
    """
    if line.startswith(">"):
        return ParsedLine("other", line)
    for kind, pattern in PATTERNS:
        if found := pattern.search(line):
            text = " ".join(part for part in found.groups() if part)
            return ParsedLine(kind, text, int(text) if kind in ("alarm", "error") else 0)
    return ParsedLine("other", line)


class Lines:
    """Splits incoming bytes into lines; `unreadable` counts the bytes that are not text."""

    def __init__(self) -> None:
        self.unreadable = 0
        self._rest = b""

    def cut(self, data: bytes) -> list[str]:
        """The lines that are complete, without empty ones."""
        *whole, self._rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        if len(self._rest) > LONGEST:
            self.unreadable += len(self._rest)
            self._rest = b""
        return [text for line in whole if (text := self._text(line))]

    def _text(self, line: bytes) -> str:
        readable = bytes(byte for byte in line if 0x20 <= byte < 0x7F)
        self.unreadable += len(line) - len(readable)
        return readable.decode("ascii").strip()

    @property
    def rest(self) -> bytes:
        """The start of a line that has no end yet."""
        return self._rest
