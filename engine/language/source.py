"""A file that a person wrote, as plain data with the place of every key and value."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...schemas.problem import Problem, Severity
from .yaml_tree import Composer, Lines, Node, YamlFault
from .yaml_words import in_words

LARGEST = 10_000_000
"""Bytes; a protocol of a thousand lines has forty thousand."""

Path_ = tuple[str | int, ...]

CODES = {
    "E100": "a file that cannot be read",
    "E101": "text that is not YAML",
    "E102": "a key that is there twice",
    "E103": "a key that is no word",
    "E104": "an alias without its anchor",
    "E105": "a YAML tag",
    "E106": "a number that is none: NaN, infinity, too many digits",
    "E107": "several documents in one file",
    "E108": "a file that is too large or nested too deeply",
}


@dataclass(slots=True)
class Source:
    """One file: its text, its data, and where everything stands."""

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

        Where nothing stands at the path, the place of what it would stand in.
        """
        node, span = self.root, (0, 0)
        if node is None:
            return 1, 1, 1
        span = (node.start, node.end)
        for depth, part in enumerate(path):
            if node.members is not None and str(part) in node.members:
                at_key = key and depth == len(path) - 1
                span = node.keys[str(part)]
                node = node.members[str(part)]
                if not at_key:
                    span = (node.start, node.end) if node.end > node.start else span
            elif node.items is not None and isinstance(part, int) and 0 <= part < len(node.items):
                node = node.items[part]
                span = (node.start, node.end)
            else:
                break
        return self.lines.span(*span)

    def names(self, section: str) -> list[str]:
        """The keys of a section such as `params`, also of entries that could not be read."""
        found = self.data.get(section) if isinstance(self.data, dict) else None
        return list(found) if isinstance(found, dict) else []

    def problem(
        self, path: Path_, code: str, message: str, hint: str = "",
        *, key: bool = False, severity: Severity = "error",
    ) -> Problem:  # fmt: skip
        """A problem at the place of a value, or of its key."""
        line, column, length = self.place(path, key=key)
        return Problem(
            file=self.name, line=line, column=column, length=length, severity=severity,
            code=code, message=message, hint=hint,
        )  # fmt: skip


def read_source(path: Path) -> tuple[Source | None, list[Problem]]:
    """A file as a Source, and what is wrong with it as YAML.

    The Source is None where there is nothing to go on with.
    """
    text, problem = _read_text(path)
    if problem is not None:
        return None, [problem]
    return parse_source(text, path, str(path))


def parse_source(text: str, path: Path, name: str) -> tuple[Source | None, list[Problem]]:
    """Text as a Source; `name` is what problems call the file."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    source = Source(path, name, text.removeprefix("\ufeff"))
    composer = Composer()
    faults = composer.faults
    whole = True
    try:
        for event in YAML(typ="safe", pure=True).parse(source.text):
            composer.take(event)
    except YamlFault as fault:
        faults.append(fault)
        whole = False
    except (YAMLError, ValueError, IndexError, AttributeError, TypeError, AssertionError) as fault:
        # ruamel's scanner lets bare ValueErrors and worse fall out on odd escapes and directives.
        faults.append(in_words(fault, source.lines))
        whole = False
    if whole and (composer.root is None or composer.root.value is None) and not faults:
        faults.append(
            YamlFault("E100", "the file is empty", 0, "`labrun new NAME` makes one to start from")
        )
        whole = False
    problems = [_problem(source, fault) for fault in faults]
    if not whole or composer.root is None:
        return None, problems
    source.root, source.data = composer.root, composer.root.value
    return source, problems


def _problem(source: Source, fault: YamlFault) -> Problem:
    start = min(fault.start, len(source.text))
    line, column, length = source.lines.span(start, start + max(1, fault.length))
    return Problem(
        file=source.name, line=line, column=column, length=length,
        code=fault.code, message=fault.message, hint=fault.hint,
    )  # fmt: skip


def _read_text(path: Path) -> tuple[str, Problem | None]:
    def refused(
        message: str, hint: str = "", line: int = 1, column: int = 1
    ) -> tuple[str, Problem]:
        problem = Problem(
            file=str(path), line=line, column=column, code="E100", message=message, hint=hint
        )
        return "", problem

    try:
        if path.is_dir():
            return refused("this is a folder, not a file")
        if not path.is_file():
            return refused(*_missing(path))
        size = path.stat().st_size
        if size > LARGEST:
            message = f"the file has {size / 1e6:,.0f} MB; {LARGEST / 1e6:.0f} MB is the most"
            return "", Problem(file=str(path), line=1, column=1, code="E108", message=message)
        data = path.read_bytes()
    except (OSError, ValueError) as fault:
        return refused(f"the file cannot be read: {getattr(fault, 'strerror', None) or fault}")
    try:
        return data.decode("utf-8"), None
    except UnicodeDecodeError as fault:
        before = data[: fault.start]
        line = before.count(b"\n") + 1
        column = len(before.rpartition(b"\n")[2].decode("utf-8", "replace")) + 1
        return refused(
            "the file is not UTF-8 text", "save it with the encoding UTF-8", line, column
        )


def _missing(path: Path) -> tuple[str, str]:
    from .suggest import closest

    if path.exists():
        return "this is not a plain file", ""
    try:
        near = closest(path.name, (entry.name for entry in path.parent.iterdir()))
    except OSError:
        near = None
    return "there is no such file", f"did you mean {near}?" if near else ""
