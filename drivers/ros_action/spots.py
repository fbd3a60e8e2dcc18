"""Where a value of the contract is in a ROS message, in which unit, and as what.

Written `x`, `target.position.x`, `points[0].positions`, or as a mapping:

{field: target.x, unit: m}                  # ROS uses another unit than the contract
{field: x, optional: true}                  # a list of at most one: the value may be left out
{field: pose.orientation, as: yaw}          # an angle about z here, a quaternion there
{field: points[0].time_from_start, as: duration}   # a time here, {sec, nanosec} there
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...schemas.contract import JsonSchema
from ...schemas.quantity import UnitError, magnitude_in, unit_of
from ..driver import check_keys
from .field_path import FieldPath, get, put, read_path

KEYS = ("field", "unit", "optional", "as")
FORMS = {"yaw": "rad", "duration": "s"}
"""What a value may be there, and the unit in which it is taken."""
NANO = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Spot:
    """One place in a message; `unit` there, `own_unit` in the contract."""

    path: FieldPath
    unit: str | None = None
    own_unit: str | None = None
    optional: bool = False
    form: str | None = None

    def put(self, message: dict[str, Any], value: Any) -> None:
        """Set a contract's value in a message."""
        value = _converted(value, self.own_unit, self.unit)
        if self.form == "yaw":
            value = quaternion_of(value)
        elif self.form == "duration":
            value = duration_of(value)
        put(message, self.path, [value] if self.optional else value)

    def get(self, message: Any) -> Any:
        """A contract's value from a message; None if there is none."""
        value = get(message, self.path)
        if self.optional:
            value = value[0] if value else None
        if self.form is not None and isinstance(value, Mapping):
            value = yaw_of(value) if self.form == "yaw" else seconds_of(value)
        if isinstance(value, float) and not math.isfinite(value):
            return None
        return _converted(value, self.unit, self.own_unit)


def quaternion_of(yaw: float) -> dict[str, float]:
    """geometry_msgs/msg/Quaternion of a turn about z by `yaw` in rad."""
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}


def yaw_of(q: Mapping[str, float]) -> float:
    """The heading of a quaternion, in rad from -pi to pi."""
    x, y, z, w = (float(q.get(name, 0.0)) for name in "xyzw")
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def duration_of(seconds: float) -> dict[str, int]:
    """builtin_interfaces/msg/Duration."""
    sec, nanosec = divmod(round(seconds * NANO), NANO)
    return {"sec": sec, "nanosec": nanosec}


def seconds_of(duration: Mapping[str, Any]) -> float:
    """The seconds of a builtin_interfaces/msg/Duration or Time."""
    return float(duration.get("sec", 0)) + float(duration.get("nanosec", 0)) / NANO


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
    check_keys(KEYS, said, where)
    form = said.get("as")
    if form is not None and form not in FORMS:
        raise ValueError(f"{where}.as: {form!r} is not one of {', '.join(FORMS)}")
    unit, own = said.get("unit"), schema.get("unit") or schema.get("items", {}).get("unit")
    if form is not None:
        if unit is not None:
            raise ValueError(f"{where}: `as: {form}` has a unit of its own, {FORMS[form]}")
        unit = FORMS[form] if own is not None else None
    if unit is not None:
        try:
            unit_of(str(unit))
            magnitude_in(f"1 {unit}", str(own or "dimensionless"))
        except UnitError as fault:
            raise ValueError(f"{where}: {fault}") from fault
    try:
        path = read_path(said["field"])
    except ValueError as fault:
        raise ValueError(f"{where}: {fault}") from fault
    return Spot(path, unit, own, bool(said.get("optional", False)), form)


def _converted(value: Any, unit: str | None, wanted: str | None) -> Any:
    if unit is None or wanted is None or unit == wanted:
        return value
    if isinstance(value, list):
        return [_converted(one, unit, wanted) for one in value]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    return magnitude_in(f"{value!r} {unit}", wanted)
