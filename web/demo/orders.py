"""Faults that were ordered of a device: a small file that its twin looks at before each action."""

import json
from pathlib import Path
from typing import Any

FILE = "ordered-{}.json"


def order(world: Path, device: str, action: str, error: str | None, count: int) -> None:
    """The next so many goals of an action end with this error."""
    orders = _read(world, device)
    orders.append({"action": action, "error": error, "left": count})
    _write(world, device, orders)


def clear(world: Path, device: str) -> None:
    """Nothing is ordered any more."""
    _write(world, device, [])


def take(world: Path, device: str, action: str) -> dict[str, Any] | None:
    """The order that an action meets now, counted down; None where there is none."""
    orders = _read(world, device)
    for one in orders:
        if one["action"] == action and one["left"] > 0:
            one["left"] -= 1
            _write(world, device, [other for other in orders if other["left"] > 0])
            return one
    return None


def _read(world: Path, device: str) -> list[dict[str, Any]]:
    try:
        return json.loads((world / FILE.format(device)).read_bytes())
    except FileNotFoundError:
        return []


def _write(world: Path, device: str, orders: list[dict[str, Any]]) -> None:
    world.mkdir(parents=True, exist_ok=True)
    half = world / f".{FILE.format(device)}.part"
    half.write_text(json.dumps(orders), encoding="utf-8")
    half.replace(world / FILE.format(device))
