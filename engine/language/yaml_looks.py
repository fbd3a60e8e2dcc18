"""Find visible reasons why a parser fails at a line: tabs, `${{`, odd spaces."""

import re

from .yaml_characters import named, odd_characters
from .yaml_lines import Lines
from .yaml_node import YamlFault, shown
from .yaml_traps import colon_for

TAB = re.compile(r"[ ]*(?:-[ ]*)*(\t)")
TAB_AFTER = re.compile(r"[^\"'#]*[:,-][ ]*(\t)")
EXPRESSION = re.compile(r"\$\{\{.*?(\}\}|$)")
GIVEN = re.compile(r"([A-Za-z_]\w*) ?= ?[\"']?$")
CUT = re.compile(r"(\$\{\{(?:(?!\}\}).)*?)\s#")
ODD_SPACE = re.compile(
    r"\s*?(?:-\s*)*([\u00a0\u202f\u2009\u3000\u200b\ufeff])|[^'\"#]*?[:-]([\u00a0\u202f\u3000])"
)
WIDE_COLON = re.compile(r"\s*(?:- +)*\w+(：)")
NO_SPACE = re.compile(r"\s*(?:- +)*(([A-Za-z_]\w*):([^\s:/#][^#]*))(?:#|$)")
OPENED = re.compile(r"(?:^|[\s\[{,])((['\"])(?:(?!\2).)*)$")
"""A quote that is opened in a line and not closed in it."""
CLOSED = re.compile(r"(?:[:,-]\s+|[\[{])(['\"])")
CURLY = "“”„«»‘’"
REMARK = re.compile(r"\s*(//|/\*|%|;|--(?!-))")
"""How other languages begin a comment."""
FENCE = re.compile(r"\s*(?:```|~~~)")
CONFLICT = re.compile(r"^<{7}(?: |$).*", re.MULTILINE)
PROGRAM = re.compile(r"(?:from [\w.]+ )?import \w|def \w+\(|#!.*python")


def looks(lines: Lines, offset: int, *, flow: bool) -> YamlFault | None:
    """The reason visible in the line of a fault or the one above it; None if there is none."""
    number = lines.place(offset)[0]
    here = (number, lines.line(number))
    above = next(
        ((n, lines.line(n)) for n in range(number - 1, 0, -1) if lines.line(n).strip()), None
    )
    column = offset - lines.starts[number - 1]
    return (
        program(lines.text)
        or _conflict(lines.text)
        or _fence(lines, *here)
        or _tab(lines, *here)
        or _open_quote(lines, *here, column)
        or (_bare_expression(lines, *here, column) if flow else None)
        or _in_either(lines, here, above)
    )


def program(text: str) -> YamlFault | None:
    """A Python program where YAML is expected."""
    begun = re.search(r"^(?!#[^!]|#$)\S", text, re.MULTILINE)
    if begun is None or not PROGRAM.match(text, begun.start()):
        return None
    return YamlFault("E113", "this is a Python program, not YAML", begun.start(),
                     "protocols and labs are YAML files; `labrun new NAME` writes a protocol")  # fmt: skip


def _conflict(text: str) -> YamlFault | None:
    """Two versions of a file that git could not merge."""
    match = CONFLICT.search(text)
    if match is None:
        return None
    return YamlFault("E101", "git has marked a conflict here", match.start(),
                     "keep one of the two versions, and remove the lines <<<<<<<, ======= and >>>>>>>",
                     len(match[0].rstrip()))  # fmt: skip


def _fence(lines: Lines, number: int, line: str) -> YamlFault | None:
    """Markdown around YAML, as an assistant answers."""
    if not FENCE.match(line):
        return None
    return YamlFault("E101", "a fence of Markdown, which is not YAML", lines.starts[number - 1],
                     "keep only what is between the two fences", len(line.rstrip()))  # fmt: skip


def _in_either(
    lines: Lines, here: tuple[int, str], above: tuple[int, str] | None
) -> YamlFault | None:
    for look in (_remark, _cut, _odd, _no_space):
        for line in (here, above):
            found = look(lines, *line) if line is not None else None
            if found is not None:
                return found
    return None


def _tab(lines: Lines, number: int, line: str) -> YamlFault | None:
    match = TAB.match(line) or TAB_AFTER.match(line)
    return tab(lines.starts[number - 1] + match.start(1)) if match is not None else None


def tab(offset: int) -> YamlFault:
    """A tab where only spaces are allowed."""
    return YamlFault("E101", "a tab; YAML is indented with spaces", offset,
                     "replace the tab with spaces; most editors can do this")  # fmt: skip


def _open_quote(lines: Lines, number: int, line: str, column: int) -> YamlFault | None:
    """A quote that was meant to open a text, and closes one that was left open further up."""
    first = CLOSED.search(line, 0, column)
    if first is None:
        return None
    for above in range(number - 1, 0, -1):
        found = OPENED.search(lines.line(above))
        if found is not None and found[2] == first[1]:
            at = lines.starts[above - 1] + found.start(1)
            hint = f"close it; the text now goes on to the {first[1]} in line {number}"
            return YamlFault(
                "E101", "a quote that is never closed on its line", at, hint, len(found[1].rstrip())
            )
        if first[1] in lines.line(above):
            return None
    return None


def _bare_expression(lines: Lines, number: int, line: str, column: int) -> YamlFault | None:
    """`{x: ${{ p }}}`: between brackets, a brace is a brace."""
    begun = max((m.start() for m in EXPRESSION.finditer(line) if m.start() <= column), default=-1)
    if begun < 0:
        return None
    match = EXPRESSION.match(line, begun)
    assert match is not None
    if given := GIVEN.search(line, 0, begun):
        at = lines.starts[number - 1] + given.start()
        words = "a value without a colon before it"
        return YamlFault("E101", words, at, colon_for(given[1]), len(given[1]))
    quote = "'" if '"' in match[0] else '"'
    hint = f"write {quote}{shown(match[0])}{quote}"
    if line[begun - 1 : begun] in CURLY and begun:
        hint = f"{named(line[begun - 1])} is not a quote in YAML; {hint}"
    return YamlFault(
        "E101", "an expression without quotes between brackets", lines.starts[number - 1] + begun,
        f"inside {{...}} or [...] an expression needs quotes: {hint}", len(match[0]),
    )  # fmt: skip


def _remark(lines: Lines, number: int, line: str) -> YamlFault | None:
    match = REMARK.match(line)
    if match is None:
        return None
    at = lines.starts[number - 1] + match.start(1)
    words = f"`{match[1]}` begins no comment in YAML"
    return YamlFault("E101", words, at, "a comment begins with `#`", len(match[1]))


def _cut(lines: Lines, number: int, line: str) -> YamlFault | None:
    match = CUT.search(line)
    if match is None:
        return None
    return YamlFault(
        "E109", "a `#` after a space begins a comment, so this expression is cut off",
        lines.starts[number - 1] + match.start(),
        "put the whole value in quotes, or the comment after the `}}`", len(match[1]),
    )  # fmt: skip


def _odd(lines: Lines, number: int, line: str) -> YamlFault | None:
    match = ODD_SPACE.match(line) or WIDE_COLON.match(line)
    if match is None:
        return None
    at = match.end(match.lastindex or 0) - 1
    hint = odd_characters(line[at]).removeprefix("it holds ")
    message = f"{named(line[at])} is not what YAML needs here"
    return YamlFault(
        "E101", message, lines.starts[number - 1] + at, hint.partition("; ")[2]
    )  # fmt: skip


def _no_space(lines: Lines, number: int, line: str) -> YamlFault | None:
    match = NO_SPACE.match(line)
    if match is None:
        return None
    return YamlFault(
        "E101", "a space is missing after the colon", lines.starts[number - 1] + match.start(1),
        f"write `{match[2]}: {shown(match[3].strip())}`", len(match[1].rstrip()),
    )  # fmt: skip
