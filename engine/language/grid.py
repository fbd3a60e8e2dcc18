"""Spans and grids: many values computed by arithmetic, never stored as a list."""

from collections.abc import Iterator, Sequence
from typing import Any, overload

from ...schemas.quantity import (
    degree,
    has_offset,
    is_number,
    is_quantity,
    magnitude_in,
    number_text,
    quantity,
    quantity_text,
    unit_of,
)  # fmt: skip

ORDERS = ("rows", "snake", "columns")
FITS = ("exact", "inside")
LONGEST = 1_000_000_000
CLOSE = 1e-6
"""How far a range may be from a whole number of steps, in steps."""


class GridFault(ValueError):
    """An invalid span or grid; the message says why."""


class Lazy(Sequence[Any]):
    """A sequence that knows its length and computes each item on demand."""

    def __len__(self) -> int:
        raise NotImplementedError

    def item(self, index: int) -> Any:
        """The item at an index from 0 to the length minus one."""
        raise NotImplementedError

    @overload
    def __getitem__(self, index: int) -> Any: ...
    @overload
    def __getitem__(self, index: slice) -> list[Any]: ...
    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return [self.item(i) for i in range(*index.indices(len(self)))]
        place = index + len(self) if index < 0 else index
        if not 0 <= place < len(self):
            raise IndexError(f"there is no item {index} of {len(self)}")
        return self.item(place)

    def __iter__(self) -> Iterator[Any]:
        return (self.item(index) for index in range(len(self)))


class Span(Lazy):
    """Numbers or quantities from `start` to `stop`, both included, `step` apart."""

    def __init__(
        self, start: float, stop: float, step: float, count: int, unit: str | None
    ) -> None:
        self.start, self.stop, self.step = start, stop, step
        self.size, self.unit = count, unit

    def __len__(self) -> int:
        return self.size

    def number(self, index: int) -> float:
        """An item without its unit; rounded, so that 0.2 * 3 is 0.6 and the last is `stop`."""
        value = self.start + index * self.step
        return value if isinstance(value, int) else float(f"{value:.12g}")

    def item(self, index: int) -> Any:
        number = self.number(index)
        return number if self.unit is None else quantity(number, self.unit)

    def ends(self) -> list[Any]:
        """The first and the last item."""
        return [self.item(0), self.item(self.size - 1)]


def span(start: Any, stop: Any, step: Any, fit: str = "exact") -> Span:
    """From `start` to `stop`, both included; with `fit="inside"` the last step may fall short."""
    unit = _unit(start, stop, step)
    first, last = _number(start, unit), _number(stop, unit)
    by = _step(step, unit)
    if fit not in FITS:
        raise GridFault(f"span: fit must be 'exact' or 'inside', not {fit!r}")
    if by == 0:
        raise GridFault("span: a step of 0 never reaches the end")
    steps = (last - first) / by
    if steps < -CLOSE:
        raise GridFault(f"span: a step of {_text(by, unit)} leads away from {_text(last, unit)}")
    if steps >= LONGEST:
        raise GridFault(f"span: more than {LONGEST:,} items")
    whole = round(steps)
    if abs(steps - whole) > CLOSE:
        if fit == "exact":
            raise GridFault(_does_not_divide(first, last, by, unit))
        whole = int(steps)
    return Span(first, last, by, whole + 1, unit)


def _does_not_divide(first: float, last: float, step: float, unit: str | None) -> str:
    reached = first + int((last - first) / step) * step
    return (
        f"span: steps of {_text(step, unit)} from {_text(first, unit)} end at "
        f"{_text(reached, unit)}, not at {_text(last, unit)}; "
        "choose a step that divides the range, or use fit='inside'"
    )


def _unit(*values: Any) -> str | None:
    for value in values:
        if not (is_number(value) or is_quantity(value)):
            raise GridFault(f"span: {value!r} is not a number")
    for value in values:
        if is_quantity(value):
            return str(value.units)
    return None


def _number(value: Any, unit: str | None) -> Any:
    if unit is not None and not is_quantity(value) and value != 0:
        raise GridFault(f"span: {number_text(value)} has no unit, but the others do ({unit})")
    try:
        return magnitude_in(value, unit) if unit is not None else value
    except ValueError as fault:
        raise GridFault(f"span: {fault}") from fault


def _step(step: Any, unit: str | None) -> Any:
    """The step in `unit`: one of 10 degC is one of 10 K."""
    if unit is None or not is_quantity(step) or not has_offset(unit):
        return _number(step, unit)
    if step.units == unit_of(unit):
        return step.magnitude
    try:
        return (magnitude_in(step, "K") * unit_of("K")).to(degree(unit)).magnitude
    except ValueError as fault:
        raise GridFault(f"span: {fault}") from fault


def _text(number: float, unit: str | None) -> str:
    return number_text(number) if unit is None else quantity_text(quantity(number, unit))


class Grid(Lazy):
    """The points of a plane in a fixed order; each has `x y ix iy index`."""

    def __init__(self, x: Sequence[Any], y: Sequence[Any], order: str) -> None:
        self.x, self.y, self.order = x, y, order
        self.across, self.down = len(x), len(y)

    def __len__(self) -> int:
        return self.across * self.down

    def columns_of(self, index: int) -> tuple[int, int]:
        """`ix` and `iy` of a point, from its index in the order."""
        if self.order == "columns":
            ix, iy = divmod(index, self.down)
            return ix, iy
        iy, ix = divmod(index, self.across)
        return (self.across - 1 - ix if self.order == "snake" and iy % 2 else ix), iy

    def index_of(self, ix: int, iy: int) -> int:
        """The index of a point in the order, from its `ix` and `iy`."""
        if self.order == "columns":
            return ix * self.down + iy
        return iy * self.across + (self.across - 1 - ix if self.order == "snake" and iy % 2 else ix)

    def item(self, index: int) -> dict[str, Any]:
        ix, iy = self.columns_of(index)
        return {"x": self.x[ix], "y": self.y[iy], "ix": ix, "iy": iy, "index": index}

    def corners(self) -> list[int]:
        """The indexes of the four outermost points, in the order of the grid."""
        return sorted(
            {self.index_of(ix, iy) for ix in (0, self.across - 1) for iy in (0, self.down - 1)}
        )


def grid(x: Any = None, y: Any = None, order: str = "rows") -> Grid:
    """Every point of x times y: by rows, in a snake (every other row backwards), or by columns."""
    if order not in ORDERS:
        raise GridFault(f"grid: order must be 'rows', 'snake' or 'columns', not {order!r}")
    for name, values in (("x", x), ("y", y)):
        if values is None:
            raise GridFault(f"grid: {name} is missing: grid(x=span(...), y=span(...))")
        if isinstance(values, str) or not isinstance(values, Sequence):
            raise GridFault(f"grid: {name} must be a span or a list")
        if len(values) == 0:
            raise GridFault(f"grid: {name} is empty")
    if len(x) * len(y) > LONGEST:
        raise GridFault(f"grid: more than {LONGEST:,} points")
    return Grid(x, y, order)
