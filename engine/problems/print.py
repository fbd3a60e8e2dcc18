"""Print problems as text, as JSON, or as annotations of a GitHub workflow."""

import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO, Literal
from unicodedata import combining, east_asian_width

from ...schemas.problem import Problem

Format = Literal["text", "json", "github"]
MOST = 200
WIDEST = 160
RED, YELLOW, BLUE, BOLD, PLAIN = "\033[31m", "\033[33m", "\033[34m", "\033[1m", "\033[0m"


def print_problems(
    problems: Sequence[Problem], *, format: Format | str = "text", file: IO[str] | None = None,
    texts: Mapping[str, str] | None = None,
) -> None:  # fmt: skip
    """Print problems, in colour only if `file` (stdout by default) is a terminal.

    `texts`: file -> text, of what is in no file.
    """
    out = file if file is not None else sys.stdout
    if format == "json":
        print(
            json.dumps(
                [problem.model_dump() for problem in problems], indent=1, ensure_ascii=False
            ),
            file=out,
        )
        return
    if format == "github":
        for problem in problems:
            print(_annotation(problem), file=out)
        return
    _print_text(problems, out, SourceLines(texts))


def _print_text(problems: Sequence[Problem], out: IO[str], lines: "SourceLines") -> None:
    colours = out.isatty() and "NO_COLOR" not in os.environ
    for problem in problems[:MOST]:
        for line in _text(problem, lines.line(problem), colours):
            _say(line, out)
    if len(problems) > MOST:
        _say(f"... and {len(problems) - MOST} more", out)
    if problems:
        _say(count_line(problems), out)


def _say(line: str, out: IO[str]) -> None:
    try:
        print(line, file=out)
    except UnicodeEncodeError:  # a terminal that is not UTF-8
        encoding = getattr(out, "encoding", None) or "ascii"
        print(line.encode(encoding, "backslashreplace").decode(encoding), file=out)


def count_line(problems: Iterable[Problem]) -> str:
    """`2 errors, 1 warning. Nothing was sent to any device.`"""
    kinds = [problem.severity for problem in problems]
    counts = []
    for kind in ("error", "warning"):
        number = kinds.count(kind)
        if number:
            counts.append(f"{number} {kind}{'s' if number > 1 else ''}")
    nothing = " Nothing was sent to any device." if "error" in kinds else ""
    return f"{', '.join(counts)}.{nothing}"


class SourceLines:
    """The source lines that problems point at; each file is read once."""

    def __init__(self, texts: Mapping[str, str] | None = None) -> None:
        self._files = {name: text.split("\n") for name, text in (texts or {}).items()}

    def line(self, problem: Problem) -> str | None:
        """The line of a problem; None where its file cannot be read."""
        if problem.file not in self._files:
            self._files[problem.file] = _read_lines(problem.file)
        lines = self._files[problem.file]
        return lines[problem.line - 1] if problem.line <= len(lines) else None


def _read_lines(name: str) -> list[str]:
    from ..language.source import LARGEST

    path = Path(name)
    try:
        if not path.is_file() or path.stat().st_size > LARGEST:
            return []
        text = path.read_bytes().decode("utf-8").removeprefix("\ufeff")
    except (OSError, ValueError):
        return []
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _text(problem: Problem, line: str | None, colours: bool) -> Iterable[str]:
    def paint(colour: str, text: str) -> str:
        return f"{colour}{text}{PLAIN}" if colours else text

    colour = RED if problem.severity == "error" else YELLOW
    place = f"{problem.file}:{problem.line}:{problem.column}:"
    if problem.file.startswith("-"):
        place = f"{problem.file}:"
    kind = paint(colour, f"{problem.severity}[{problem.code}]")
    yield f"{paint(BOLD, place)} {kind} {_one_line(problem.message)}"
    if line is not None and line.strip():
        yield from _excerpt(problem, line, lambda text: paint(colour, text))
    if problem.hint:
        yield f"   {paint(BLUE, '=')} {_one_line(problem.hint)}"


def _excerpt(problem: Problem, line: str, paint) -> Iterable[str]:
    """The line with carets under the error; of a very long line, the part around it."""
    start = max(0, problem.column - 1 - WIDEST // 2) if len(line) > WIDEST else 0
    shown = "".join(c if c.isprintable() else " " for c in line[start : start + WIDEST])
    at = problem.column - 1 - start
    before = _width(shown[:at]) + max(0, at - len(shown))
    carets = "^" * max(1, _width(shown[at : at + problem.length]))
    number = f"{problem.line:>5}"
    yield f"{number} | {shown}"
    yield f"{' ' * len(number)} | {' ' * before}{paint(carets)}"


def _width(text: str) -> int:
    """The terminal columns that a text takes: Chinese characters two, combining accents none."""
    if text.isascii():
        return len(text)
    wide = sum(east_asian_width(c) in "WF" for c in text)
    return len(text) + wide - sum(combining(c) > 0 for c in text)


def _one_line(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


def _annotation(problem: Problem) -> str:
    text = problem.message + (f"\n{problem.hint}" if problem.hint else "")
    place = f"file={_escape(problem.file)},line={problem.line},col={problem.column}"
    title = _escape(problem.code)
    return f"::{problem.severity} {place},title={title}::{_escape(text, value=True)}"


def _escape(text: str, *, value: bool = False) -> str:
    text = text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    return text if value else text.replace(":", "%3A").replace(",", "%2C")
