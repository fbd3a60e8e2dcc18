"""Shapes of the values that a protocol computes or writes with a unit.

Every shape is flat: `minimum` applies only to numbers and `pattern` only to texts, so one schema
covers both and a fault points at the value itself instead of at a list of alternatives.
"""

import re
from typing import Any

from ...schemas.quantity import QUANTITY, UnitError, same_dimension

Shape = dict[str, Any]

COMPUTED = r"\$\{\{"
NUMBER = r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\s*"
COMMON_UNITS = (
    "mm", "cm", "m", "km", "um", "µm", "nm", "pm", "inch",
    "s", "ms", "us", "µs", "ns", "min", "h", "hour", "day",
    "g", "kg", "mg", "ug", "µg", "ng", "L", "l", "mL", "ml", "uL", "ul", "µL", "nL",
    "degC", "K", "Pa", "kPa", "hPa", "MPa", "bar", "mbar", "V", "mV", "A", "mA", "W", "mW",
    "Hz", "kHz", "MHz", "J", "mJ", "N", "deg", "rad", "mol", "mmol",
    "mm/s", "mm/min", "m/s", "mL/min", "uL/s", "mm**2", "mm^2",
)  # fmt: skip
"""Common units; one of another dimension is rejected, an unusual one is accepted."""


def quantity_pattern(unit: str | None) -> str:
    """The pattern of text with a unit; common units of another dimension are excluded."""
    wrong = [re.escape(other) for other in COMMON_UNITS if unit and not _fits(other, unit)]
    refused = f"(?!{NUMBER}(?:{'|'.join(wrong)})\\s*$)" if wrong else ""
    return f"^{refused}{QUANTITY.pattern.removeprefix('^')}"


def _fits(unit: str, other: str) -> bool:
    try:
        return same_dimension(unit, other)
    except UnitError:
        return True


def quantity(unit: str | None, says: str, *, computed: bool = True, **more: Any) -> Shape:
    """A number in the expected unit, or text with a unit, or (`computed`) an expression."""
    pattern = quantity_pattern(unit)
    expression = " or ${{ ... }}" if computed else ""
    return {
        "type": ["number", "string"],
        "pattern": f"(?:{pattern})|{COMPUTED}" if computed else pattern,
        "patternErrorMessage": f"Expected {says}{expression}.",
        **more,
    }


def computed(*types: str, says: str, **more: Any) -> Shape:
    """A value of these types, or an expression; any other text is rejected."""
    return {
        "type": [*types, "string"],
        "pattern": COMPUTED,
        "patternErrorMessage": f"Expected {says} or ${{{{ ... }}}}.",
        **more,
    }


def names(pattern: str, longest: int, each: Any, **more: Any) -> Shape:
    """A mapping from names to values of the shape `each`."""
    said = "A name has letters (a to z), digits and _, and begins with a letter."
    return {
        "type": "object",
        "propertyNames": {"pattern": pattern, "maxLength": longest, "patternErrorMessage": said},
        "additionalProperties": each,
        **more,
    }


def time(*, computed: bool = True, **more: Any) -> Shape:
    """A duration; a bare number is in seconds."""
    return quantity("s", "a time such as 30 s or 2 min", computed=computed, **more)


def condition() -> Shape:
    """True, false or an expression."""
    return computed("boolean", says="true, false")


def count() -> Shape:
    """A whole number from 0."""
    return computed("integer", says="a whole number", minimum=0)


def items() -> Shape:
    """The items of a loop."""
    return computed("array", says="a list such as [1, 2, 3], a span or a grid in")
