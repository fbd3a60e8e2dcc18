"""What one parameter of an action expects, its range on this bench, and how a misfit is reported."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...schemas.lab import Limit
from ...schemas.quantity import UnitError, is_number, kind_of_unit, magnitude_in, number_text
from .suggest import listed

TYPE_WORDS = {
    "number": "a number", "integer": "a whole number", "string": "text", "boolean": "true or false",
    "array": "a list", "object": "fields", "null": "null",
}  # fmt: skip


class ArgumentFault(ValueError):
    """One argument that does not fit; `message` names device, action and parameter.

    `bounds` is set where a number is outside its range: `x 0..4 mm`.
    """

    def __init__(
        self, param: str, message: str, hint: str = "", *, code: str = "E206", bounds: str = "",
        path: tuple[str | int, ...] = (),
    ) -> None:  # fmt: skip
        super().__init__(message)
        self.param, self.message, self.hint = param, message, hint
        self.code, self.bounds, self.path = code, bounds, path or (param,)

    def with_hint(self) -> str:
        """With the way on, where there is one."""
        return f"{self.message}; {self.hint}" if self.hint else self.message


@dataclass(frozen=True, slots=True)
class Wanted:
    """What one parameter expects: its schema, the narrower range of this bench, and its name."""

    schema: Mapping[str, Any]
    limit: Limit | None
    param: str
    label: str

    @property
    def unit(self) -> str | None:
        """The contract's unit, None for plain numbers and other things."""
        return self.schema.get("unit")

    def fault(self, says: str, hint: str = "", **more: Any) -> ArgumentFault:
        """A fault of this parameter."""
        return ArgumentFault(self.param, f"{self.label}.{self.param}: {says}", hint, **more)


def wants(schema: Mapping[str, Any]) -> str:
    """What a schema expects, as messages put it: `a length (mm)`, `text`."""
    unit = schema.get("unit")
    if unit:
        kind = kind_of_unit(unit)
        return kind if kind.endswith(unit) else f"{kind} ({unit})"
    if "enum" in schema:
        return f"one of {listed(str(item) for item in schema['enum'])}"
    kinds = schema.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    said = [TYPE_WORDS.get(kind, kind) for kind in kinds if kind != "null"]
    return " or ".join(said).replace("a number", "a plain number") or "another value"


def quotes_for_text(value: Any, schema: Mapping[str, Any]) -> str:
    """The hint for a number where text is expected; else nothing."""
    fits = is_number(value) and schema.get("type") == "string"
    return f'write "{value}" for text' if fits else ""


def bounds(schema: Mapping[str, Any], limit: Limit | None) -> tuple[float | None, float | None]:
    """The lowest and highest number allowed by the contract and this bench together."""
    lows = [
        schema.get("minimum"),
        schema.get("exclusiveMinimum"),
        _bare(limit and limit.minimum, schema),
    ]
    highs = [
        schema.get("maximum"),
        schema.get("exclusiveMaximum"),
        _bare(limit and limit.maximum, schema),
    ]
    low = max((b for b in lows if b is not None), default=None)
    return low, min((b for b in highs if b is not None), default=None)


def _bare(value: Any, schema: Mapping[str, Any]) -> float | None:
    unit = schema.get("unit")
    if value is None or (unit is None and isinstance(value, str)):
        return None
    return magnitude_in(value, unit) if unit else value


def bounds_text(schema: Mapping[str, Any], limit: Limit | None) -> str:
    """`0..4 mm`, `at most 4 mm`."""
    low, high = bounds(schema, limit)
    unit = f" {schema['unit']}" if schema.get("unit") else ""
    if low is not None and low == schema.get("exclusiveMinimum"):
        unit += f" ({number_text(low)} excluded)"
    if low is not None and high is not None:
        return f"{number_text(low)}..{number_text(high)}{unit}"
    if high is not None:
        return f"at most {number_text(high)}{unit}"
    return f"at least {number_text(low or 0)}{unit}"


def check_limit(value: Any, wanted: Wanted) -> None:
    """Raise ArgumentFault for a number outside the limits of this bench."""
    limit = wanted.limit
    if limit is None or not is_number(value):
        return
    try:
        low, high = _bare(limit.minimum, wanted.schema), _bare(limit.maximum, wanted.schema)
    except UnitError as fault:
        raise wanted.fault(f"the lab's limit cannot be used: {fault}", code="E207") from fault
    if (low is not None and value < low) or (high is not None and value > high):
        raise outside(value, wanted, "this lab")


def outside(value: Any, wanted: Wanted, who: str) -> ArgumentFault:
    unit = f" {wanted.unit}" if wanted.unit else ""
    limit = wanted.limit if who == "this lab" else None
    try:
        text = bounds_text(wanted.schema, limit)
    except UnitError:
        text = bounds_text(wanted.schema, None)
    says = f"{number_text(value)}{unit} is outside {wanted.param} {text}"
    hint = f"a limit of {who}"
    return wanted.fault(says, hint, code="E207", bounds=f"{wanted.param} {text}")
