"""What the YAML parser complains of, said in the words of a person who writes protocols."""

import re
from typing import Any

from .yaml_tree import Lines, YamlFault

NO_TOKEN = re.compile(r"found character '(.+)' that cannot start any token")
GOT = re.compile(r"but (?:got|found) \(?'?([^',)]+)'?")
QUOTE_EXPRESSION = 'inside `{...}` or `[...]` an expression needs quotes: {x: "${{ ... }}"}'
QUOTE_TEXT = 'put the text between quotes, such as "..."'


def in_words(fault: Any, lines: Lines) -> YamlFault:
    """A fault of ruamel.yaml as a problem with a place and a way out."""
    mark = getattr(fault, "problem_mark", None) or getattr(fault, "context_mark", None)
    if mark is None:
        return _unreadable(fault)
    offset = min(mark.index, max(0, len(lines.text) - 1))
    said = str(getattr(fault, "problem", None) or getattr(fault, "context", None) or fault)
    context = str(getattr(fault, "context", None) or "")
    message, hint = _translate(said, context, lines, offset)
    if "never closed" in message and fault.context_mark is not None:
        offset = fault.context_mark.index
    return YamlFault("E101", message, offset, hint)


def _unreadable(fault: Any) -> YamlFault:
    character = getattr(fault, "character", None)
    position = int(getattr(fault, "position", 0) or 0)
    code = character if isinstance(character, int) else ord(str(character or "\0")[0])
    message = f"a character that no text editor shows (U+{code:04X}) stands here"
    return YamlFault(
        "E101", message, position, "remove it, or write it as \\xNN inside double quotes"
    )


def _translate(said: str, context: str, lines: Lines, offset: int) -> tuple[str, str]:
    line = lines.line(lines.place(offset)[0])
    if match := NO_TOKEN.search(said):
        return _bad_start(match[1])
    if "flow" in context and "quoted" not in context:
        return _flow(said, context, line)
    if "mapping values are not allowed" in said:
        return _colon(line, offset - lines.starts[lines.place(offset)[0] - 1])
    if "quoted scalar" in context:
        return _quoted(said)
    if "could not find expected ':'" in said:
        return "a key without its `:`", "write `key: value`, with a space after the colon"
    if "expected <block end>" in said:
        return _block_end(said, context)
    if "document start" in said or "document end" in said:
        return "this does not go on what stands before it", "is a `:` or a quote out of place?"
    if "tag" in said:
        return "a tag (`!...`) that is not known", "write the value without a tag"
    return f"not YAML: {said.strip()}", ""


def _bad_start(character: str) -> tuple[str, str]:
    if character in ("\\t", "\t"):
        return "a tab; YAML is indented with spaces", "replace the tab by spaces"
    return f"a text cannot begin with {character}", QUOTE_TEXT


def _flow(said: str, context: str, line: str) -> tuple[str, str]:
    closing = "}" if "mapping" in context else "]"
    got = GOT.search(said)
    if "${{" in line and got is not None and got[1] in ("{", "}", "["):
        return "an expression without quotes between brackets", QUOTE_EXPRESSION
    if got is not None and got[1].startswith("<stream end"):
        return f"a bracket that is never closed; {closing} is missing", f"close it with {closing}"
    if "expected the node content" in said:
        return "a bracket or comma where a value should stand", QUOTE_TEXT
    return (
        f"a comma or {closing} is missing before this",
        f"or the bracket is never closed: {closing}",
    )


def _colon(line: str, column: int) -> tuple[str, str]:
    before = line[:column]
    if re.search(r"(^\s*|[-{,]\s+)[^:\s]+:\s+\S", before):
        return "a second `: ` in one line", QUOTE_TEXT + ", when it has a colon followed by a space"
    return "a key that is indented further than the line before it allows", "line keys up"


def _quoted(said: str) -> tuple[str, str]:
    if "escape" in said or "hexdecimal" in said or "hexadecimal" in said:
        return "a backslash with a letter that means nothing", "use single quotes, or write \\\\"
    return "a quote that is never closed", "close it, or double a quote that belongs to the text"


def _block_end(said: str, context: str) -> tuple[str, str]:
    got = GOT.search(said)
    what = got[1] if got else ""
    if what in ("}", "]"):
        return f"a {what} that closes nothing", "remove it, or open it before"
    if "collection" in context or what == "-":
        return (
            "a list and keys are mixed here",
            "line the items of a list (`- `) up with each other",
        )
    if what == "<scalar>":
        return "this does not go on what stands before it", QUOTE_TEXT
    return "the indentation does not fit any line before it", "line keys of one level up"
