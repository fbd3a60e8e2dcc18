"""Coordinates of a loop's items, x and y in mm, for a map drawn before it is complete."""

from collections.abc import Mapping, Sequence
from typing import Any

from ...schemas import protocol as p
from ...schemas.quantity import UnitError, is_quantity, magnitude_in
from .outline import Step

NOWHERE = (None, None)


class Items:
    """The items of one loop, as far as known without the run."""

    def __init__(self, step: Step) -> None:
        self.total: int | None = None
        self._items: Sequence[Any] | None = None
        self._places: dict[int, tuple[float | None, float | None]] = {}
        view, loop = step.view, step.step
        if view is None:
            return
        if isinstance(loop, p.Foreach):
            self._items = view.items(loop, step.place)
            self.total = None if self._items is None else len(self._items)
        elif isinstance(loop, p.Repeat):
            self.total = view.number(loop.repeat, (*step.place, "repeat"))

    @property
    def placed(self) -> bool:
        """True if items have an x and a y."""
        return self.total is not None and self.total > 0 and self.place(0) != (None, None)

    def place(self, index: int) -> tuple[float | None, float | None]:
        """The coordinate of one item; None if it has none."""
        if self._items is None or not 0 <= index < len(self._items):
            return NOWHERE
        found = self._places.get(index)
        if found is None:
            item = self._items[index]
            at = item if isinstance(item, Mapping) else {}
            found = self._places[index] = (_mm(at.get("x")), _mm(at.get("y")))
        return found


def _mm(value: Any) -> float | None:
    if value is None or isinstance(value, bool):
        return None
    try:
        if is_quantity(value) or isinstance(value, str):
            return float(magnitude_in(value, "mm"))
        return float(value)
    except (UnitError, TypeError, ValueError):
        return None
