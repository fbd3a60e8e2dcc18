"""The actions of an instrument as PyMeasure describes it: units, ranges and choices from its metadata.

Effects are guessed carefully: reading is `pure`, setting `idempotent`, and a method `once`.
"""

import inspect
import math
import re
from collections.abc import Iterator
from typing import Any

from ....drivers.bridges.pymeasure import instrument_class
from ..protocol import CannotMake
from .sources import Described

UNITS = {
    "V": "V|[Vv]olts?", "A": "A|[Aa]mps?|[Aa]mperes?", "ohm": "[Oo]hms?|Ω", "Hz": "Hz|[Hh]ertz",
    "s": "s|[Ss]ec(?:ond)?s?", "K": "K|[Kk]elvins?", "degC": "°C|deg(?:rees)? ?C(?:elsius)?|[Cc]elsius",
    "W": "W|[Ww]atts?", "T": "T|[Tt]esla", "deg": "deg(?:rees)?", "m": "m|met(?:er|re)s?", "nm": "nm",
    "mm": "mm", "kHz": "kHz", "MHz": "MHz", "GHz": "GHz", "mV": "mV", "mA": "mA", "percent": "%|percent",
}  # fmt: skip
KINDS = {"boolean": r"\bbool", "string": r"\bstr(ing)?\b", "array": r"\barray\b|\blist\b"}
BRACKETS = re.compile(r"\(([^)]+)\)")


def describe(source: str) -> Described:
    """The instrument behind `pymeasure:MODULE.CLASS`; raises CannotMake."""
    instrument = source.partition(":")[2]
    try:
        found = instrument_class(instrument)
    except OSError as fault:
        raise CannotMake(str(fault)) from fault
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
        unsure=frozenset(name for name, said in actions.items() if "call" in said),
    )


def _actions(found: type) -> Iterator[tuple[str, dict[str, Any]]]:
    from pymeasure.instruments import Instrument  # pyright: ignore[reportMissingImports]

    base = set(dir(Instrument))
    names = [name for name in dir(found) if not name.startswith("_") and name not in base]
    for name in names:
        one = inspect.getattr_static(found, name)
        if isinstance(one, property):
            yield from _property(name, one)
        elif inspect.isfunction(one) and (said := _method(name, one)) is not None:
            yield name, said


def _property(name: str, one: property) -> Iterator[tuple[str, dict[str, Any]]]:
    given, words = _defaults(one.fset), " ".join((one.__doc__ or "").split())
    schema = _schema(given, words)
    gettable = one.fget is not None and _defaults(one.fget).get("get_command", "") is not None
    settable = one.fset is not None and given.get("set_command", "") is not None
    if gettable:
        plain = {k: v for k, v in schema.items() if k in ("type", "unit", "items")}
        yield f"read_{name}", {"get": name, "returns": {name: plain}}
    if settable:
        yield f"set_{name}", {"set": name, "params": {name: schema}, "effect": "idempotent"}


def _defaults(function: Any) -> dict[str, Any]:
    """What the library's factory gave the function of a property."""
    if function is None:
        return {}
    return {n: p.default for n, p in inspect.signature(function).parameters.items()}


def _schema(given: dict[str, Any], words: str) -> dict[str, Any]:
    allowed, validator = given.get("values"), getattr(given.get("validator"), "__name__", "")
    if isinstance(allowed, dict):
        return _choices(list(allowed))
    if isinstance(allowed, (list, tuple, range)) and len(allowed):
        if validator.endswith("range") and all(_is_number(one) for one in allowed):
            limits = {"minimum": min(allowed), "maximum": max(allowed)}
            limits = {name: one for name, one in limits.items() if math.isfinite(one)}
            return {"type": "number", **_unit(words), **limits}
        if "discrete" in validator or given.get("map_values"):
            return {**_choices(list(allowed)), **_unit(words)}
    for kind, sign in KINDS.items():
        if re.search(sign, words):
            return {"type": kind}
    return {"type": "number", **_unit(words)}


def _choices(choices: list[Any]) -> dict[str, Any]:
    if set(choices) <= {True, False} and all(isinstance(one, bool) for one in choices):
        return {"type": "boolean"}
    numbers = all(_is_number(one) for one in choices)
    kept = [c for c in choices if isinstance(c, str) or _is_number(c)]
    return {
        "type": "number" if numbers else "string",
        "enum": kept if numbers else [str(c) for c in kept],
    }


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _unit(words: str) -> dict[str, str]:
    """The unit that its documentation names: `in Volts`, `(V)`."""
    for text in (*re.findall(r"\bin (\S+?)[,.;)]?(?=\s|$)", words), *BRACKETS.findall(words)):
        for unit, names in UNITS.items():
            if re.fullmatch(names, text):
                return {"unit": unit}
    return {}


def _method(name: str, one: Any) -> dict[str, Any] | None:
    """A method whose parameters are numbers, texts or booleans; any other needs Python."""
    params: dict[str, Any] = {}
    for param in list(inspect.signature(one).parameters.values())[1:]:
        if param.kind in (param.VAR_KEYWORD, param.VAR_POSITIONAL, param.POSITIONAL_ONLY):
            return None
        needed = param.default is param.empty
        kinds = {bool: "boolean", int: "number", float: "number", str: "string"}
        kind = kinds.get(param.annotation if needed else type(param.default))
        if needed:
            params[param.name] = {"type": kind or "number"}
        elif kind is not None:
            params[param.name] = {"type": kind, "default": param.default}
    said = {"params": params} if params else {}
    return {"call": name, **said, "effect": "once"}
