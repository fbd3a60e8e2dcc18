"""What is known about a value before the run: its kind, unit, items and fields."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from functools import lru_cache
from typing import Any, Literal

from ...schemas.protocol import Param
from ...schemas.quantity import PLAIN, UnitError, is_quantity, kind_of_unit, unit_of
from .suggest import closest

Kind = Literal["any", "null", "boolean", "number", "text", "moment", "list", "map"]


@dataclass(frozen=True, slots=True)
class Type:
    """The kind of a value; `unit` of a number, `item` of a list, `fields` and `rest` of a map.

    `whole`: a whole number. `zero`: the bare 0 that fits any unit. `difference`: of two temperatures.
    `choices`: all that a text may be, where that is known. `rest` is the type of fields
    that are not named; None where there are no others. `meant`: a field that one of several maps
    lacks -> the key that only that one has, and that looks like it.
    """

    kind: Kind
    unit: str | None = None
    item: "Type | None" = None
    fields: Mapping[str, "Type"] = field(default_factory=dict)
    rest: "Type | None" = None
    whole: bool = False
    zero: bool = False
    difference: bool = False
    choices: tuple[str, ...] = ()
    meant: Mapping[str, str] = field(default_factory=dict)


ANY = Type("any")
NULL = Type("null")
BOOLEAN = Type("boolean")
NUMBER = Type("number")
INTEGER = Type("number", whole=True)
TEXT = Type("text")
MOMENT = Type("moment")
LIST = Type("list", item=ANY)


def number(unit: str | None, *, whole: bool = False) -> Type:
    """A number with this unit; any value if the unit is unknown, which is reported elsewhere."""
    if unit is not None and unit not in PLAIN:
        try:
            unit_of(unit)
        except UnitError:
            return ANY
    return Type("number", unit=unit, whole=whole)


def fields(**named: Type) -> Type:
    """A map with exactly these fields."""
    return Type("map", fields=named)


LOOP_RESULT = fields(total=INTEGER, succeeded=INTEGER, failed=INTEGER, skipped=INTEGER)
RUN = fields(id=TEXT, name=TEXT, started=TEXT, simulated=BOOLEAN)
ERROR = fields(name=TEXT, message=TEXT, step=TEXT, device=TEXT, action=TEXT)


def in_words(kind: Type) -> str:
    """A type as messages name it: `a length (mm)`, `text`."""
    if kind.kind == "number":
        if kind.unit is not None:
            return _measure(kind.unit)
        return "a whole number" if kind.whole else "a plain number"
    return {
        "any": "a value", "null": "null", "boolean": "true or false", "text": "text",
        "moment": "a moment (a date with its time)", "list": "a list", "map": "a set of fields",
    }[kind.kind]  # fmt: skip


@lru_cache(maxsize=1024)
def _measure(unit: str) -> str:
    short = f"{unit_of(unit):~P}"
    measures = kind_of_unit(unit)
    return f"a quantity in {short}" if measures.endswith(unit) else f"{measures} ({short})"


def type_of_value(value: Any) -> Type:
    """The type of a value that is known."""
    if value is None:
        return NULL
    if isinstance(value, bool):
        return BOOLEAN
    if is_quantity(value):
        return number(str(value.units))
    if isinstance(value, int):
        return Type("number", whole=True, zero=value == 0)
    if isinstance(value, float):
        return Type("number", zero=value == 0)
    if isinstance(value, str):
        return TEXT
    if isinstance(value, datetime):
        return MOMENT
    if isinstance(value, Mapping):
        return Type("map", fields={str(key): type_of_value(item) for key, item in value.items()})
    return Type("list", item=either([type_of_value(item) for item in value[:50]]))


def type_of_param(param: Param) -> Type:
    """The type of a declared parameter."""
    if param.type == "quantity":
        return number(param.unit)
    if param.type == "array":
        return Type("list", item=type_of_schema(param.items or {}))
    if param.type == "string" and param.enum:
        return one_of(param.enum)
    return {"number": NUMBER, "integer": INTEGER, "string": TEXT, "boolean": BOOLEAN}[param.type]


def chosen(choices: Iterable[str]) -> Type:
    """The result of a question with these choices."""
    return fields(choice=one_of(choices))


def one_of(choices: Iterable[Any]) -> Type:
    """A text that is one of these."""
    return Type("text", choices=tuple(str(choice) for choice in choices))


def type_of_schema(schema: Any, *, root: bool = False) -> Type:
    """The type that a JSON Schema of a contract describes; `root`: it is an action's `returns`.

    A map that names its fields has no others, unless `additionalProperties` says which.
    """
    if not isinstance(schema, Mapping):
        return ANY
    if root and not schema:
        return fields()
    kinds = schema.get("type", ())
    kinds = [kinds] if isinstance(kinds, str) else [kind for kind in kinds if kind != "null"]
    if "enum" in schema and not kinds:
        return either([type_of_value(item) for item in schema["enum"]])
    if len(kinds) != 1:
        return ANY if not root else _map(schema)
    kind = kinds[0]
    if kind in ("number", "quantity"):
        return number(schema.get("unit"))
    if kind == "integer":
        return number(schema.get("unit"), whole=True)
    if kind == "array":
        return Type("list", item=type_of_schema(schema.get("items", {})))
    if kind == "object":
        return _map(schema)
    return {"string": TEXT, "boolean": BOOLEAN, "null": NULL}.get(kind, ANY)


def _map(schema: Mapping[str, Any]) -> Type:
    named = {name: type_of_schema(inner) for name, inner in schema.get("properties", {}).items()}
    others = schema.get("additionalProperties", not named)
    if others is False:
        return Type("map", fields=named)
    return Type("map", fields=named, rest=ANY if others is True else type_of_schema(others))


def _either_map(maps: list[Type]) -> Type:
    """A field that none of the maps has is none; what one of them lacks may be anything."""
    names = dict.fromkeys(name for one in maps for name in one.fields)
    named = {name: either([one.fields.get(name, ANY) for one in maps]) for name in names}
    rest = None if all(one.rest is None for one in maps) else ANY
    return Type("map", fields=named, rest=rest, meant=_meant(maps, names) if rest is None else {})


def _meant(maps: list[Type], names: Iterable[str]) -> dict[str, str]:
    """`Liquid` of one for `liquid` of all the others; of two maps only case tells which is the slip."""
    had = Counter(name for one in maps for name in one.fields)
    found: dict[str, str] = {}
    for name in names:
        lacking = [one for one in maps if name not in one.fields]
        own = [key for key in lacking[0].fields if had[key] == 1] if len(lacking) == 1 else []
        near = closest(name, own)
        if near is not None and (len(maps) > 2 or near.casefold() == name.casefold()):
            found[name] = near
    return found


def either(types: list[Type]) -> Type:
    """The type of a value that is one of several."""
    known = [one for one in types if one.kind != "null"]
    if not known:
        return ANY
    first = known[0]
    if all(one.kind == first.kind and one.unit == first.unit for one in known):
        if first.kind in ("list", "map") and any(one != first for one in known):
            return LIST if first.kind == "list" else _either_map(known)
        return Type(
            first.kind, first.unit, first.item, first.fields, first.rest,
            whole=all(one.whole for one in known),
        )  # fmt: skip
    return ANY
