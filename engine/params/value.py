"""One value of a parameter: read from text, converted to its unit, checked against its range."""

import re
from pathlib import Path
from typing import Any

from ...schemas.patterns import check_schema, regular_expression, validator
from ...schemas.protocol import Param
from ...schemas.quantity import UnitError, is_quantity, kind_of_unit, magnitude_in, quantity
from ..language.grid import Lazy
from ..language.operators import words
from ..language.source import parse_source
from ..language.suggest import did_you_mean, listed
from ..language.wanted import bounds_text, quotes_for_text, wants

LONGEST_TEXT = 10_000
_NOWHERE = Path("-p")


class ParamFault(ValueError):
    """A value that a parameter does not accept; the message says why."""

    def __init__(
        self, code: str, message: str, hint: str = "", *, path: tuple[int, ...] = ()
    ) -> None:
        super().__init__(message)
        self.code, self.hint, self.path = code, hint, path


def take(name: str, param: Param, given: Any, *, written: bool = False) -> Any:
    """A value as the protocol uses it; raises ParamFault.

    `written`: it comes from the protocol, with the types of YAML; otherwise it is text.
    """
    value = given if written or not isinstance(given, str) else _from_text(param, given)
    value = convert(param, value)
    _check_range(param, value)
    return value


def given_value(value: Any) -> Any:
    """A computed value as a parameter accepts it: a span or a table as a list of its items."""
    return list(value) if isinstance(value, Lazy) else value


def _from_text(param: Param, text: str) -> Any:
    """The value of a command line text, by the parameter's type."""
    text = text.strip() if param.type != "string" else text
    if param.type == "boolean":
        known = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
        return known.get(text.casefold(), text)
    if param.type in ("number", "integer", "quantity"):
        if re.fullmatch(r"[+-]?\d+", text) and len(text) < 300:
            return int(text)
        try:
            return float(text)
        except ValueError:
            return text
    if param.type == "array":
        source, problems = parse_source(
            text if text.startswith("[") else f"[{text}]", _NOWHERE, "-p"
        )
        if source is None or problems:
            raise ParamFault("E221", f"{words(text)} is not a list such as 1, 2, 3")
        return source.data
    return text


def convert(param: Param, value: Any) -> Any:
    kinds = {"string": str, "boolean": bool, "integer": int, "number": (int, float), "array": list}
    if param.type == "quantity":
        return _quantity(value, param.unit or "")
    if is_quantity(value):
        raise ParamFault(
            "E221", f"{words(value)} is {kind_of_unit(str(value.units))}, not {a_kind(param.type)}"
        )
    fits = isinstance(value, kinds[param.type])  # type: ignore[arg-type]
    if not fits or (isinstance(value, bool) and param.type != "boolean") or _not_finite(value):
        raise ParamFault("E221", f"{words(value)} is not {a_kind(param.type)}", _hint(param, value))
    if isinstance(value, list):
        return [_item(param, item, index) for index, item in enumerate(value)]
    return value


def _hint(param: Param, value: Any) -> str:
    if param.type == "boolean" and isinstance(value, str):
        return "write true or false, without quotes"
    if param.type == "array":
        return "such as [1, 2, 3]"
    if param.type == "string" and isinstance(value, int | float):
        return 'text that looks like a number needs quotes: "..."'
    return ""


def _not_finite(value: Any) -> bool:
    return isinstance(value, float) and (value != value or value in (float("inf"), float("-inf")))


def a_kind(kind: str) -> str:
    """A type as messages name it."""
    return {"string": "a text", "boolean": "true or false", "integer": "a whole number",
            "number": "a number", "array": "a list", "quantity": "a quantity"}[kind]  # fmt: skip


def _quantity(value: Any, unit: str) -> Any:
    if (
        isinstance(value, bool)
        or value is None
        or isinstance(value, list | dict)
        or _not_finite(value)
    ):
        raise ParamFault("E221", f"{words(value)} is not {kind_of_unit(unit)} ({unit})")
    try:
        return quantity(magnitude_in(value, unit), unit)
    except UnitError as fault:
        raise ParamFault("E221", str(fault)) from fault


def _item(param: Param, value: Any, index: int) -> Any:
    """An item of an array, by the JSON Schema that `items` gives."""
    schema = dict(param.items or {})
    unit = schema.get("unit")
    if unit:
        schema["type"] = "number"
        try:
            value = _quantity(value, unit)
        except ParamFault as fault:
            raise ParamFault(fault.code, str(fault), path=(index,)) from fault
    from jsonschema import SchemaError

    bare = value.magnitude if is_quantity(value) else value
    try:
        check_schema(schema)
        fault = next(iter(validator(schema).iter_errors(bare)), None)
    except SchemaError as wrong:
        raise ParamFault("E224", f"items: {wrong.message}") from wrong
    if fault is not None:
        message = f"item {words(value)} is not {wants(schema)}"
        if str(fault.validator).lower().endswith(("minimum", "maximum")):
            message = f"item {words(value)} is not {bounds_text(schema, None)}"
        raise ParamFault("E221", message, quotes_for_text(value, schema), path=(index,))
    return value


def _check_range(param: Param, value: Any) -> None:
    bare = value.magnitude if is_quantity(value) else value
    for key, beyond in (("minimum", lambda b: bare < b), ("maximum", lambda b: bare > b)):
        bound = getattr(param, key)
        if bound is None or isinstance(bare, str | list | bool):
            continue
        limit = convert(param, bound)
        if beyond(limit.magnitude if is_quantity(limit) else limit):
            raise ParamFault(
                "E222",
                f"{words(value)} is {'below' if key == 'minimum' else 'above'} the {key} {words(limit)}",
            )
    if param.pattern is not None and isinstance(value, str):
        if len(value) > LONGEST_TEXT:
            raise ParamFault("E222", f"a text of {len(value):,} characters is too long")
        if not regular_expression(param.pattern).search(value):
            raise ParamFault("E222", f"{words(value)} does not fit the pattern {param.pattern}")
    if param.enum is not None and not _among(param, value):
        options = [str(item) for item in param.enum]
        raise ParamFault(
            "E222",
            f"{words(value)} is not one of {listed(options)}{did_you_mean(str(value), options)}",
        )


def _among(param: Param, value: Any) -> bool:
    for option in param.enum or []:
        try:
            if convert(param, option) == value:
                return True
        except ParamFault:
            continue
    return False
