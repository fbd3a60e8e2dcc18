"""Format a protocol's text: two spaces per level, only blanks changed.

Every line keeps its words, quotes, comments and order; only its indentation changes. The meaning of
the file stays the same, and this is checked before anything is written.
"""

import re
from pathlib import Path
from typing import Any

from ...schemas.problem import Problem
from ..language.source import Source, parse_source
from .json import format_json
from .lines import even_lines


class MeaningChanged(Exception):
    """Formatting would change the meaning: an internal error, and nothing is written."""


def format_text(text: str, name: str) -> tuple[str, list[Problem]]:
    """The formatted text; or, if it cannot be read, the text unchanged and its errors."""
    source, problems = parse_source(text, Path(name), name)
    errors = [problem for problem in problems if problem.severity == "error"]
    if source is None or errors:
        return text, errors
    body = text.removeprefix("\ufeff")
    made = format_json(source) if _is_json(source, name) else _even_yaml(body)
    if body.count("\r\n") * 2 > body.count("\n"):
        made = made.replace("\n", "\r\n")
    made = text[: len(text) - len(body)] + made
    again, more = parse_source(made, Path(name), name)
    if again is None or not same(source.data, again.data):
        raise MeaningChanged(more[0].message if more else "a value would change")
    return made, []


def same(one: Any, other: Any) -> bool:
    """True if two values are the same, including type and order: 1 is not 1.0, nor true."""
    return repr(one) == repr(other)


def _is_json(source: Source, name: str) -> bool:
    return name.lower().endswith(".json") and source.root is not None


def _even_yaml(text: str) -> str:
    return "\n".join(even_lines(re.sub(r"\r\n?", "\n", text))) + "\n"
