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
    return ActionForm.of(
        action, name=name, params=narrowed(action, limits), level=level_of(action),
        errors={error: said.summary for error, said in action.errors.items()},
        duration_s=None if action.duration is None else seconds(action.duration),
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
    axes: tuple[Axis, ...]
    ranges_mm: dict[Axis, tuple[float, float]]
    feed_unit: str | None
    most_feed: float | None


def moving_of(contract: Contract, limits: Mapping[str, Limit]) -> Moving | None:
    """What a device is jogged with; None for one that cannot be.

    The action takes lengths x, y or z, moves, and can be cancelled. An end of an axis that neither
    contract nor lab knows is the device's own affair: it needs a `jog`, which keeps to it.
    """
    jog = contract.actions.get("jog")
    own = jog.params.get("properties", {}).get("axis", {}).get("enum", []) if jog else []
    for name, action in contract.actions.items():
        if action.danger != "motion" or not action.cancel:
            continue
        properties = narrowed(action, limits).get("properties", {})
        lengths: dict[Axis, Any] = {a: properties[a] for a in AXES if _is_length(properties.get(a))}
        ranges: dict[Axis, tuple[float, float]] = {}
        ranges |= {axis: found for axis, one in lengths.items() if (found := _range_mm(one))}
        axes: tuple[Axis, ...] = tuple(
            a for a in AXES if a in lengths and (a in ranges or a in own)
        )
        if axes:
            feed = properties.get("feed", {})
            return Moving(name, axes, ranges, feed.get("unit"), feed.get("maximum"))
    return None


def _is_length(schema: dict[str, Any] | None) -> bool:
    try:
        return schema is not None and same_dimension(schema.get("unit") or "1", "mm")
    except UnitError:
        return False


def _range_mm(schema: dict[str, Any]) -> tuple[float, float] | None:
    if "minimum" not in schema or "maximum" not in schema:
        return None
    low, high = (
        magnitude_in(f"{schema[end]} {schema['unit']}", "mm") for end in ("minimum", "maximum")
    )
    return low, high
