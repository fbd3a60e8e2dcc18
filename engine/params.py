"""The parameters of a protocol: what was asked for by `-p`, or the default, in the declared unit."""

import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..schemas.problem import Problem, Severity
from ..schemas.protocol import Param
from ..schemas.quantity import UnitError, is_quantity, kind_of_unit, magnitude_in, quantity, unit_of
from .language.operators import words
from .language.source import Source, parse_source
from .language.suggest import did_you_mean, listed
from .language.wanted import wants

CODES = {
    "E220": "a parameter that the protocol does not have",
    "E221": "a value of the wrong type or unit for a parameter",
    "E222": "a value outside a parameter's range, pattern or choices",
    "E223": "a parameter without a value",
    "E224": "a declaration of a parameter that contradicts itself",
    "W223": "a parameter that needs a value when the protocol runs",
}
LONGEST_TEXT = 10_000
_NOWHERE = Path("-p")


class ParamFault(ValueError):
    """A value that a parameter does not take; the text says why."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


def read_params(
    declared: Mapping[str, Param], given: Mapping[str, Any], source: Source, *, needed: bool = True
) -> tuple[dict[str, Any], list[Problem]]:
    """The values of all parameters that have one, and what is wrong with them."""
    problems = list(_unknown(declared, given, source))
    values: dict[str, Any] = {}
    for name, param in declared.items():
        faults = list(_declaration(name, param, source))
        problems += faults
        if faults:
            continue
        try:
            if name in given:
                values[name] = take(name, param, given[name])
            elif param.default is not None:
                values[name] = take(name, param, param.default, written=True)
            else:
                problems.append(_missing(name, param, source, needed))
        except ParamFault as fault:
            problems.append(_refused(name, fault, source, by_option=name in given))
    return values, problems


def _unknown(
    declared: Mapping[str, Param], given: Mapping[str, Any], source: Source
) -> Iterator[Problem]:
    known = {*declared, *source.names("params")}
    for name in given:
        if name not in known:
            message = f"the protocol has no parameter {name}{did_you_mean(name, declared)}"
            hint = f"it has {listed(declared)}"
            yield Problem(file="-p", line=1, column=1, code="E220", message=message, hint=hint)


def _missing(name: str, param: Param, source: Source, needed: bool) -> Problem:
    severity: Severity = "error" if needed else "warning"
    example = {"quantity": f'"1 {param.unit}"', "string": "TEXT", "boolean": "true"}.get(
        param.type, "1"
    )
    return source.problem(
        ("params", name), "E223" if needed else "W223", f"the parameter {name} has no value",
        f"give it one: -p {name}={example}, or a `default:`", key=True, severity=severity,
    )  # fmt: skip


def _refused(name: str, fault: ParamFault, source: Source, *, by_option: bool) -> Problem:
    if by_option:
        return Problem(file="-p", line=1, column=1, code=fault.code, message=f"{name}: {fault}")
    return source.problem(("params", name, "default"), fault.code, f"{name}: {fault}")


# --- the declaration itself


def _declaration(name: str, param: Param, source: Source) -> Iterator[Problem]:
    def wrong(key: str, message: str, hint: str = "") -> Problem:
        return source.problem(("params", name, key), "E224", f"{name}: {message}", hint)

    if param.type == "quantity" and param.unit is None:
        yield source.problem(
            ("params", name),
            "E224",
            f"{name}: a quantity needs its unit",
            "add `unit: mm`",
            key=True,
        )
        return
    if param.type != "quantity" and param.unit is not None:
        yield wrong("unit", f"a {param.type} has no unit", "write `type: quantity`")
        return
    if param.unit is not None:
        try:
            unit_of(param.unit)
        except UnitError as fault:
            yield wrong("unit", str(fault))
            return
    if param.pattern is not None:
        try:
            _expression(param.pattern)
        except (re.error, RecursionError, OverflowError) as fault:
            yield wrong("pattern", f"{param.pattern!r} is not a regular expression: {fault}")
    for key in ("minimum", "maximum"):
        bound = getattr(param, key)
        if bound is not None:
            try:
                _convert(param, bound)
            except ParamFault as fault:
                yield wrong(key, str(fault))


# --- one value


def take(name: str, param: Param, given: Any, *, written: bool = False) -> Any:
    """A value as the protocol computes with it; raises ParamFault.

    `written`: it stands in the protocol, where types are those of YAML; else it is text.
    """
    value = given if written or not isinstance(given, str) else _from_text(param, given)
    value = _convert(param, value)
    _check_range(param, value)
    return value


def _from_text(param: Param, text: str) -> Any:
    """What a text of the command line is, by the parameter's type."""
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


def _convert(param: Param, value: Any) -> Any:
    kinds = {"string": str, "boolean": bool, "integer": int, "number": (int, float), "array": list}
    if param.type == "quantity":
        return _quantity(value, param.unit or "")
    if is_quantity(value):
        raise ParamFault(
            "E221", f"{words(value)} is {kind_of_unit(str(value.units))}; a {param.type} is wanted"
        )
    fits = isinstance(value, kinds[param.type])  # type: ignore[arg-type]
    if not fits or (isinstance(value, bool) and param.type != "boolean") or _not_finite(value):
        raise ParamFault("E221", f"{words(value)} is not {_a(param.type)}")
    return [_item(param, item) for item in value] if isinstance(value, list) else value


def _not_finite(value: Any) -> bool:
    return isinstance(value, float) and (value != value or value in (float("inf"), float("-inf")))


def _a(kind: str) -> str:
    return {"string": "a text", "boolean": "true or false", "integer": "a whole number",
            "number": "a number", "array": "a list"}[kind]  # fmt: skip


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


def _item(param: Param, value: Any) -> Any:
    """An item of an array, by the JSON Schema that `items` gives."""
    schema = dict(param.items or {})
    unit = schema.get("unit")
    if unit:
        schema["type"] = "number"
        value = _quantity(value, unit)
    from jsonschema import Draft202012Validator, SchemaError

    bare = value.magnitude if is_quantity(value) else value
    try:
        Draft202012Validator.check_schema(schema)
        fault = next(iter(Draft202012Validator(schema).iter_errors(bare)), None)
    except SchemaError as wrong:
        raise ParamFault("E224", f"items: {wrong.message}") from wrong
    if fault is not None:
        raise ParamFault("E221", f"item {words(value)} is not {wants(schema)}")
    return value


def _check_range(param: Param, value: Any) -> None:
    bare = value.magnitude if is_quantity(value) else value
    for key, beyond in (("minimum", lambda b: bare < b), ("maximum", lambda b: bare > b)):
        bound = getattr(param, key)
        if bound is None or isinstance(bare, str | list | bool):
            continue
        limit = _convert(param, bound)
        if beyond(limit.magnitude if is_quantity(limit) else limit):
            raise ParamFault(
                "E222",
                f"{words(value)} is {'below' if key == 'minimum' else 'above'} the {key} {words(limit)}",
            )
    if param.pattern is not None and isinstance(value, str) and not _matches(param.pattern, value):
        raise ParamFault("E222", f"{words(value)} does not fit the pattern {param.pattern}")
    if param.enum is not None and not _among(param, value):
        options = [str(item) for item in param.enum]
        raise ParamFault(
            "E222",
            f"{words(value)} is none of {listed(options)}{did_you_mean(str(value), options)}",
        )


def _matches(pattern: str, value: str) -> bool:
    if len(value) > LONGEST_TEXT:
        raise ParamFault("E222", f"a text of {len(value):,} characters is too long")
    return _expression(pattern).search(value) is not None


def _expression(pattern: str) -> re.Pattern[str]:
    with warnings.catch_warnings():
        # Python thinks aloud about what `[[` may mean some day; that is no matter of the protocol.
        warnings.simplefilter("ignore", FutureWarning)
        return re.compile(pattern)


def _among(param: Param, value: Any) -> bool:
    for option in param.enum or []:
        try:
            if _convert(param, option) == value:
                return True
        except ParamFault:
            continue
    return False
