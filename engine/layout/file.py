"""A file in even form: read, compared, and written whole or not at all."""

import os
import shutil
import sys
from dataclasses import dataclass, field
from difflib import unified_diff
from pathlib import Path

from ...schemas.problem import Problem
from ..language.file_text import Unread, decoded, file_text
from .yaml import MeaningChanged, format_text

STDIN = Path("-")


@dataclass(slots=True)
class Formatted:
    """A file as it is and in even form; the same text twice where nothing is to be done."""

    name: str
    before: str = ""
    after: str = ""
    problems: list[Problem] = field(default_factory=list)

    @property
    def changed(self) -> bool:
        """True where there is something to write."""
        return self.after != self.before

    def diff(self) -> str:
        """What would change, as `diff -u` shows it."""
        before, after = self.before.splitlines(), self.after.splitlines()
        lines = unified_diff(before, after, self.name, f"{self.name} (even)", lineterm="")
        return "".join(f"{line}\n" for line in lines)


def formatted(path: Path) -> Formatted:
    """A file, or `-` for stdin, in even form; with the problems that keep it from having one."""
    name = "<stdin>" if path == STDIN else str(path)
    text = decoded(sys.stdin.buffer.read()) if path == STDIN else file_text(path)
    if isinstance(text, Unread):
        return Formatted(name, problems=[_problem(name, text)])
    try:
        after, problems = format_text(text, name)
    except MeaningChanged as fault:
        message = f"the file stays as it is: in even form it would mean something else ({fault})"
        hint = "please report it with the file; this is labrun's fault"
        return Formatted(name, text, text, [_problem(name, Unread(message, hint))])
    return Formatted(name, text, after, problems)


def write_whole(path: Path, text: str) -> Problem | None:
    """Write a file with all of its text or leave it as it was; its rights and links stay."""
    place = path.resolve()
    half = place.with_name(f".{place.name}.{os.getpid()}.part")
    try:
        with half.open("xb") as file:
            file.write(text.encode())
            file.flush()
            os.fsync(file.fileno())
        shutil.copymode(place, half)
        half.replace(place)
    except OSError as fault:
        half.unlink(missing_ok=True)
        return _problem(str(path), Unread(f"the file cannot be written: {fault.strerror or fault}"))
    return None


def _problem(name: str, unread: Unread) -> Problem:
    return Problem(
        file=name, line=unread.line, column=unread.column,
        code=unread.code, message=unread.message, hint=unread.hint,
    )  # fmt: skip
