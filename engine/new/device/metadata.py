"""Parameters and results of actions from what Python libraries say: units, choices, signatures."""

import inspect
import re
import types
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, Literal, Union, get_args, get_origin

from ....schemas.quantity import UnitError, is_number, unit_of

Schema = dict[str, Any]
UNITS = {
    "V": "V|[Vv]olts?", "A": "A|[Aa]mps?|[Aa]mperes?", "ohm": "[Oo]hms?|Ω", "Hz": "Hz|[Hh]ertz",
    "s": "s|[Ss]ec(?:ond)?s?", "K": "K|[Kk]elvins?", "degC": "°C|deg(?:rees)? ?C(?:elsius)?|[Cc]elsius|C",
    "W": "W|[Ww]atts?", "T": "T|[Tt]esla", "deg": "deg(?:rees)?|°", "m": "m|met(?:er|re)s?", "nm": "nm",
    "mm": "mm", "kHz": "kHz", "MHz": "MHz", "GHz": "GHz", "mV": "mV", "mA": "mA", "percent": "%|percent",
    "uL": "[uµ][lL]|microliters?", "rpm": "[Rr][Pp][Mm]", "g": "g|grams?", "mg": "mg", "min": "min|minutes",
}  # fmt: skip
"""Unit -> how libraries and their documentation write it."""
BRACKETS = re.compile(r"\(([^)]+)\)")
KINDS = {bool: "boolean", int: "integer", float: "number", str: "string"}


def unit(text: str) -> Schema:
    """`{"unit": "V"}` for a unit as a library has it, nothing for what is none."""
    text = text.strip()
    for known, names in UNITS.items():
        if re.fullmatch(names, text):
            return {"unit": known}
    try:
        unit_of(text)
    except UnitError:
        return {}
    return {"unit": text} if text else {}


def unit_in(words: str) -> Schema:
    """The unit that documentation names: `in Volts`, `(V)`."""
    for text in (*re.findall(r"\bin (\S+?)[,.;)]?(?=\s|$)", words), *BRACKETS.findall(words)):
        for known, names in UNITS.items():
            if re.fullmatch(names, text):
                return {"unit": known}
    return {}


def choices(allowed: Sequence[Any]) -> Schema:
    """One of several values; a member of an Enum is its name, unless it equals its value."""
    kept = [_value(one) for one in allowed if one is not None]
    if all(isinstance(one, bool) for one in kept):
        return {"type": "boolean"}
    if all(is_number(one) for one in kept):
        whole = all(isinstance(one, int) for one in kept)
        return {"type": "integer" if whole else "number", "enum": sorted(kept)}
    return {"type": "string", "enum": list(dict.fromkeys(str(one) for one in kept))}


def _value(one: Any) -> Any:
    if not isinstance(one, Enum):
        return one
    return one.value if isinstance(one, (str, int)) else one.name


def of_annotation(annotation: Any) -> Schema | None:
    """The schema of a Python annotation; None for what JSON has no counterpart of."""
    if annotation in KINDS:
        return {"type": KINDS[annotation]}
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return choices(list(annotation))
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        return choices(args)
    if origin in (Union, types.UnionType):
        found = [one for arg in args if (one := of_annotation(arg)) is not None]
        return max(found, key=lambda one: one["type"] in ("number", "array"), default=None)
    if origin in (list, tuple, Sequence) and args and (inner := of_annotation(args[0])) is not None:
        return {"type": "array", "items": inner}
    return None


def parameters(
    function: Callable[..., Any], of: Callable[[inspect.Parameter], Schema | None]
) -> dict[str, Schema] | None:
    """Parameter -> schema of a method; None if one that it needs has no schema by `of`."""
    try:
        signature = inspect.signature(function, eval_str=True)
    except Exception:  # an annotation that is only there for type checkers
        signature = inspect.signature(function)
    made: dict[str, Schema] = {}
    for param in [one for one in signature.parameters.values() if one.name != "self"]:
        if param.kind in (param.VAR_KEYWORD, param.VAR_POSITIONAL):
            continue
        schema, needed = of(param), param.default is param.empty
        if needed and (schema is None or param.kind is param.POSITIONAL_ONLY):
            return None
        if needed:
            made[param.name] = schema or {}
        elif schema is not None and type(param.default) in KINDS:
            made[param.name] = {**schema, "default": param.default}
        elif schema is not None and param.default is None and "enum" not in schema:
            made[param.name] = {**schema, "type": [schema["type"], "null"], "default": None}
    return made


def of_parameter(param: inspect.Parameter) -> Schema | None:
    """By its annotation, else by its default; a number where there is neither."""
    if param.annotation is not param.empty:
        found = param.annotation
        by_name = {kind.__name__: kind for kind in KINDS}
        return of_annotation(by_name.get(found, found) if isinstance(found, str) else found)
    if param.default is param.empty:
        return {"type": "number"}
    kind = KINDS.get(type(param.default))
    return {"type": kind} if kind else None


def method(name: str, function: Callable[..., Any]) -> Schema | None:
    """An action that calls a method; None if it needs what JSON has no counterpart of."""
    params = parameters(function, of_parameter)
    if params is None:
        return None
    return {"call": name, **({"params": params} if params else {}), "effect": "once"}
