"""Values that YAML reads differently from how they look: warnings, and hints beside problems.

YAML 1.2 reads `yes`, `1:30` and `2026-11-21` as text and `010` as ten. Where text is expected,
that is right and nothing is reported; where such a value has a problem, the hint says how it was
read and how to write what was meant.
"""

import re
from collections.abc import Iterator
from typing import Any

from ...schemas.quantity import COMMON, PLAIN
from .yaml_characters import odd_characters
from .yaml_node import Node, YamlFault, shown

WORTH_A_LOOK = re.compile(
    r"\$\{(?!\{)|(?<!\$)\{\{|\$\{\{(?:(?!\}\})[^\n#])*+#|[“”„«»‘]|(?<![\w.:,/+-])[-+]?0[0-9]+(?![\w.:/-])"
    r"|[ \t]#[0-9]|\{%"
)
"""If a text contains none of these, its values are not examined further."""
ZEROS = re.compile(r"[-+]?0[0-9]+")
STRAIGHT = "\"'"
EXPRESSION = re.compile(r"\$\{\{.*?\}\}", re.DOTALL)
BRACES = re.compile(r"(?<!\$)\{\{\s*([A-Za-z_][\w.]*)[^{}]*\}\}")
LONE = re.compile(r"\$\{(?!\{)\s*([A-Za-z_(\d][^{}\n]*?)\s*\}")
SURELY = re.compile(r"(?:params|steps|run|error)\.")
TEMPLATE = re.compile(r"\{%[^%\n]*%\}")
NUMBERED = re.compile(r"[ \t]+(#[0-9]+)")
"""What people number (`sample #5`), and YAML takes for a comment."""
WRAPPED = re.compile(r"[“”„«][^“”„«»\"]*[“”»\"]|‘[^‘’']*[’']")

TRUTHS = {"yes": "true", "y": "true", "on": "true", "no": "false", "n": "false", "off": "false"}
SIXTIES = re.compile(r"[-+]?([0-9]+)((?::[0-5]?[0-9])+)(\.[0-9]*)?")
GROUPED = re.compile(r"([-+]?[0-9][0-9_]*_[0-9_]*(?:\.[0-9_]*)?)( ?[^\W\d_].*)?")
NO_BRACKETS = (
    "a comma separates entries; a list needs [brackets], and text that contains one quotes"
)
COMMA = re.compile(r"([-+]?[0-9]+),([0-9]+)( ?[^\W\d_].*)?")
THOUSANDS = re.compile(
    r"([-+]?)([0-9]{1,3}(?:([',. \u00a0\u2009\u202f’])[0-9]{3}(?:\3[0-9]{3})*))"
    r"(?:[.,]([0-9]+))?( ?[^\W\d_].*)?"
)
DATE = re.compile(r"[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}([Tt ].*)?")
BINARY = re.compile(r"0b[01_]+")
WELLS = re.compile(r"([A-Z][0-9]{1,2}) ?(?:-|–|:|\.\.|to|bis) ?([A-Z][0-9]{1,2})")
SHELL = re.compile(r"\$\{?([A-Za-z_]\w*)\}?")
SPOKEN = re.compile(r"(?:([0-9]+) ?h)? ?(?:([0-9]+) ?(?:m|min)?)? ?(?:([0-9]+) ?s)?")
RANGE = re.compile(
    r"([0-9.]+?)( ?[^\W\d_]+)? ?(?:-|–|\.\.\.?|…|to|bis|à|:) ?(?:([0-9.]+):)?([0-9.]+)( ?[^\W\d_]+)?"
    r"(?: ?(?:step|by|,|;|/) ?([0-9.]+)( ?[^\W\d_]+)?)?"
)
NAMED = re.compile(r"(?:params|steps|status|run)\.\w[\w.]*")
UNIT_BEHIND = re.compile(r"(\w+?)(?:_| ?[(\[/]| )\[?([^\W\d_]+)[)\]]?")
NO_VALUE = re.compile(r"\s*[,}]")
EQUALS = re.compile(r"([A-Za-z_]\w*) ?= ?(?=[^=\s])")
NO_SPACE = re.compile(r"([A-Za-z_]\w*):([^\s/].*)", re.DOTALL)
TEXT = re.compile(r"^(?!id ).*\b(?:needs|wants|not|or) (?:a )?text\b(?! or)")
"""A message that text of any kind is expected."""


def traps(root: Node, text: str) -> list[YamlFault]:
    """Everything in a file that is not read as it looks."""
    if not WORTH_A_LOOK.search(text):
        return []
    found = []
    for node, parent, key in _scalars(root):
        raw = text[node.start : node.end]
        fault = _zeros(node, raw) or _wrapped(node, raw)
        if fault is None and isinstance(node.value, str) and LONE.search(node.value):
            fault = _lone_braces(node)
        elif fault is None and isinstance(node.value, str) and (found_one := _other(node, text)):
            fault = found_one
        elif fault is None and isinstance(node.value, str) and "{{" in node.value:
            fault, repaired = _cut(node, text) or _braces(node) or (None, node.value)
            # It is then read as it was meant, so that no other problem follows from it.
            node.value = parent.value[key] = repaired
        if fault is not None:
            found.append(fault)
    return found


def _scalars(root: Node) -> Iterator[tuple[Node, Node, Any]]:
    """Every scalar in a list or mapping, with its key there."""
    todo, seen = [root], set()
    while todo:
        parent = todo.pop()
        if id(parent) in seen:
            continue  # repeated by an alias
        seen.add(id(parent))
        inner = parent.members.items() if parent.members else enumerate(parent.items or [])
        for key, node in inner:
            if node.members is None and node.items is None:
                yield node, parent, key
            else:
                todo.append(node)


def _zeros(node: Node, raw: str) -> YamlFault | None:
    if not node.plain or not isinstance(node.value, int) or not ZEROS.fullmatch(raw):
        return None
    octal = raw.lstrip("+-0")
    other = f"; YAML 1.1 reads {int(octal, 8)}" if octal and set(octal) <= set("01234567") else ""
    return _warning(
        "W102", f"{raw} is read as the number {node.value}{other}", node,
        f"write {node.value}, or '{raw}' in quotes if it is text",
    )  # fmt: skip


def _wrapped(node: Node, raw: str) -> YamlFault | None:
    if not node.plain or not WRAPPED.fullmatch(raw):
        return None
    quotes = "quotes" if raw[-1] in STRAIGHT else "curly quotes"
    return _warning(
        "W103", f"the {quotes} {raw[0]} and {raw[-1]} are part of this text", node,
        f'write "{shown(raw[1:-1])}"; if they are intended, put straight quotes around them',
    )  # fmt: skip


def _cut(node: Node, text: str) -> tuple[YamlFault, str] | None:
    """An expression that a comment cuts off before its `}}`."""
    value = node.value
    if not node.plain or value.rfind("${{") <= value.rfind("}}"):
        return None
    comment = re.compile(r"[ \t]+#[^\r\n]*").match(text, node.end)
    if comment is None:
        return None
    fault = YamlFault(
        "E109", "a `#` after a space begins a comment, so this expression is cut off", node.start,
        "put the whole value in quotes, or the comment after the `}}`", node.end - node.start,
    )  # fmt: skip
    return fault, value + " }}"


def _other(node: Node, text: str) -> YamlFault | None:
    """A number that YAML takes for a comment, or a template of another program."""
    if node.plain and (numbered := NUMBERED.match(text, node.end)):
        message = f"`{numbered[1]}` is not part of this text: a `#` after a space begins a comment"
        whole = f"{text[node.start : node.end]} {numbered[1]}"
        return _warning(
            "W105", message, node, f'write "{shown(whole)}", in quotes, if it belongs to it'
        )
    if template := TEMPLATE.search(node.value):
        message = f"`{shown(template[0])}` is plain text: there are no templates"
        hint = "a step with `if:` decides, or ${{ a if condition else b }} within a text"
        return _warning("W101", message, node, hint)
    return None


def _braces(node: Node) -> tuple[YamlFault, str] | None:
    """`{{ x }}` in text, as other programs write it, instead of `${{ x }}`."""
    value = node.value
    match = BRACES.search(EXPRESSION.sub(lambda found: " " * len(found[0]), value))
    if match is None:
        return None
    written = shown(match[0])
    message = f"`{written}` without a `$` is plain text and is not replaced"
    hint = f"write ${written} for the value of an expression"
    if SURELY.match(match[1]):
        fault = YamlFault("E109", message, node.start, hint, node.end - node.start)
        return fault, value[: match.start()] + "$" + value[match.start() :]
    return _warning("W101", message, node, hint), value


def _lone_braces(node: Node) -> YamlFault:
    """`${ x }`, as shells write it."""
    match = LONE.search(node.value)
    assert match is not None
    message = f"`{shown(match[0])}` with one brace is plain text and is not replaced"
    hint = f"write ${{{{ {shown(match[1])} }}}} for the value of an expression"
    return _warning("W101", message, node, hint)


def _warning(code: str, message: str, node: Node, hint: str) -> YamlFault:
    return YamlFault(code, message, node.start, hint, node.end - node.start)


DASHES = "-–—−－•"
"""What people, and their word processors, begin the items of a list with."""


# --- hints beside a problem that is reported anyway


def value_hint(node: Node, raw: str, message: str) -> str:
    """A hint about how a value of the wrong kind is written; or nothing."""
    if node.members and TEXT.search(message) and len(node.members) == 1 and "number" not in message:
        (inner,) = node.members.values()
        if raw.startswith("{") and isinstance(inner.value, str):
            return f"write only {shown(inner.value)}"
        return "`: ` makes what is before it a key; put text that contains it in quotes"
    if (
        node.members
        and "a list" in message
        and all(key[0] in DASHES for key in node.members if key)
    ):
        return odd_characters(next(iter(node.members))) or "a space is missing after the `-`"
    if node.members and "foreach needs" in message and (bounds := _bounds(node)):
        return f"write {_span(*bounds)}"
    if node.members and "needs a list" in message and raw.startswith("{"):
        return "put [ and ] around it"
    if node.members and "needs a list" in message:
        return "a list has its items one below the other, each after `- `"
    if node.value is None and node.members is None and node.items is None:
        needs = "needs keys" in message or "needs a list" in message
        return "indent what belongs to it below it" if needs else ""
    if node.members is not None or node.items is not None:
        return ""
    if isinstance(node.value, str):
        return _read_as_text(node, node.value.strip(), message)
    if not node.plain or not raw:
        return ""
    asks = message.startswith("confirm ") and isinstance(node.value, bool)
    if TEXT.search(message) and "number or text" not in message and not asks:
        return f"`{shown(raw)}` without quotes is not text; write '{shown(raw)}'"
    if (
        isinstance(node.value, float)
        and node.value.is_integer()
        and ("." not in raw or "whole number" in message)
        and "needs keys" not in message
    ):
        return f"`{raw}` is read as a number with a fraction; write {node.value:.0f}"
    return ""


def colon_for(key: str) -> str:
    """The hint for a key that is given its value by a sign of equality."""
    return f"a colon stands between a key and its value: `{key}:`, not `{key} =`"


def point_for(text: str) -> str:
    """The hint for a number with a decimal comma, or with marks between its thousands; or nothing."""
    if match := COMMA.fullmatch(text):
        decimal, unit = f"{match[1]}.{match[2]}{match[3] or ''}", match[3] or ""
        if len(match[2]) == 3 and match[1].lstrip("+-") != "0":  # a comma that may mean a thousand
            return f"a comma may be read in two ways; write {match[1]}{match[2]}{unit} or {decimal}"
        return f"numbers have a decimal point: {decimal}"
    if match := THOUSANDS.fullmatch(text):
        whole = re.sub(r"\D", "", match[2])
        rest = f".{match[4]}" if match[4] else ""
        return f"nothing stands between thousands: {match[1]}{whole}{rest}{match[5] or ''}"
    return ""


def _read_as_text(node: Node, text: str, message: str) -> str:
    if node.plain and "needs keys" in message and (match := EQUALS.match(text)):
        return colon_for(match[1])
    if hint := point_for(text):
        return hint
    if node.plain and (hint := _plain_text(text, message)):
        return hint
    if hint := _range_or_name(text, message):
        return hint
    match = NO_SPACE.fullmatch(text)
    if match and "foreach needs" not in message and not match[1].isupper():  # as SCPI is
        return f"a space is missing after the colon: `{match[1]}: {shown(match[2])}`"
    return odd_characters(node.value)


def _range_or_name(text: str, message: str) -> str:
    """A range, or the value of a name, as other languages write them."""
    if match := RANGE.fullmatch(text):
        first, own, middle, last, unit, step, _ = match.groups()
        unit = unit or own or ""
        span = _span(f"{first}{unit}", f"{last}{unit}", f"{middle or step or 1}{unit}")
        if "foreach needs" in message:
            return f"write {span}"
        if "the device wants" in message:
            return (
                f"it wants one value; a loop goes through a range, such as foreach: {{x: {span}}}"
            )
    if "foreach needs" in message and (match := WELLS.fullmatch(text)):
        listed = f"[{match[1]}, ..., {match[2]}]"
        return f"write {listed}, all of them, or \"${{{{ csv('plate.csv') }}}}\" for a table"
    if match := SHELL.fullmatch(text):
        name = match[1]
        return f"write ${{{{ {name} }}}} for its value, ${{{{ params.{name} }}}} for a parameter's"
    if "the device wants" in message and (match := LONE.fullmatch(text)):
        return f"write ${{{{ {match[1]} }}}} for its value"
    return ""


def _span(first: str, last: str, step: str) -> str:
    return f'"${{{{ span({first}, {last}, {step}) }}}}"'


def _bounds(node: Node) -> tuple[str, str, str] | None:
    """What `{from: 0 mm, to: 5 mm, step: 1 mm}` says of a span; None for other keys."""
    told = {key.casefold(): str(one.value) for key, one in (node.members or {}).items() if one}
    found = [
        next((told[word] for word in words if word in told), None)
        for words in (("from", "start", "min"), ("to", "stop", "end", "max"), ("step", "by"))
    ]
    first, last, step = found
    return None if first is None or last is None else (first, last, step or "1")


def _plain_text(text: str, message: str) -> str:
    declares = re.search("(?<!keep_going )needs keys", message)
    of_other_kind = declares or re.search("whole number|device wants (?!.*true or false)", message)
    of_other_kind = of_other_kind or re.search(
        r"is not one of|needs a list|number with a unit", message
    )
    if (truth := TRUTHS.get(text.lower())) and not of_other_kind:
        return f"YAML 1.2 reads `{text}` as text; write {truth}"
    if declares and not NAMED.fullmatch(text):
        return ""
    if (match := SIXTIES.fullmatch(text)) and "time of day" not in message:
        total = int(match[1])
        for part in match[2][1:].split(":"):
            total = total * 60 + int(part)
        other = f" or {total} min" if match[2].count(":") == 1 else ""
        return f"YAML 1.2 reads `{text}` as text, not as a time; write {total} s{other}"
    if "is not a unit" in message and (match := SPOKEN.fullmatch(text)):
        hours, minutes, over = (int(part or 0) for part in match.groups())
        total = hours * 3600 + minutes * 60 + over
        return f"a time has one number and one unit; write {f'{total} s' if over else f'{total // 60} min'}"
    if NAMED.fullmatch(text):
        return f'write "${{{{ {text} }}}}" for its value'
    if match := GROUPED.fullmatch(text):
        return f"YAML 1.2 reads `{text}` as text; write {text.replace('_', '')}"
    if DATE.fullmatch(text):
        return f"a date such as {shown(text)} is text"
    if BINARY.fullmatch(text):
        return f"YAML 1.2 reads `{text}` as text; write {int(text.replace('_', ''), 2)}"
    return ""


def key_hint(key: str, text: str, start: int, end: int) -> str:
    """A hint about how an unknown key is written; or nothing."""
    before = text[max(0, start - 2) : start]
    if key[:1].isdigit() and before[-1:] == "," and before[:1].isdigit():
        return f"a comma separates entries; a number has a decimal point: {before[:1]}.{key}"
    if match := NO_SPACE.fullmatch(key):
        return f"a space is missing after the colon: `{match[1]}: {shown(match[2])}`"
    if match := EQUALS.match(key):
        return colon_for(match[1])
    if (match := UNIT_BEHIND.fullmatch(key)) and match[2] in (*PLAIN, *COMMON):
        return f"a unit stands behind its number: `{match[1]}: 1 {match[2]}`"
    if NO_VALUE.match(text, end) and text[:start].rstrip()[-1:] == ",":
        return NO_BRACKETS
    return odd_characters(key)
