"""Format a file: read it, compare, and write all of it or nothing."""

import sys
from dataclasses import dataclass, field
from difflib import unified_diff
from pathlib import Path

from ...schemas.problem import Problem
from ...system.files import write_whole
from ..language.file_text import Unread, decoded, file_text
from .yaml import MeaningChanged, format_text

STDIN = Path("-")


@dataclass(slots=True)
class Formatted:
    """A file before and after formatting; the same text twice if nothing has to change."""

    name: str
    before: str = ""
    after: str = ""
    problems: list[Problem] = field(default_factory=list)

    @property
    def changed(self) -> bool:
        """True if there is something to write."""
        return self.after != self.before

    def diff(self) -> str:
        """What would change, as `diff -u` shows it."""
        before, after = self.before.splitlines(), self.after.splitlines()
        lines = unified_diff(before, after, self.name, f"{self.name} (formatted)", lineterm="")
        return "".join(f"{line}\n" for line in lines)


def formatted(path: Path) -> Formatted:
    """A formatted file, or `-` for stdin, or the problems that prevent formatting."""
    name = "<stdin>" if path == STDIN else str(path)
    text = decoded(sys.stdin.buffer.read()) if path == STDIN else file_text(path)
    if isinstance(text, Unread):
        return Formatted(name, problems=[_problem(name, text)])
    try:
        after, problems = format_text(text, name)
    except MeaningChanged as fault:
        message = f"the file was not changed: formatting would change its meaning ({fault})"
        hint = "this is an internal error in labrun; please report it with the file"
        return Formatted(name, text, text, [_problem(name, Unread(message, hint))])
    return Formatted(name, text, after, problems)


def replace_text(path: Path, text: str) -> Problem | None:
    """Write a whole file or leave it unchanged; its permissions and links are kept."""
    try:
        write_whole(path, text.encode())
    except OSError as fault:
        return _problem(str(path), Unread(f"the file cannot be written: {fault.strerror or fault}"))
    return None


def _problem(name: str, unread: Unread) -> Problem:
    return Problem(
        file=name, line=unread.line, column=unread.column,
        code=unread.code, message=unread.message, hint=unread.hint,
    )  # fmt: skip
