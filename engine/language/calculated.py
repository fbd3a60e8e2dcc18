"""The types that the calculating functions return."""

from collections.abc import Mapping

from ...schemas.quantity import has_offset, unit_of
from .types import ANY, INTEGER, NUMBER, Type, number

OF_LISTS = {"sum", "mean", "median", "stdev", "sorted", "reversed"}
KEPT = {"abs", "floor", "ceil"}
BARE = {"exp", "log", "log10", "int"}
OF_NUMBERS = {*KEPT, *BARE, "sqrt", "sin", "cos", "tan"}


def type_of_calculation(name: str, given: Mapping[str, Type]) -> Type:
    """The type for arguments of these types; ANY where it depends on their values."""
    values = list(given.values())
    first = values[0] if values else ANY
    if name in OF_LISTS:
        return _of_a_list(name, first)
    if name in KEPT:
        return first if name == "abs" or first.unit is not None else INTEGER
    if name == "linspace":
        united = next((one for one in values if one.unit is not None), first)
        return Type("list", item=number(united.unit))
    if name == "sqrt":
        return number(str(unit_of(first.unit) ** 0.5)) if first.unit is not None else NUMBER
    if name == "interp":
        return given["ys"].item or ANY
    if name in ("zip", "enumerate", "polyfit"):
        return Type("list", item=Type("list", item=ANY) if name != "polyfit" else ANY)
    return {"int": INTEGER, "atan2": number("rad")}.get(name, NUMBER)


def _of_a_list(name: str, values: Type) -> Type:
    item = values.item or ANY
    if name in ("sorted", "reversed"):
        return values
    if name == "stdev" and item.unit is not None and has_offset(item.unit):
        return Type("number", "K", difference=True)
    return number(item.unit) if item.kind == "number" else ANY
