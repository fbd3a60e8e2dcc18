"""A file as plain data, with the place of every key and value."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...schemas.problem import Problem, Severity, severity_of
from .file_text import LARGEST, file_text
from .yaml_lines import Lines
from .yaml_looks import program
from .yaml_node import Node, YamlFault
from .yaml_read import read_nodes
from .yaml_traps import key_hint, traps, value_hint

__all__ = ["CODES", "LARGEST", "Path_", "Source", "parse_source", "read_source"]

Path_ = tuple[str | int, ...]

CODES = {
    "E100": "a file that cannot be read",
    "E101": "text that is not YAML, or not JSON",
    "E102": "a duplicate key",
    "E103": "a key that is not a word",
    "E104": "an alias without its anchor, or a merge of something that is not a mapping",
    "E105": "a YAML tag or directive",
    "E106": "not a usable number: NaN, infinity, too many digits; or half of a character",
    "E107": "several documents in one file",
    "E108": "a file that is too large or nested too deeply",
    "E109": "an expression that YAML reads as something else",
    "W101": "braces without a `$`: text that looks like an expression",
    "W102": "a number that begins with a zero",
    "W103": "curly quotes from a word processor, which are part of the text",
    "W105": "a number behind a # that YAML takes for a comment",
    "W104": "a word with & that YAML takes out of a text, as an anchor",
}
OF_VALUES = {
    "E112",
    "E113",
    "E131",
    "E204",
    "E206",
    "E207",
    "E221",
    "E222",
    "E224",
    "E300",
    "E307",
    "E308",
    "E309",
}
"""Problems that the way the value is written may explain."""


@dataclass(slots=True)
class Source:
    """One file: its text, its data, and the place of everything in it."""

    path: Path
    name: str
    text: str
    data: Any = None
    root: Node | None = None
    lines: Lines = field(init=False)

    def __post_init__(self) -> None:
        self.lines = Lines(self.text)

    def place(self, path: Path_, *, key: bool = False) -> tuple[int, int, int]:
        """Line, column (both from 1) and length of a value, or of its key.

        If there is nothing at the path, the place of what would contain it.
        """
        node = self.root
        if node is None:
            return 1, 1, 1
        span = (node.start, node.end)
        for depth, part in enumerate(path, 1):
            inner = _inside(node, part)
            if inner is None:
                break
            span = (inner.start, inner.end)
            if node.keys is not None and (inner.start == inner.end or (key and depth == len(path))):
                span = node.keys[str(part)]
            node = inner
        return self.lines.span(*span)

    def names(self, section: str) -> list[str]:
        """The keys of a section such as `params`, including entries that could not be read."""
        found = self.data.get(section) if isinstance(self.data, dict) else None
        return list(found) if isinstance(found, dict) else []

    def problem(
        self, path: Path_, code: str, message: str, hint: str = "",
        *, key: bool = False, severity: Severity | None = None,
    ) -> Problem:  # fmt: skip
        """A problem at the place of a value, or of its key; the hint may say how YAML reads it.

        Its code says how severe it is, unless `severity` does.
        """
        line, column, length = self.place(path, key=key)
        more = self._key_hint(path) if key else self._value_hint(path, code, message)
        hint = more or hint
        return Problem(
            file=self.name, line=line, column=column, length=length,
            severity=severity or severity_of(code), code=code, message=message, hint=hint,
        )  # fmt: skip

    def _value_hint(self, path: Path_, code: str, message: str) -> str:
        node = self.node(path) if code in OF_VALUES else None
        if node is None:
            return ""
        return value_hint(node, self.text[node.start : node.end], message)

    def _key_hint(self, path: Path_) -> str:
        node = self.node(path[:-1])
        if node is None or not path or node.keys is None or str(path[-1]) not in node.keys:
            return ""
        return key_hint(str(path[-1]), self.text, *node.keys[str(path[-1])])

    def node(self, path: Path_) -> Node | None:
        """The node at a path; None where there is nothing."""
        node = self.root
        for part in path:
            node = _inside(node, part) if node is not None else None
        return node


def _inside(node: Node, part: str | int) -> Node | None:
    """The member or item of a node; None where there is nothing."""
    if node.members is not None:
        return node.members.get(str(part))
    if node.items is None or not isinstance(part, int) or not 0 <= part < len(node.items):
        return None
    return node.items[part]


def read_source(path: Path) -> tuple[Source | None, list[Problem]]:
    """A file as a Source, and its YAML problems.

    The Source is None if nothing could be read.
    """
    text = file_text(path)
    if isinstance(text, str):
        return parse_source(text, path, str(path))
    problem = Problem(
        file=str(path), line=text.line, column=text.column,
        code=text.code, message=text.message, hint=text.hint,
    )  # fmt: skip
    return None, [problem]


def parse_source(text: str, path: Path, name: str) -> tuple[Source | None, list[Problem]]:
    """Text as a Source; `name` is the file's name in problems."""
    source = Source(path, name, text.removeprefix("\ufeff"))
    root, faults, whole = read_nodes(source.text, source.lines, json=path.suffix.lower() == ".json")
    if root is not None and isinstance(root.value, str) and (found := program(text)):
        root, faults = None, [found]
    if root is not None and whole:
        faults += traps(root, source.text)
    if not faults and (root is None or root.value is None):
        hint = "`labrun new NAME` creates one to start from"
        faults, whole = [YamlFault("E100", "the file is empty", 0, hint)], False
    if root is not None and whole:
        source.root, source.data = root, root.value
    problems = [_problem(source, fault) for fault in faults]
    return (source if source.root is not None else None), problems


def _problem(source: Source, fault: YamlFault) -> Problem:
    start = min(fault.start, len(source.text))
    line, column, length = source.lines.span(start, start + max(1, fault.length))
    message = fault.message
    if fault.first is not None:
        message += f"; it is already in line {source.lines.place(fault.first)[0]}"
    return Problem(
        file=source.name, line=line, column=column, length=length,
        severity=severity_of(fault.code),
        code=fault.code, message=message, hint=fault.hint,
    )  # fmt: skip
