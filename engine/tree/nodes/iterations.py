"""What a loop iterates over: the items of a list, a number of turns, or turns while a condition holds."""

from array import array
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

from ....schemas.quantity import is_quantity
from ...language.operators import words
from ...language.value import Value
from ...run.frame import segment

PARTS = 64
PLACES = ("ix", "iy", "index")
"""Fields of an item that only number it."""
TOLD = 4
LONG = 40


class NotOver(ValueError):
    """A condition that still holds when all turns are used up."""


class Iterations(Protocol):
    """The turns of a loop; every call gets the names that the loop can see."""

    total: int | None
    """How many there are; None if that is not known in advance."""
    endless: bool
    """True if nothing but their condition limits them."""

    def begin(self, names: Any) -> None:
        """Compute what can be computed when the loop is entered; raises ExpressionError, ValueError."""
        ...

    def more(self, index: int, names: Any) -> bool:
        """Whether there is a turn of this number."""
        ...

    def own(self, index: int) -> dict[str, Any]:
        """The names of this turn alone."""
        ...

    def words(self, index: int) -> str:
        """The turn as people name it: `point 10 of 35 (x = 4 mm, y = 0.2 mm)`."""
        ...

    def key(self, index: int, names: Any) -> str:
        """The permanent key of the turn; `names` include its own."""
        ...


class ItemIterations:
    """`foreach`: one turn per item."""

    endless = False

    def __init__(self, name: str, items: Value, key: Value | None) -> None:
        self.name, self.items_value, self.key_value = name, items, key
        self.items: Sequence[Any] = ()
        self.total: int | None = None

    def begin(self, names: Any) -> None:
        items = self.items_value.evaluate(names)
        if items is None or isinstance(items, str | Mapping) or not hasattr(items, "__getitem__"):
            raise ValueError(f"foreach needs a list, a span or a grid, not {words(items)}")
        self.items, self.total = items, len(items)
        self._refuse_doubles(names)

    def more(self, index: int, names: Any) -> bool:
        return index < len(self.items)

    def own(self, index: int) -> dict[str, Any]:
        return {self.name: self.items[index]}

    def words(self, index: int) -> str:
        item = self.items[index]
        noun = self.name if len(self.name) > 1 else "point"
        fields = item if isinstance(item, Mapping) else {self.name: item}
        told = [
            f"{name} = {_brief(value)}" if name != noun else _brief(value)
            for name, value in fields.items()
            if name not in PLACES and (is_quantity(value) or isinstance(value, int | float | str))
        ]
        values = f" ({', '.join(told[:TOLD])})" if told else ""
        return f"{noun} {index + 1:,} of {self.total:,}{values}"

    def key(self, index: int, names: Any) -> str:
        return (
            str(index) if self.key_value is None else segment(str(self.key_value.evaluate(names)))
        )

    def _refuse_doubles(self, names: Any) -> None:
        """Duplicate keys would merge two points: refused before anything is sent."""
        if self.key_value is None:
            return
        keys = (self._key_at(index, names) for index in range(len(self.items)))
        if not _may_repeat(hash(key) for key in keys):
            return
        first: dict[str, int] = {}
        for index in range(len(self.items)):
            key = self._key_at(index, names)
            if key in first:
                raise ValueError(f"key {key!r} occurs twice, at items {first[key]} and {index}")
            first[key] = index

    def _key_at(self, index: int, names: Any) -> str:
        return self.key(index, names.new_child(self.own(index)))


class CountedIterations:
    """`repeat`: a number of turns."""

    endless = False

    def __init__(self, count: Value) -> None:
        self.count = count
        self.total: int | None = None

    def begin(self, names: Any) -> None:
        self.total = whole("repeat", self.count.evaluate(names))

    def more(self, index: int, names: Any) -> bool:
        return index < (self.total or 0)

    def own(self, index: int) -> dict[str, Any]:
        return {}

    def words(self, index: int) -> str:
        return f"turn {index + 1:,}" + (f" of {self.total:,}" if self.total else "")

    def key(self, index: int, names: Any) -> str:
        return str(index)


class ConditionalIterations:
    """`while`: turns as long as a condition holds, `max` at most."""

    def __init__(self, condition: Value, most: Value | None) -> None:
        self.condition, self.most_value = condition, most
        self.endless = most is None
        self.most: int | None = None
        self.total: int | None = None

    def begin(self, names: Any) -> None:
        self.most = (
            None if self.most_value is None else whole("max", self.most_value.evaluate(names))
        )

    def more(self, index: int, names: Any) -> bool:
        if not self.condition.evaluate(names):
            return False
        if self.most is not None and index >= self.most:
            turns = "1 turn" if self.most == 1 else f"{self.most} turns"
            raise NotOver(f"the condition of `while` still holds after {turns} (max)")
        return True

    def own(self, index: int) -> dict[str, Any]:
        return {}

    def words(self, index: int) -> str:
        return f"turn {index + 1:,}"

    def key(self, index: int, names: Any) -> str:
        return str(index)


def whole(what: str, value: Any) -> int:
    """A number of turns; raises ValueError for anything else."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if type(value) is not int or value < 0:
        raise ValueError(f"{what} needs a whole number, 0 or more, not {value!r}")
    return value


def _brief(value: Any) -> str:
    """A value of a point, in no more characters than a person reads at once."""
    if not isinstance(value, str):
        return words(value)
    text = " ".join(value.split())
    return text if len(text) <= LONG else f"{text[: LONG - 3]}..."


def _may_repeat(hashes: Iterator[int]) -> bool:
    """Whether a number occurs twice, in little more than eight bytes each even for a million of them."""
    seen = [array("q") for _ in range(PARTS)]
    for number in hashes:
        seen[number % PARTS].append(number)
    return any(len(set(part)) < len(part) for part in seen)
