"""The `config` of a gantry in a lab, read and checked at once."""

import math
from collections.abc import Collection
from typing import Any

from ..driver import Misfit, check_keys
from .gantry import AXES
from .keep_out import read_boxes
from .outputs import read_outputs

PLACING = ("origin", "axes", "keep_out", "home_first", "homing_timeout", "safe_z", "outputs")
"""The bench settings of every real gantry."""


def check_config(config: dict[str, Any], known: Collection[str]) -> None:
    """Raise Misfit with the first error."""
    check_keys(known, config)
    _check_axes(config.get("axes"))
    _check_place("origin", config.get("origin"))
    _check_place("home_here", config.get("home_here"))
    read_boxes(config)
    if "safe_z" in config and not _is_number(config["safe_z"]):
        message = f"safe_z is {config['safe_z']!r}; it must be a height on the bench, in mm"
        raise Misfit(message, ("safe_z",))
    read_outputs(config)
    for name in ("boot_s", "homing_timeout", "baud", "silence_s"):
        value = config.get(name, 1)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e9:
            raise Misfit(f"{name} is {value!r}; it must be a number above 0", (name,))
    if not isinstance(config.get("home_first", False), bool):
        message = f"home_first is {config['home_first']!r}; it must be true or false"
        raise Misfit(message, ("home_first",))


def _check_axes(axes: Any) -> None:
    if axes is None:
        return
    used: list[str] = []
    if isinstance(axes, dict):
        check_keys(AXES, axes, "axes")
        used = [str(axes.get(a, a)).lower().removeprefix("-") for a in AXES]
    if sorted(used) != sorted(AXES):
        raise Misfit(
            f"axes is {axes!r}; it must give the machine axis for each bench axis, each "
            f"once, with a minus if it runs the other way: {{x: Y, y: -X}}",
            ("axes",),
        )


def _check_place(name: str, place: Any) -> None:
    if place is None:
        return
    if not isinstance(place, dict) or not all(_is_number(value) for value in place.values()):
        message = f"{name} is {place!r}; write it as {{x: -805, y: -725, z: -90}}, in mm"
        raise Misfit(message, (name,))
    check_keys(AXES, place, name)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
