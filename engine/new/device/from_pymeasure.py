"""The actions of an instrument as PyMeasure describes it: units, ranges and choices from its metadata.

Effects are guessed carefully: reading is `pure`, setting `idempotent`, and a method `once`.
"""

import inspect
import math
import re
from collections.abc import Iterator
from typing import Any

from ....drivers.bridges.library import instrument_class
from ....drivers.bridges.pymeasure import PACKAGE, made_of, together
from ....schemas.quantity import is_number
from ..protocol import CannotMake
from .metadata import choices, method, unit_in
from .sources import Described

KINDS = {"boolean": r"\bbool", "string": r"\bstr(ing)?\b", "array": r"\barray\b|\blist\b"}


def describe(source: str) -> Described:
    """The instrument behind `pymeasure:MODULE.CLASS`; raises CannotMake and OSError."""
    instrument = source.partition(":")[2]
    found = instrument_class("PyMeasure", PACKAGE, instrument)
    actions = dict(_actions(found))
    if not actions:
        raise CannotMake(
            f"{instrument} has no properties or methods of its own, only channels: name them by hand, "
            "as `get: ch_1.voltage`"
        )
    return Described(
        driver="pymeasure",
        config={"instrument": instrument, "resource": "GPIB0::22::INSTR"},
        notes={"resource": "where it is, as VISA names it"},
        actions=actions,
    )


def _actions(found: type) -> Iterator[tuple[str, dict[str, Any]]]:
    from pymeasure.instruments import Channel, Instrument  # pyright: ignore[reportMissingImports]

    creator = Instrument.BaseChannelCreator
    yield from _own(found, set(dir(Instrument)))
    for name, made in inspect.getmembers(found, lambda one: isinstance(one, creator)):
        kinds: dict[type, list[Any]] = {}
        for kind, one in made.pairs:
            kinds.setdefault(kind, []).append(one)
        prefix = made.kwargs.get("prefix")
        for kind, ids in kinds.items():
            path = f"{prefix}{{channel}}" if prefix else name
            short = (prefix or name).strip("_") + ("" if len(kinds) == 1 else f"_{ids[0]}")
            channel = choices(ids) if prefix else None
            for action, said in _own(kind, set(dir(Channel))):
                yield _of_channel(action, said, path, short, channel)


def _of_channel(
    action: str, said: dict[str, Any], path: str, short: str, channel: Any
) -> tuple[str, dict[str, Any]]:
    """An action of a channel, which is a parameter where there are several."""
    key = next(one for one in ("get", "set", "call") if one in said)
    params = {**({"channel": channel} if channel else {}), **said.get("params", {})}
    verb, _, rest = action.partition("_")
    name = f"{short}_{action}" if key == "call" else f"{verb}_{short}_{rest}"
    made = {key: f"{path}.{said[key]}", **({"params": params} if params else {})}
    return name.lower(), {**made, **{n: one for n, one in said.items() if n not in (key, "params")}}


def _own(found: type, base: set[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    names = [name for name in dir(found) if not name.startswith("_") and name not in base]
    for name in names:
        one = inspect.getattr_static(found, name)
        if isinstance(one, property):
            yield from _property(name, one)
        elif inspect.isfunction(one) and (said := method(name, one)) is not None:
            yield name, said


def _property(name: str, one: property) -> Iterator[tuple[str, dict[str, Any]]]:
    given, words = made_of(one.fset), " ".join((one.__doc__ or "").split())
    schema, count = _schema(given, words), together(one)
    if count > 1:
        number = {"type": "number"}
        schema = {"type": "array", "items": number, "minItems": count, "maxItems": count}
    gettable = one.fget is not None and made_of(one.fget).get("get_command", "") is not None
    settable = one.fset is not None and given.get("set_command", "") is not None
    if gettable:
        if made_of(one.fget).get("cast") is int and schema["type"] == "number":
            schema = {**schema, "type": "integer"}
        plain = {k: v for k, v in schema.items() if k in ("type", "unit", "items")}
        yield f"read_{name}", {"get": name, "returns": {name: plain}}
    if settable:
        yield f"set_{name}", {"set": name, "params": {name: schema}, "effect": "idempotent"}


def _schema(given: dict[str, Any], words: str) -> dict[str, Any]:
    allowed, validator = given.get("values"), getattr(given.get("validator"), "__name__", "")
    if isinstance(allowed, dict):
        return choices(list(allowed))
    if isinstance(allowed, (list, tuple, range)) and len(allowed):
        if validator.endswith("range") and all(is_number(one) for one in allowed):
            limits = {"minimum": min(allowed), "maximum": max(allowed)}
            limits = {name: one for name, one in limits.items() if math.isfinite(one)}
            return {"type": "number", **unit_in(words), **limits}
        if "discrete" in validator or given.get("map_values"):
            return {**choices(list(allowed)), **unit_in(words)}
    for kind, sign in KINDS.items():
        if re.search(sign, words):
            return {"type": kind}
    return {"type": "number", **unit_in(words)}
