"""Translate the YAML parser's errors into messages for people who write protocols."""

import re
from typing import Any

from .yaml_characters import named, odd_characters
from .yaml_lines import Lines
from .yaml_looks import CURLY, looks, tab
from .yaml_node import YamlFault, shown
from .yaml_traps import colon_for

NO_TOKEN = re.compile(r"found character '(.+)' that cannot start any token")
GOT = re.compile(r"but (?:got|found) \(?'?([^',)]+)'?")
KEY = re.compile(r"[ ]*(?:-[ ]+)*([^\s:#'\"-][^:#]*):(?=\s|$)")
NO_TEMPLATE = (
    "`foreach` repeats steps, `if` chooses between them, ${{ ... }} is an expression's value"
)
QUOTE_TEXT = "put the text in quotes"
SECOND = re.compile(r"[{,]\s*[A-Za-z]\w*:\s+[\w.]+?\s*(;|(?<=\s))\s*([a-z_]+)$")
"""In a mapping in brackets, a key with a value of one word and another key behind it."""
GIVEN = re.compile(r"""[{,]\s*([A-Za-z_]\w*) ?= ?["']""")
NO_COLON = re.compile(r"([A-Za-z_]\w*)[ =]+([\[{])")
BLOCK = re.compile(r".*:\s+[|>][-+0-9]*\s*(?:#.*)?$")
FIRST_COLON = re.compile(r"(?:^\s*|[-{,]\s+)(?:-\s+)*[^:\s]+:\s+(?=\S)")


def in_words(fault: Any, lines: Lines) -> YamlFault:
    """A fault of ruamel.yaml as a problem with a place and a hint."""
    mark = getattr(fault, "problem_mark", None) or getattr(fault, "context_mark", None)
    if mark is None:
        return _unreadable(fault)
    offset = min(mark.index, max(0, len(lines.text) - 1))
    said = str(getattr(fault, "problem", None) or getattr(fault, "context", None) or fault)
    context = str(getattr(fault, "context", None) or "")
    begun = fault.context_mark.index if getattr(fault, "context_mark", None) else offset
    return looks(lines, offset, flow="flow" in context) or _translate(
        said, context, lines, offset, begun
    )


def _unreadable(fault: Any) -> YamlFault:
    character = getattr(fault, "character", None)
    position = int(getattr(fault, "position", 0) or 0)
    code = character if isinstance(character, int) else ord(str(character or "\0")[0])
    message = f"an invisible character (U+{code:04X})"
    return YamlFault(
        "E101", message, position, "remove it, or write it as \\xNN inside double quotes"
    )


def _translate(said: str, context: str, lines: Lines, offset: int, begun: int) -> YamlFault:
    number = lines.place(offset)[0]
    line = lines.line(number)
    before = line[: offset - lines.starts[number - 1]]
    if lines.text[offset : offset + 1] == "\t":
        return tab(offset)
    if match := NO_TOKEN.search(said):
        if before.endswith("{") and match[1] == "%":
            return _fault("{% ... %} is another program's template", offset - 1, NO_TEMPLATE)
        text = line[len(before) :]
        if "flow" in context or re.search(r"[{\[]", before):
            text = re.split(r"[,\]}]", text, maxsplit=1)[0] or text
        hint = f"{QUOTE_TEXT}, such as '{shown(text)}'"
        return _fault(f"text cannot begin with {match[1]}", offset, hint)
    if "flow" in context and "quoted" not in context:
        return _flow(said, context, lines, offset, begun)
    if "mapping values are not allowed" in said:
        return _colon(lines, number, before, offset)
    if "quoted scalar" in context or ("escape" in said and "quoted" in context):
        return _quoted(said, lines, offset, begun)
    if "could not find expected ':'" in said:
        if _under_block(lines, lines.place(begun)[0]):
            return _fault("this is indented too little to belong to the text that `|` or `>` begins", begun,
                          "indent all lines of a text by the same, below their key")  # fmt: skip
        return _fault("a key without its `:`", begun, "write `key: value`")
    if before.rstrip()[-1:] in ("'", '"') and "${{" not in line[len(before) :]:
        return _after_quote(before.rstrip()[-1], lines, offset, before)
    if "expected <block end>" in said:
        return _block_end(said, lines, number, offset)
    if "sequence entries are not allowed" in said:
        return _fault("`- ` begins a list item, which cannot follow a key on the same line", offset,
                      "put the list on the lines below; a negative number has no space: -3 mm")  # fmt: skip
    if "expected alphabetic or numeric" in said:
        mark = line[len(before) - 1 : len(before)]
        names = {"&": "an anchor", "*": "an alias"}.get(mark, "a name")
        message = f"YAML reads text that begins with {mark or '&'} as {names}"
        return _fault(message, max(0, offset - 1), QUOTE_TEXT)
    if "document start" in said or "document end" in said:
        return _fault("this does not continue what is before it", offset,
                      "check for a misplaced `:` or quote")  # fmt: skip
    if "tag" in said:
        return _fault("an unknown tag (`!...`)", offset, "write the value without a tag")
    return _fault(f"not YAML: {said.strip()}", offset)


def _flow(said: str, context: str, lines: Lines, offset: int, begun: int) -> YamlFault:
    mapping = "mapping" in context
    closing = "}" if mapping else "]"
    got = GOT.search(said)
    what = got[1] if got is not None else ""
    if what.startswith("<stream end"):
        return _open_bracket(closing, lines, begun)
    here = lines.text[offset : offset + 1]
    line, there = lines.place(begun)[0], lines.place(offset)[0]
    if line != there and _begins_anew(lines.line(there), lines.line(line)):
        return _open_bracket(closing, lines, begun)
    if here == ":" and mapping:
        if lacking := _no_comma(lines, begun, offset):
            return lacking
        start = max(lines.text.rfind(mark, 0, offset) for mark in ": {,") + 1
        rest = re.compile(r"[^,}\r\n]*").match(lines.text, start)
        value = shown(rest[0]) if rest is not None else ""
        comma = lines.text.rfind("，", begun, offset)
        if lines.place(comma)[0] == there:
            return _fault(
                "a full-width comma is not what YAML needs here", comma, "write `, ` instead"
            )
        return _fault("`: ` in text inside brackets begins another value", start,
                      f'{QUOTE_TEXT}: "{value}"', offset - start)  # fmt: skip
    if "expected the node content" in said:
        return _fault("a bracket or comma where a value should be", offset,
                      f"{QUOTE_TEXT} if the {here} belongs to it")  # fmt: skip
    if here in ("}", "]"):
        return _fault(f"{here} cannot close a bracket opened with {lines.text[begun]}", offset,
                      f"write {closing}")  # fmt: skip
    where = "" if line == there else f" of line {line}"
    return _fault(f"a comma or {closing} is missing before this", offset,
                  f"check whether the bracket {lines.text[begun]}{where} is closed")  # fmt: skip


def _begins_anew(line: str, opened: str) -> bool:
    """Whether a line is a step, or a key no deeper than the line of a bracket: it is not inside it."""
    depth = len(line) - len(line.lstrip())
    return line.lstrip()[:2] == "- " or (
        KEY.match(line) is not None and depth <= len(opened) - len(opened.lstrip())
    )


def _no_comma(lines: Lines, begun: int, offset: int) -> YamlFault | None:
    """`{do: gantry.home timeout: 5 s}`: the word before the colon is a key after a missing comma."""
    match = SECOND.search(lines.text[begun:offset])
    if match is None:
        return None
    key, mark = match[2], match[1]
    message = (
        f"`{mark}` does not separate entries" if mark else f"a comma is missing before `{key}:`"
    )
    hint = f"write `, {key}:`, or put the text in quotes if the `: ` belongs to it"
    return _fault(
        message, begun + (match.start(1) if mark else match.start(2)), hint, len(mark or key)
    )


def _open_bracket(closing: str, lines: Lines, begun: int) -> YamlFault:
    line, column = lines.place(begun)
    comment = re.search(r"\s#", lines.line(line)[column:])
    hint = f"close it with {closing}"
    if comment is not None:
        hint += "; a `#` after a space begins a comment, and its text is ignored"
    return _fault(f"a bracket that is never closed; {closing} is missing", begun, hint)


def _colon(lines: Lines, number: int, before: str, offset: int) -> YamlFault:
    if first := FIRST_COLON.match(before):
        start = lines.starts[number - 1] + first.end()
        value = shown(lines.line(number)[first.end() :])
        hint = f'put text that contains a `: ` in quotes: "{value}"'
        return _fault("a second `: ` on one line begins another key", start,
                      odd_characters(value[:1]) or hint, offset - start)  # fmt: skip
    key = before.lstrip(" -")
    if lacks := NO_COLON.match(key):
        return _fault(
            "a key without its `:`",
            offset - len(key),
            f"write `{lacks[1]}: {lacks[2]}`",
            len(lacks[1]),
        )
    if twice := _list_below_a_value(lines, number):
        return twice
    return _fault("a key that is indented too far",
                  offset - len(key), "align the keys", len(key))  # fmt: skip


def _under_block(lines: Lines, number: int) -> bool:
    """True for a line below text that `|` begins, indented less than that text or than is enough."""
    depth = len(lines.line(number)) - len(lines.line(number).lstrip())
    for above in _above(lines, number):
        if BLOCK.match(above):
            return True
        if above.strip() and len(above) - len(above.lstrip()) <= depth:
            return False
    return False


def _quoted(said: str, lines: Lines, offset: int, begun: int) -> YamlFault:
    if "escape" in said or "hexdecimal" in said or "hexadecimal" in said:
        message = "an unknown backslash escape"
        return _fault(message, max(begun, offset - 1), "use single quotes, or write \\\\", 2)
    line = lines.line(lines.place(begun)[0])
    if curly := next((mark for mark in line if mark in CURLY), None):
        hint = f"{named(curly)} in this line is not a quote in YAML; write {lines.text[begun]}"
        return _fault("a quote that is never closed", begun, hint)
    if given := GIVEN.search(line):
        at = lines.starts[lines.place(begun)[0] - 1] + given.start(1)
        return _fault("a value without a colon before it", at, colon_for(given[1]), len(given[1]))
    return _fault("a quote that is never closed", begun,
                  "close it, or double any quote that belongs to the text")  # fmt: skip


def _after_quote(quote: str, lines: Lines, offset: int, before: str) -> YamlFault:
    other = "'...'" if quote == '"' else '"..."'
    inside = r"\"" if quote == '"' else "''"
    return _fault(f"the {quote} before this ends the text", offset,
                  f"write a {quote} inside it as {inside}, or put the text in {other}")  # fmt: skip


def _block_end(said: str, lines: Lines, number: int, offset: int) -> YamlFault:
    got = GOT.search(said)
    what = got[1] if got else ""
    if what in ("}", "]"):
        return _fault(
            f"a {what} that closes nothing", offset, "remove it, or add the opening bracket"
        )
    line = lines.line(number)
    if twice := _list_below_a_value(lines, number):
        return twice
    if what == "-" or line.lstrip().startswith("- "):
        return _fault("a list and keys are mixed here", offset,
                      "align the items of a list (`- `) with each other, below their key")  # fmt: skip
    if what == "<scalar>":
        return _fault("this does not continue what is before it", offset, QUOTE_TEXT)
    above = next((KEY.match(text) for text in _above(lines, number) if KEY.match(text)), None)
    hint = "align keys of the same level"
    if above is not None:
        hint += f"; {above[1]!r} above begins in column {above.start(1) + 1}"
    return _fault("the indentation does not match any line before it", offset, hint)


def _list_below_a_value(lines: Lines, number: int) -> YamlFault | None:
    """`on_resume: x` above `- do: gantry.home`: the key has its value, and a list has none."""
    line, above = lines.line(number), number - 1
    while above > 1 and not lines.line(above).partition("#")[0].strip():
        above -= 1
    given = lines.line(max(1, above))
    key, value = KEY.match(given), FIRST_COLON.match(given)
    deeper = len(given) - len(given.lstrip()) > len(line) - len(line.lstrip())
    if not line.lstrip().startswith("- ") or given.lstrip().startswith("- ") or deeper:
        return None
    if key is None or value is None:
        return None
    text = shown(given[value.end() :])
    hint = (
        f"remove `{text}` if the list is its value; or write the list's own key, such as `steps:`, "
        "above it"
    )
    message = f"a list below `{key[1]}:`, which has its value already"
    return _fault(message, lines.starts[above - 1] + value.end(), hint, len(text))


def _above(lines: Lines, number: int) -> list[str]:
    return [lines.line(above) for above in range(number - 1, max(0, number - 20), -1)]


def _fault(message: str, start: int, hint: str = "", length: int = 1) -> YamlFault:
    return YamlFault("E101", message, start, hint, length)
