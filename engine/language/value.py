"""A value as written in a protocol: plain data in which texts may contain `${{ ... }}`."""

from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any

from ...schemas.quantity import is_quantity, number_text, quantity_text
from .expression import Expression, ExpressionError, expression
from .moments import moment_text

OPEN, CLOSE = "${{", "}}"


class Value:
    """A value in a protocol; `constant` where nothing in it is computed."""

    constant = True

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        """The value for these names; raises ExpressionError."""
        raise NotImplementedError

    def expressions(self) -> Iterator[Expression]:
        """Every expression in it."""
        return iter(())

    @property
    def names(self) -> set[str]:
        """The names that it needs."""
        return {name for one in self.expressions() for name in one.names}

    @property
    def live(self) -> bool:
        """True if a clock is asked in it."""
        return any(one.live for one in self.expressions())


class Constant(Value):
    """Data without expressions."""

    def __init__(self, data: Any) -> None:
        self.data = data

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        return self.data


class Computed(Value):
    """A whole scalar `${{ e }}`: its value keeps its type."""

    constant = False

    def __init__(self, computed: Expression) -> None:
        self.expression = computed

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        return self.expression.evaluate(names)

    def expressions(self) -> Iterator[Expression]:
        yield self.expression


class Text(Value):
    """Text with expressions in it; a quantity is inserted as `0.2 mm`."""

    constant = False

    def __init__(self, parts: list[str | Expression]) -> None:
        self.parts = parts

    def evaluate(self, names: Mapping[str, Any]) -> str:
        return "".join(
            part if isinstance(part, str) else as_text(part.evaluate(names)) for part in self.parts
        )

    def expressions(self) -> Iterator[Expression]:
        return (part for part in self.parts if isinstance(part, Expression))


class Items(Value):
    """A list with something computed in it."""

    constant = False

    def __init__(self, items: list[Value]) -> None:
        self.items = items

    def evaluate(self, names: Mapping[str, Any]) -> list[Any]:
        return [item.evaluate(names) for item in self.items]

    def expressions(self) -> Iterator[Expression]:
        return (found for item in self.items for found in item.expressions())


class Fields(Value):
    """A mapping with something computed in it."""

    constant = False

    def __init__(self, fields: dict[str, Value]) -> None:
        self.fields = fields

    def evaluate(self, names: Mapping[str, Any]) -> dict[str, Any]:
        return {key: value.evaluate(names) for key, value in self.fields.items()}

    def expressions(self) -> Iterator[Expression]:
        return (found for value in self.fields.values() for found in value.expressions())


def value_of(raw: Any, own: frozenset[str] = frozenset()) -> Value:
    """The value of plain data; raises ExpressionError for an invalid expression.

    `own`: the functions that the protocol has besides those of the language.
    """
    if isinstance(raw, str):
        return _text_value(raw, own)
    if isinstance(raw, dict):
        fields = {key: value_of(item, own) for key, item in raw.items()}
        return Constant(raw) if all(v.constant for v in fields.values()) else Fields(fields)
    if isinstance(raw, list):
        items = [value_of(item, own) for item in raw]
        return Constant(raw) if all(v.constant for v in items) else Items(items)
    return Constant(raw)


def _text_value(text: str, own: frozenset[str]) -> Value:
    if OPEN not in text:
        return Constant(text)
    parts = list(_parts(text, own))
    written = [part for part in parts if not (isinstance(part, str) and not part.strip())]
    if len(written) == 1 and isinstance(written[0], Expression):
        return Computed(written[0])
    return Text(parts)


def _parts(text: str, own: frozenset[str]) -> Iterator[str | Expression]:
    position = 0
    while (start := text.find(OPEN, position)) >= 0:
        if start > position:
            yield text[position:start]
        end = _closing(text, start + len(OPEN))
        yield expression(text[start + len(OPEN) : end].strip(), own)
        position = end + len(CLOSE)
    if position < len(text):
        yield text[position:]


def _closing(text: str, position: int) -> int:
    """Where the expression ends: at the first `}}` outside quotes."""
    quote = ""
    for index in range(position, len(text)):
        character = text[index]
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character == "}" and text.startswith(CLOSE, index):
            return index
    raise ExpressionError("an expression that is never closed: `}}` is missing")


def as_text(value: Any) -> str:
    """A value as it is inserted into text."""
    if isinstance(value, str):
        return value
    if value is None:
        return "null"
    if is_quantity(value):
        return quantity_text(value)
    if isinstance(value, datetime):
        return moment_text(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return number_text(value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {as_text(item)}" for key, item in value.items())
    if hasattr(value, "__len__") and len(value) <= 100:
        return ", ".join(as_text(item) for item in value)
    return "a long list"
