"""A second zero that a person has chosen, kept on disk for a machine that keeps none itself."""

import json
from pathlib import Path

from ...system.files import write_whole
from .bench import Point


class WorkZero:
    """In machine coordinates; the machine's own zero until one is set. Survives a restart."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / "work_zero.json"
        self._place: dict[int, float] = {}

    def read(self) -> None:
        """Take up what was set before; raises OSError if the file is damaged."""
        if self._path.exists():
            try:
                read = json.loads(self._path.read_bytes())
                self._place = {int(axis): float(value) for axis, value in read.items()}
            except (ValueError, AttributeError, TypeError) as fault:
                raise OSError(
                    f"{self._path} does not hold a work zero ({fault}); remove it, and set the zero again"
                ) from fault

    def set(self, axes: list[int], machine: Point) -> None:
        """Make this position the zero of these machine axes."""
        self._place |= {axis: machine[axis] for axis in axes}
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._path, json.dumps(self._place).encode())

    def place(self, axes: int) -> Point:
        """The zero, in machine coordinates."""
        return tuple(self._place.get(axis, 0.0) for axis in range(axes))
