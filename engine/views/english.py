"""Counts, lists and verbs for sentences."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

from ..language.grid import Grid, Span
from ..language.value import CLOSE, OPEN

SHORT = 70
INSERTED = re.compile(r"\$\{\{\s*(.*?)\s*\}\}", re.DOTALL)


def count_of(number: int, word: str) -> str:
    """`1 action`, `1,071 actions`."""
    return f"{number:,} {word}{'' if number == 1 else 's'}"


def joined(parts: Iterable[str], last: str = "and") -> str:
    """`a, b and c`."""
    known = list(parts)
    if len(known) < 2:
        return "".join(known)
    return f"{', '.join(known[:-1])} {last} {known[-1]}"


def third_person(verb: str) -> str:
    """What one device does: `go` becomes `goes`, `carry` becomes `carries`."""
    if verb in ("be", "have"):
        return {"be": "is", "have": "has"}[verb]
    if verb.endswith(("s", "x", "z", "ch", "sh", "o")):
        return verb + "es"
    if verb.endswith("y") and verb[-2:-1] not in "aeiou":
        return verb[:-1] + "ies"
    return verb + "s"


def upper_first(text: str) -> str:
    """The first letter in upper case, the others unchanged."""
    return text[:1].upper() + text[1:]


def lower_first(text: str) -> str:
    """The first letter in lower case, unless an abbreviation starts there: `LIBS`."""
    return text if text[1:2].isupper() else text[:1].lower() + text[1:]


def shortened(text: str, most: int = SHORT) -> str:
    """On one line, and cut if it is too long."""
    line = " ".join(text.split())
    return line if len(line) <= most else line[: most - 1].rstrip() + "…"


def bare(raw: Any) -> str:
    """An expression without its `${{ }}`, in a text as `{x}`; anything else as in YAML."""
    if isinstance(raw, bool):
        return "true" if raw else "false"
    text = str(raw).strip()
    inner = text.removeprefix(OPEN).removesuffix(CLOSE)
    if text.startswith(OPEN) and text.endswith(CLOSE) and OPEN not in inner:
        return inner.strip()
    return INSERTED.sub(r"{\1}", text)


def items_text(items: Sequence[Any]) -> str:
    """`a grid of 21 x 51 = 1,071 points (snake)`, `a span of 5 items`, `3 items`."""
    if isinstance(items, Grid):
        size = f"{items.across:,} x {items.down:,} = {count_of(len(items), 'point')}"
        return f"a grid of {size} ({items.order})"
    kind = "a span of " if isinstance(items, Span) else ""
    return f"{kind}{count_of(len(items), 'item')}"
