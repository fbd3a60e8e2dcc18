"""The operators of expressions, with units, null and limits.

Null propagates through arithmetic and comparisons as through `a.b`: what is computed from null is
null. A bare 0 fits any unit.
"""

import ast
import operator as op
from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Any

from ...schemas.quantity import (
    UnitError,
    cancels_out,
    degree,
    has_offset,
    is_number,
    is_quantity,
    kind_of_unit,
    number_text,
    quantity,
    quantity_text,
    seconds,
)
from .moments import is_moment, moment_text

MOST_BITS = 1000
LONGEST_TEXT = 100_000


class OperatorFault(ValueError):
    """Two values that cannot be combined; the message says which and why."""


def words(value: Any) -> str:
    """A value as messages name it."""
    if value is None:
        return "null"
    if is_quantity(value):
        return quantity_text(value)
    if isinstance(value, datetime):
        return moment_text(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return number_text(value)
    if isinstance(value, str):
        return repr(value if len(value) < 60 else value[:57] + "...")
    return (
        "a list" if isinstance(value, list | tuple) or hasattr(value, "item") else "a set of fields"
    )


def fit(a: Any, b: Any, verb: str) -> tuple[Any, Any]:
    """Two values of one dimension; a bare 0 takes the unit of the other."""
    if is_quantity(a) and is_number(b) and b == 0:
        return a, quantity(0, str(a.units))
    if is_quantity(b) and is_number(a) and a == 0:
        return quantity(0, str(b.units)), b
    if is_quantity(a) != is_quantity(b):
        raise OperatorFault(f"{words(a)} and {words(b)} cannot be {verb}: one of them has no unit")
    if is_quantity(a) and is_quantity(b):
        if not a.units.is_compatible_with(b.units):
            raise OperatorFault(
                f"{words(a)} is {kind_of_unit(str(a.units))} and {words(b)} is "
                f"{kind_of_unit(str(b.units))}; they cannot be {verb}"
            )
    elif not (is_number(a) and is_number(b)):
        raise OperatorFault(f"{words(a)} and {words(b)} cannot be {verb}")
    return a, b


def _steady(*values: Any) -> None:
    for value in values:
        if _offset(value):
            raise OperatorFault(
                f"{words(value)} is on a scale with an offset zero; compute in kelvin (K)"
            )


def add(a: Any, b: Any) -> Any:
    """Sums of numbers and quantities; texts and lists are joined."""
    if isinstance(a, str | list) and type(a) is type(b):
        if len(a) + len(b) > LONGEST_TEXT:
            raise OperatorFault("the result would be too long")
        return a + b
    if is_moment(a) or is_moment(b):
        return _later(a, b, 1, "added") if is_moment(a) else _later(b, a, 1, "added")
    a, b = fit(a, b, "added")
    if _offset(b) and not _offset(a):
        a, b = b, a
    if _offset(a) and _offset(b):
        raise OperatorFault(
            f"{words(a)} and {words(b)} are places on a scale; add a difference in K"
        )
    if _offset(a):
        return _moved(a, b, 1)
    return a + b


def subtract(a: Any, b: Any) -> Any:
    """Differences; of two temperatures in °C it is in K, and °C less K is °C."""
    if is_moment(a) and is_moment(b):
        return quantity((a - b).total_seconds(), "s")
    if is_moment(a):
        return _later(a, b, -1, "subtracted")
    a, b = fit(a, b, "subtracted")
    if not _offset(a):
        if _offset(b):
            raise OperatorFault(f"{words(a)} less {words(b)}: give both in °C, or both in K")
        return a - b
    unit = str(a.units)
    return (
        difference(a.magnitude - b.to(a.units).magnitude, unit) if _offset(b) else _moved(a, b, -1)
    )


def _later(at: datetime, by: Any, sign: int, verb: str) -> datetime:
    """A moment some time later, or earlier."""
    try:
        if is_quantity(by) or (is_number(by) and by == 0):
            return at + sign * timedelta(seconds=seconds(by))
    except UnitError:
        pass  # said below, with what it should be
    raise OperatorFault(f"{words(at)} and {words(by)} cannot be {verb}: a moment needs a time (s)")


def difference(value: float, unit: str) -> Any:
    """A difference of two values in this unit: of temperatures in °C it is in K."""
    if not has_offset(unit):
        return quantity(value, unit)
    return quantity(float(f"{value * _kelvin(unit):.14g}"), "K")


def _moved(a: Any, by: Any, sign: int) -> Any:
    unit = str(a.units)
    return quantity(
        float(f"{a.magnitude + sign * by.to('K').magnitude / _kelvin(unit):.14g}"), unit
    )


def _kelvin(unit: str) -> float:
    """How many kelvin one degree of a scale is."""
    return float((1.0 * degree(unit)).to("K").magnitude)


def _offset(value: Any) -> bool:
    return is_quantity(value) and not value._is_multiplicative


def _factors(a: Any, b: Any, verb: str) -> None:
    for value in (a, b):
        if not (is_number(value) or is_quantity(value)):
            raise OperatorFault(f"{words(a)} and {words(b)} cannot be {verb}")
    _steady(a, b)


def multiply(a: Any, b: Any) -> Any:
    _factors(a, b, "multiplied")
    return _plain(a * b)


def divide(a: Any, b: Any) -> Any:
    _factors(a, b, "divided")
    if (b.magnitude if is_quantity(b) else b) == 0:
        raise OperatorFault(f"{words(a)} is divided by zero")
    return _plain(a / b)


def _plain(value: Any) -> Any:
    """A quantity whose units cancelled out as a bare number: 4 mm / 100 um is 40."""
    if is_quantity(value) and cancels_out(value.units):
        return float(f"{value.to('').magnitude:.14g}")
    return value


def floor_divide(a: Any, b: Any) -> Any:
    a, b = _whole_parts(a, b)
    return a // b


def remainder(a: Any, b: Any) -> Any:
    unit = str(a.units) if is_quantity(a) else None
    a, b = _whole_parts(a, b)
    return a % b if unit is None else quantity(a % b, unit)


def _whole_parts(a: Any, b: Any) -> tuple[Any, Any]:
    a, b = fit(a, b, "divided")
    if is_quantity(a):
        a, b = a.magnitude, b.to(a.units).magnitude
    if b == 0:
        raise OperatorFault(f"{words(a)} is divided by zero")
    return a, b


def power(a: Any, b: Any) -> Any:
    """Powers with a limit, so that a huge result cannot block the run."""
    if not is_number(b) or not (is_number(a) or is_quantity(a)):
        raise OperatorFault(f"{words(a)} cannot be raised to {words(b)}")
    _steady(a)
    if abs(b) > MOST_BITS or (isinstance(a, int) and a.bit_length() * abs(b) > MOST_BITS):
        raise OperatorFault(f"{words(a)} to the power of {words(b)} is too large")
    if (a.magnitude if is_quantity(a) else a) == 0 and b < 0:
        raise OperatorFault("0 to a negative power is a division by zero")
    result = a**b
    if isinstance(result, complex):
        raise OperatorFault(f"{words(a)} has no real power of {words(b)}")
    return result


def negative(a: Any) -> Any:
    _factors(a, 0, "negated")
    return -a


def positive(a: Any) -> Any:
    _factors(a, 0, "taken as a number")
    return a


def equal(a: Any, b: Any) -> bool:
    if is_quantity(a) or is_quantity(b):
        try:
            a, b = fit(a, b, "compared")
        except OperatorFault:
            return False
        return bool(a == b)
    return bool(a == b)


def _ordered(compare: Callable[[Any, Any], bool]) -> Callable[[Any, Any], bool]:
    def ordered(a: Any, b: Any) -> bool:
        alike = isinstance(a, str) and isinstance(b, str)
        if not (alike or (is_moment(a) and is_moment(b))):
            a, b = fit(a, b, "compared")
        return bool(compare(a, b))

    return ordered


def contains(item: Any, container: Any) -> bool:
    if isinstance(container, str) and not isinstance(item, str):
        raise OperatorFault(f"{words(item)} cannot be in {words(container)}")
    try:
        return (
            any(equal(item, other) for other in container)
            if isinstance(container, list)
            else item in container
        )
    except TypeError as fault:
        raise OperatorFault(f"{words(container)} has no items to search") from fault


def _or_null(function: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda a, b: None if a is None or b is None else function(a, b)


OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: _or_null(add),
    ast.Sub: _or_null(subtract),
    ast.Mult: _or_null(multiply),
    ast.Div: _or_null(divide),
    ast.FloorDiv: _or_null(floor_divide),
    ast.Mod: _or_null(remainder),
    ast.Pow: _or_null(power),
    ast.USub: lambda a: None if a is None else negative(a),
    ast.UAdd: lambda a: None if a is None else positive(a),
    ast.Not: op.not_,
    ast.Eq: equal,
    ast.NotEq: lambda a, b: not equal(a, b),
    ast.Lt: _or_null(_ordered(op.lt)),
    ast.LtE: _or_null(_ordered(op.le)),
    ast.Gt: _or_null(_ordered(op.gt)),
    ast.GtE: _or_null(_ordered(op.ge)),
    ast.In: contains,
    ast.NotIn: lambda a, b: not contains(a, b),
    ast.Is: equal,
    ast.IsNot: lambda a, b: not equal(a, b),
}
