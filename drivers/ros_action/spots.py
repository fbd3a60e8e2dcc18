"""Where a value of the contract is in a ROS message, and in which unit.

Written `x`, `target.position.x`, or `{field: target.x, unit: m}` if ROS uses another unit than the
contract; `{field: x, optional: true}` if a list of at most one represents a value that may be left
out.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...schemas.contract import JsonSchema
from ...schemas.quantity import UnitError, magnitude_in, unit_of

KEYS = ("field", "unit", "optional")


@dataclass(frozen=True, slots=True)
class Spot:
    """One place in a message; `unit` there, `own_unit` in the contract."""

    path: tuple[str, ...]
    unit: str | None = None
    own_unit: str | None = None
    optional: bool = False

    def put(self, message: dict[str, Any], value: Any) -> None:
        """Set a contract's value in a message."""
        for name in self.path[:-1]:
            message = message.setdefault(name, {})
        value = self._converted(value, self.own_unit, self.unit)
        message[self.path[-1]] = [value] if self.optional else value

    def get(self, message: Any) -> Any:
        """A contract's value from a message; None if there is none."""
        for name in self.path:
            if not isinstance(message, Mapping) or name not in message:
                return None
            message = message[name]
        if self.optional:
            message = message[0] if message else None
        if isinstance(message, float) and not math.isfinite(message):
            return None
        return self._converted(message, self.unit, self.own_unit)

    def _converted(self, value: Any, unit: str | None, wanted: str | None) -> Any:
        if unit is None or wanted is None or unit == wanted or not _is_number(value):
            return value
        return magnitude_in(f"{value!r} {unit}", wanted)


def read_spots(written: Any, schemas: Mapping[str, JsonSchema], where: str) -> dict[str, Spot]:
    """Contract name -> its field; the default is the same name. Raises ValueError."""
    given = {} if written is None else written
    if not isinstance(given, dict):
        raise ValueError(f"{where} must be written as `{{name: field}}`")
    strange = [name for name in given if name not in schemas]
    if strange:
        raise ValueError(f"{where}: {strange[0]} is not one of {', '.join(schemas) or 'nothing'}")
    return {
        name: _read(given.get(name, name), schema, f"{where}.{name}")
        for name, schema in schemas.items()
    }


def _read(written: Any, schema: JsonSchema, where: str) -> Spot:
    said = {"field": written} if isinstance(written, str) else written
    if not isinstance(said, dict) or not isinstance(said.get("field"), str) or not said["field"]:
        raise ValueError(f"{where}: write a field's name, or {{field: NAME, unit: UNIT}}")
    strange = [key for key in said if key not in KEYS]
    if strange:
        raise ValueError(f"{where}: unknown key {strange[0]!r}; the keys are {', '.join(KEYS)}")
    unit, own = said.get("unit"), schema.get("unit")
    if unit is not None:
        try:
            unit_of(str(unit))
            magnitude_in(f"1 {unit}", str(own or "dimensionless"))
        except UnitError as fault:
            raise ValueError(f"{where}: {fault}") from fault
    return Spot(tuple(said["field"].split(".")), unit, own, bool(said.get("optional", False)))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
