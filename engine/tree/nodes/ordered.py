"""`foreach` with `order: shortest`: the items in the order that is known to take the least time."""

from collections import ChainMap
from collections.abc import Callable, Mapping
from typing import Any

from ...language.value import Value
from ...run.shortest import FEW, LEGS, Leg, shortest
from .iterations import ItemIterations, whole


class OrderedIterations(ItemIterations):
    """Each item keeps the key that it has as listed; `legs` says what an iteration will do."""

    def __init__(
        self, name: str, items: Value, key: Value | None, at_once: Value,
        legs: Callable[[Mapping[str, Any]], list[Leg]],
    ) -> None:  # fmt: skip
        super().__init__(name, items, key)
        self.at_once_value, self.legs = at_once, legs
        self.at_once = 1
        self.names: ChainMap[str, Any] = ChainMap()
        self.order: list[int] = []
        """The item of each turn, as far as any has been asked for."""

    def begin(self, names: Any) -> None:
        self.at_once = max(1, whole("at_once", self.at_once_value.evaluate(names)))
        self.names, self.order = names, []
        super().begin(names)

    def own(self, index: int) -> dict[str, Any]:
        return super().own(self._item(index))

    def words(self, index: int) -> str:
        return super().words(self._item(index))

    def key(self, index: int, names: Any) -> str:
        return super().key(self._item(index), names)

    def _key_at(self, index: int, names: Any) -> str:
        return super().key(index, names.new_child(super().own(index)))

    def _item(self, index: int) -> int:
        while index >= len(self.order):
            self._put_in_order()
        return self.order[index]

    def _put_in_order(self) -> None:
        """The next few; fewer, where each of them has many legs."""
        first, jobs, legs = len(self.order), list[list[Leg]](), 0
        while len(jobs) < FEW and legs < LEGS and first + len(jobs) < len(self.items):
            item = self.items[first + len(jobs)]
            jobs.append(self.legs(self.names.new_child({self.name: item})))
            legs += len(jobs[-1])
        self.order += [first + n for n in shortest(jobs, self.at_once)]
