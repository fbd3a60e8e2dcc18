"""Check a goal's parameters, and a driver's answer, against the contract and this bench's limits."""

import math
from hashlib import sha256
from pathlib import PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any

from ...schemas.contract import Action, Contract, JsonSchema
from ...schemas.messages import FileContent, Goal
from ...schemas.patterns import Validator, validator

if TYPE_CHECKING:
    from jsonschema.exceptions import ValidationError

LONGEST_BITS = 10_000
"""Of a whole number; Python writes one of 14,000 no more."""

Limits = dict[str, tuple[float | None, float | None]]


class LimitFault(ValueError):
    """A lab's limits that cannot be understood, with the reason."""


def read_limits(written: dict[str, Any], contract: Contract) -> Limits:
    """Limits as (minimum, maximum) in the contract's units; each `{minimum, maximum}` or a pair."""
    limits: Limits = {}
    for name, limit in written.items():
        units = {
            action.param_schemas()[name].get("unit")
            for action in contract.actions.values()
            if name in action.param_schemas()
        }
        if not units:
            raise LimitFault(f"limit {name}: no action of {contract.type} has such a parameter")
        unit = next(iter(units))
        low, high = (
            (limit.get("minimum"), limit.get("maximum")) if isinstance(limit, dict) else limit
        )
        limits[name] = (_number(name, low, unit), _number(name, high, unit))
    return limits


def _number(name: str, value: Any, unit: str | None) -> float | None:
    if isinstance(value, str):
        from ...schemas.quantity import UnitError, magnitude_in

        try:
            return magnitude_in(value, unit or "dimensionless")
        except UnitError as fault:
            raise LimitFault(f"limit {name}: {fault}") from fault
    if value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    raise LimitFault(f"limit {name}: {value!r} is not a number")


def narrowed(schema: JsonSchema, limits: Limits) -> JsonSchema:
    """The schema of an action's parameters with this bench's ranges."""
    properties = dict(schema.get("properties", {}))
    for name, (low, high) in limits.items():
        if name not in properties:
            continue
        one = dict(properties[name])
        if low is not None:
            one["minimum"] = max(low, one.get("minimum", low))
        if high is not None:
            one["maximum"] = min(high, one.get("maximum", high))
        properties[name] = one
    return {"type": "object", **schema, "properties": properties}


class Arguments:
    """The rules for one action's input and output."""

    def __init__(self, place: str, action: Action, limits: Limits) -> None:
        self.place = place
        self.params = validator(_closed(narrowed(action.params, limits)))
        self.returns = validator({"type": "object", **action.returns})
        self.read, self.written = action.path_params()
        self.returned = action.returned_paths()

    def fault_in(self, goal: Goal) -> str | None:
        """The first error in a goal's parameters and files, as a message."""
        fault = _first(self.params, goal.params)
        if fault is not None:
            return _sentence(self.place, fault)
        odd = odd_value(goal.params, self.place)  # neither a minimum nor a maximum refuses NaN
        if odd is not None:
            return odd
        for name in (*self.read, *self.written):
            value = goal.params.get(name)
            if value is not None and not _inside(value):
                return f"{self.place}.{name}: {value!r} is outside the run's folder; give a path inside it"
        for name in self.read:
            if goal.params.get(name) is not None and name not in goal.files:
                return f"{self.place}.{name}: the file {goal.params[name]} was not sent along"
        for name, file in goal.files.items():
            if sha256(file.data).hexdigest() != file.sha256:
                return f"{self.place}.{name}: {file.path} was damaged in transfer (sha256 differs)"
        return None

    def fault_out(self, result: Any, files: dict[str, FileContent]) -> str | None:
        """The first error in a driver's answer, as a message."""
        fault = _first(self.returns, result) if isinstance(result, dict) else None
        if not isinstance(result, dict):
            return f"{self.place} answered {type(result).__name__}, the contract requires an object"
        if fault is not None:
            return f"the answer of {_sentence(self.place, fault)}"
        for name in self.returned:
            if result.get(name) is not None and not isinstance(files.get(name), FileContent):
                return (
                    f"the answer of {self.place}.{name}: the file {result[name]} was not sent along"
                )
        odd = odd_value(result, self.place)
        return None if odd is None else f"the answer of {odd}"


def _closed(schema: JsonSchema) -> JsonSchema:
    """An action without parameters takes none; any other schema says itself whether it is open."""
    return schema if schema["properties"] else {**schema, "additionalProperties": False}


def _first(validator: Validator, value: Any) -> "ValidationError | None":
    # is_valid stops at the first error and builds no messages: this is the path of nearly all goals.
    if validator.is_valid(value):
        return None
    # Only here: beside Jupyter its import builds a grammar, for seconds in which no stop is heard.
    from jsonschema.exceptions import best_match

    return best_match(validator.iter_errors(value))


def _sentence(place: str, fault: "ValidationError") -> str:
    where = ".".join([place, *(str(part) for part in fault.absolute_path)])
    schema: Any = fault.schema
    unit = f" {schema['unit']}" if isinstance(schema, dict) and schema.get("unit") else ""
    value = fault.instance
    match fault.validator:
        case "minimum" | "exclusiveMinimum":
            return f"{where}: {value:g}{unit} is below the minimum, {fault.validator_value:g}{unit}"
        case "maximum" | "exclusiveMaximum":
            return f"{where}: {value:g}{unit} is above the maximum, {fault.validator_value:g}{unit}"
        case _:
            return f"{where}: {fault.message}"


def _inside(path: Any) -> bool:
    """True for a path that stays inside the folder it is relative to, on any system."""
    if not isinstance(path, str) or not path:
        return False
    windows, posix = PureWindowsPath(path), PurePosixPath(path)
    return not (windows.drive or windows.root or posix.is_absolute() or ".." in windows.parts)


def odd_value(value: Any, place: str) -> str | None:
    """The place in an answer of a value that JSON cannot represent (NaN, a numpy number, bytes)."""
    match value:
        case None | bool():
            return None
        case str():
            return None if _is_text(value) else f"{place}: {value!r:.80} is not Unicode text"
        case int():
            return None if value.bit_length() <= LONGEST_BITS else f"{place}: too many digits"
        case float():
            return (
                None
                if math.isfinite(value)
                else f"{place}: {value} is not a number that JSON can represent"
            )
        case dict():
            key = next((k for k in value if not isinstance(k, str) or not _is_text(k)), None)
            if key is not None:
                return f"{place}: {key!r:.80} cannot be a name in JSON"
            children = [(f"{place}.{name}", child) for name, child in value.items()]
        case list() | tuple():
            children = [(f"{place}.{index}", child) for index, child in enumerate(value)]
        case _:
            return f"{place}: a {type(value).__name__} is not a JSON type"
    return next(
        (odd for name, child in children if (odd := odd_value(child, name)) is not None), None
    )


def _is_text(text: str) -> bool:
    """False for half a character, as `os.fsdecode` makes of a file's name in another encoding."""
    return text.isascii() or not any("\ud800" <= c <= "\udfff" for c in text)
