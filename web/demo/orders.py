"""Faults requested of a device: a small file that its twin reads before each action.

One that has an action counts down; the others last until they are cleared: `interlock`, `stop`, `slow`.
"""

import json
from pathlib import Path
from typing import Any

from ...system.files import write_whole

FILE = "ordered-{}.json"


def order(
    world: Path, device: str, kind: str, action: str | None = None, error: str | None = None, count: int = 1
) -> None:  # fmt: skip
    """The next `count` goals of an action end with this error; or, without one, `kind` lasts."""
    orders = [one for one in ordered(world, device) if action is not None or one["kind"] != kind]
    orders.append({"kind": kind, "action": action, "error": error, "left": count})
    _write(world, device, orders)


def clear(world: Path, device: str) -> None:
    """Drop all requested faults."""
    _write(world, device, [])


def take(world: Path, device: str, action: str) -> dict[str, Any] | None:
    """The fault for an action now, counted down; None if there is none."""
    orders = ordered(world, device)
    for one in orders:
        if one["action"] == action and one["left"] > 0:
            one["left"] -= 1
            _write(world, device, [other for other in orders if other["left"] > 0])
            return one
    return None


def lasts(world: Path, device: str, kind: str) -> bool:
    """Whether this fault was requested and not cleared since."""
    return any(one["kind"] == kind for one in ordered(world, device))


def ordered(world: Path, device: str) -> list[dict[str, Any]]:
    """Every fault of a device that is still to come or lasts."""
    try:
        return json.loads((world / FILE.format(device)).read_bytes())
    except FileNotFoundError:
        return []


def _write(world: Path, device: str, orders: list[dict[str, Any]]) -> None:
    write_whole(world / FILE.format(device), json.dumps(orders).encode(), sync=False)
