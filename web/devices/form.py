"""A contract as forms: each action with the limits of this bench, its level, and what can be jogged."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from ...schemas.contract import Action, Contract
from ...schemas.lab import Limit
from ...schemas.quantity import UnitError, magnitude_in, same_dimension, seconds
from ..models.devices import ActionForm, Axis

AXES: tuple[Axis, ...] = ("x", "y", "z")


def action_form(name: str, action: Action, limits: Mapping[str, Limit]) -> ActionForm:
    """One action; minimum and maximum are those of this bench where they are narrower."""
    return ActionForm(
        name=name, summary=action.summary, params=narrowed(action, limits), returns=action.returns,
        errors={error: said.summary for error, said in action.errors.items()},
        effect=action.effect, danger=action.danger, level=level_of(action), cancel=action.cancel,
        duration_s=None if action.duration is None else seconds(action.duration),
        interlock=action.interlock,
    )  # fmt: skip


def level_of(action: Action) -> Literal[0, 1, 2, 3]:
    """0 reads, 1 is reversible, 2 moves, 3 is a hazard."""
    if action.danger == "motion":
        return 2
    if action.danger is not None:
        return 3
    return 0 if action.effect == "pure" else 1


def narrowed(action: Action, limits: Mapping[str, Limit]) -> dict[str, Any]:
    """The JSON Schema of an action's parameters within the limits of this bench."""
    schema = copy.deepcopy(action.params)
    for name, param in schema.get("properties", {}).items():
        limit = limits.get(name)
        if limit is None:
            continue
        unit = param.get("unit", "")
        if limit.minimum is not None:
            edge = magnitude_in(limit.minimum, unit)
            param["minimum"] = max(edge, param.get("minimum", edge))
        if limit.maximum is not None:
            edge = magnitude_in(limit.maximum, unit)
            param["maximum"] = min(edge, param.get("maximum", edge))
    return schema


@dataclass(frozen=True, slots=True)
class Moving:
    """The action by which a device is jogged, and how far each axis goes, in mm."""

    action: str
    ranges_mm: dict[Axis, tuple[float, float]]
    feed_unit: str | None
    most_feed: float | None


def moving_of(contract: Contract, limits: Mapping[str, Limit]) -> Moving | None:
    """What a device is jogged with; None for one that cannot be.

    The action takes lengths x, y or z with both ends known, moves, and can be cancelled.
    """
    for name, action in contract.actions.items():
        if action.danger != "motion" or not action.cancel:
            continue
        properties = narrowed(action, limits).get("properties", {})
        ranges: dict[Axis, tuple[float, float]] = {}
        for axis in AXES:
            edges = _range_mm(properties.get(axis))
            if edges is not None:
                ranges[axis] = edges
        if ranges:
            feed = properties.get("feed", {})
            return Moving(name, ranges, feed.get("unit"), feed.get("maximum"))
    return None


def _range_mm(schema: dict[str, Any] | None) -> tuple[float, float] | None:
    if schema is None or "minimum" not in schema or "maximum" not in schema:
        return None
    unit = schema.get("unit")
    try:
        if unit is None or not same_dimension(unit, "mm"):
            return None
        low, high = (magnitude_in(f"{schema[end]} {unit}", "mm") for end in ("minimum", "maximum"))
    except UnitError:
        return None
    return low, high
