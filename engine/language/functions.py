"""The functions of the expression language; pure, bounded, and with units."""

import ast
import re
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Any

from ...schemas.quantity import is_number, is_quantity, quantity, quantity_text
from .calculations import CALCULATIONS
from .grid import LONGEST, Grid, Span, grid, span
from .inside import inside
from .moments import moment_text
from .operators import OPERATORS, OperatorFault, words

SPEC = re.compile(r"[<>^+\- ]?0?\d{0,2}[,_]?(?:\.\d{1,2})?[a-zA-Z%]?")
DAY_SPEC = re.compile(r"(?:%[YmdHMSfjyzbaBA]|[^%{}]){0,60}")
LONGEST_WALK = 1_000_000


def literal(number: float, unit: str) -> Any:
    """`0.1 mm` inside an expression."""
    return quantity(number, unit)


def a_range(*bounds: int) -> range:
    """Whole numbers without the last one, as in Python."""
    if not 1 <= len(bounds) <= 3 or not all(type(b) is int for b in bounds):
        raise OperatorFault(
            "range takes one to three whole numbers: range(5), range(2, 10, 2); span(0, 1, 0.1) takes any"
        )
    if len(bounds) == 3 and bounds[2] == 0:
        raise OperatorFault("range: a step of 0 never reaches the end")
    if any(abs(bound) > LONGEST for bound in bounds):
        raise OperatorFault(f"range: more than {LONGEST:,}")
    return range(*bounds)


def length(values: Any) -> int:
    """The number of items or characters."""
    if not isinstance(values, Sequence | Mapping):
        raise OperatorFault(f"len: {words(values)} has no length")
    return len(values)


def least(*values: Any) -> Any:
    """The smallest of several values, or of one list."""
    return _extreme("min", OPERATORS[ast.Lt], values)


def greatest(*values: Any) -> Any:
    """The largest of several values, or of one list."""
    return _extreme("max", OPERATORS[ast.Gt], values)


def _extreme(name: str, before: Callable[[Any, Any], Any], values: Sequence[Any]) -> Any:
    if len(values) == 1:
        values = _items(name, values[0])
    known = [value for value in values if value is not None]
    if not known:
        return None
    best = known[0]
    for value in known[1:]:
        if before(value, best):
            best = value
    return best


def _items(name: str, value: Any) -> Sequence[Any]:
    if isinstance(value, Span):
        return value.ends()
    if isinstance(value, str | Grid) or not isinstance(value, Sequence):
        raise OperatorFault(f"{name} takes several values, or a list; {words(value)} is neither")
    if len(value) > LONGEST_WALK:
        raise OperatorFault(f"{name}: a list of {len(value):,} items is too long")
    return value


def a_round(value: Any, digits: int = 0) -> Any:
    """Rounded to this many decimal places; a quantity keeps its unit."""
    if type(digits) is not int or abs(digits) > 20:
        raise OperatorFault("round: the number of digits must be a small whole number: round(x, 2)")
    if value is None:
        return None
    if is_quantity(value):
        return quantity(round(value.magnitude, digits), str(value.units))
    if not is_number(value):
        raise OperatorFault(f"round: {words(value)} is not a number")
    return round(value, digits) if digits else round(value)


def a_format(value: Any, spec: str = "") -> str:
    """A value as text: `format(x, '.2f')`, `format(now(), '%H:%M')`; a quantity keeps its unit."""
    if isinstance(value, datetime) and isinstance(spec, str) and DAY_SPEC.fullmatch(spec):
        return value.strftime(spec) if spec else moment_text(value)
    if not isinstance(spec, str) or not SPEC.fullmatch(spec):
        raise OperatorFault(f"format: {words(spec)} is not a format such as '.2f' or '04d'")
    if value is None:
        return "null"
    try:
        if is_quantity(value):
            unit = f"{value.units:~P}"
            return quantity_text(value) if not spec else f"{format(value.magnitude, spec)} {unit}"
        return format(value, spec)
    except (ValueError, TypeError) as fault:
        raise OperatorFault(f"format: {words(value)} does not fit {spec!r}") from fault


def no_table(file: Any = None, **kinds: Any) -> Any:
    """The rows of a table beside the protocol; a column's unit is in its heading or given: `x='mm'`.

    `table.Tables` replaces this where a protocol has a folder.
    """
    raise OperatorFault("csv: a table can only be read by a protocol that is a file")


def now() -> Any:
    """The moment of this computer's clock.

    `Run.names` replaces this in a run.
    """
    raise OperatorFault("now: the time is only known in a run")


def elapsed() -> Any:
    """How long the run has taken, pauses and interruptions included.

    `Run.names` replaces this in a run.
    """
    raise OperatorFault("elapsed: the time is only known in a run")


RESERVED: dict[str, Callable[..., Any]] = {
    "grid": grid,
    "span": span,
    "inside": inside,
    "range": a_range,
    "len": length,
    "min": least,
    "max": greatest,
    "round": a_round,
    "format": a_format,
    "csv": no_table,
}
"""Their names mean nothing else in a protocol; those of the other functions may."""
CLOCKS: dict[str, Callable[..., Any]] = {"now": now, "elapsed": elapsed}
"""What they give is kept in the journal, so that a resumed run computes with the same values."""
FUNCTIONS = {**RESERVED, **CALCULATIONS, **CLOCKS}
LITERAL = "_quantity"
