"""Check that a parameter's declaration is consistent: unit, bounds, pattern, choices."""

from collections.abc import Iterator
from typing import Any

from ...schemas.patterns import PatternFault, regular_expression
from ...schemas.problem import Problem
from ...schemas.protocol import Param
from ...schemas.quantity import QUANTITY, unit_fault
from ..language.operators import words
from ..language.source import Source
from ..language.suggest import did_you_mean
from .value import ParamFault, a_kind, convert

UNITS = (
    "m", "mm", "cm", "um", "nm", "inch", "meter", "millimeter", "centimeter", "micrometer",
    "nanometer", "s", "ms", "us", "ns", "min", "h", "second", "minute", "hour", "g", "mg", "ug",
    "kg", "gram", "L", "mL", "uL", "liter", "milliliter", "microliter", "degC", "K", "kelvin", "bar",
    "mbar", "Pa", "kPa", "V", "mV", "A", "mA", "W", "mW", "J", "mJ", "Hz", "kHz", "rpm", "deg",
    "rad", "percent", "mol", "mmol", "mm/s", "mm/min", "mL/min", "mm**2", "mm**3", "pixel",
)  # fmt: skip
"""Common units; used only to suggest what was meant."""

ORDERED = ("quantity", "number", "integer")


def declaration_faults(name: str, param: Param, source: Source) -> Iterator[Problem]:
    """Everything in a declaration that contradicts the rest of it; the default is not checked."""
    unit = list(_unit(name, param, source))
    if unit:
        yield from unit  # without its unit nothing else can be checked
        return
    yield from _misplaced(name, param, source)
    yield from _pattern(name, param, source)
    yield from _bounds(name, param, source)
    yield from _choices(name, param, source)


def _wrong(
    name: str, at: tuple[str | int, ...], source: Source, message: str, hint: str = "",
    *, key: bool = False,
) -> Problem:  # fmt: skip
    return source.problem(("params", name, *at), "E224", f"{name}: {message}", hint, key=key)


def _unit(name: str, param: Param, source: Source) -> Iterator[Problem]:
    if param.type == "quantity" and param.unit is None:
        yield _wrong(name, (), source, "a quantity needs its unit", "add `unit: mm`", key=True)
    elif param.type != "quantity" and param.unit is not None:
        hint = "write `type: quantity`"
        if param.type == "array":
            hint = (
                f"give the unit of the list's items: `items: {{type: number, unit: {param.unit}}}`"
            )
        yield _wrong(name, ("unit",), source, f"{a_kind(param.type)} has no unit", hint, key=True)
    elif param.unit is not None:
        said = (param.default, param.minimum, param.maximum)
        beside = [found[2] for one in said if (found := QUANTITY.match(str(one)))]
        fault = unit_fault(param.unit, f"{name} {param.summary}", beside)
        if fault:
            guess = "" if "; " in fault else did_you_mean(param.unit, UNITS)
            yield _wrong(
                name, ("unit",), source, f"{fault}{guess}", "such as mm, s, degC or mL/min"
            )


def _misplaced(name: str, param: Param, source: Source) -> Iterator[Problem]:
    """Keys that do not apply to this type."""
    if param.pattern is not None and param.type != "string":
        hint = "a pattern is for text; `minimum` and `maximum` are for numbers"
        yield _wrong(
            name, ("pattern",), source, f"{a_kind(param.type)} has no pattern", hint, key=True
        )
    if param.items is not None and param.type != "array":
        hint = "write `type: array`"
        yield _wrong(name, ("items",), source, f"{a_kind(param.type)} has no items", hint, key=True)
    for bound in ("minimum", "maximum"):
        if getattr(param, bound) is not None and param.type not in ORDERED:
            hint = "use `enum` for a list of choices" if param.type == "string" else ""
            yield _wrong(
                name, (bound,), source, f"{a_kind(param.type)} has no {bound}", hint, key=True
            )


def _pattern(name: str, param: Param, source: Source) -> Iterator[Problem]:
    if param.pattern is None or param.type != "string":
        return
    try:
        regular_expression(param.pattern)
    except PatternFault as fault:
        message = f"{param.pattern!r} is not a pattern that can be used: {fault}"
        yield _wrong(name, ("pattern",), source, message)


def _bounds(name: str, param: Param, source: Source) -> Iterator[Problem]:
    if param.type not in ORDERED:
        return
    found: dict[str, Any] = {}
    for bound in ("minimum", "maximum"):
        value = getattr(param, bound)
        if value is None:
            continue
        try:
            found[bound] = convert(param, value)
        except ParamFault as fault:
            yield _wrong(name, (bound,), source, f"the {bound}: {fault}")
    if len(found) == 2 and found["minimum"] > found["maximum"]:
        low, high = words(found["minimum"]), words(found["maximum"])
        message = f"the minimum {low} is above the maximum {high}: no value fits"
        yield _wrong(name, ("minimum",), source, message)


def _choices(name: str, param: Param, source: Source) -> Iterator[Problem]:
    for index, choice in enumerate(param.enum or []):
        try:
            convert(param, choice)
        except ParamFault as fault:
            hint = ""
            if param.type == "string" and isinstance(choice, int | float):
                hint = 'text that looks like a number needs quotes: "..."'
            yield _wrong(name, ("enum", index), source, f"the choice {fault}", hint)
