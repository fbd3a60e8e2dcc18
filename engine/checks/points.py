"""Find where a number leaves its range in a long loop; not a check, but a helper of `arguments`.

Only some items of a long loop are tried one by one. Here an expression is computed over all of
them with numpy. What this cannot compute (text, results) is left alone.
"""

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...schemas.quantity import UnitError, is_quantity, magnitude_in, unit_of
from ..language.fold import MOST_ITEMS, Case, Folding, is_linear, name_item
from ..language.functions import LITERAL
from ..language.grid import Grid, Span
from ..language.value import Computed

MOST_POINTS = 5_000_000
FIELDS = ("x", "y", "ix", "iy", "index")


class NotHere(Exception):
    """Something that is not computed here."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """Numbers of one unit, along one axis for each loop; no unit for plain numbers."""

    values: Any
    unit: str | None = None

    def in_unit(self, unit: str | None) -> Any:
        """The numbers in another unit; a bare 0 fits any."""
        if self.unit == unit or unit is None:
            return self.values
        if self.unit is None:
            return self.values
        try:
            return self.values * magnitude_in(_one(self.unit), unit)
        except UnitError as fault:
            raise NotHere from fault


def _one(unit: str) -> Any:
    from ...schemas.quantity import quantity

    return quantity(1.0, unit)


def is_long(value: Computed, loops: Sequence[str], folding: Folding) -> bool:
    """True where trying some of the items is not enough to decide for all of them."""
    lists = [folding.loops[name] or () for name in loops]
    count = 1
    for items in lists:
        count *= len(items)
    even = all(_is_even(items) for items in lists)
    straight = even and is_linear(value.expression.tree.body, set(loops))
    return MOST_ITEMS < count <= MOST_POINTS and not straight


def _is_even(items: Sequence[Any]) -> bool:
    if isinstance(items, Grid):
        return all(isinstance(axis, Span | range) for axis in (items.x, items.y))
    return isinstance(items, Span | range)


def first_outside(
    value: Computed, loops: Sequence[str], folding: Folding, unit: str | None,
    low: float | None, high: float | None,
) -> Case | None:  # fmt: skip
    """The first combination of items that gives a number outside its bounds."""
    import numpy as np

    try:
        with np.errstate(all="ignore"):
            found = Walk(loops, folding).of(value.expression.tree.body).in_unit(unit)
            lists = [folding.loops[name] or () for name in loops]
            shape = tuple(len(items) for items in lists)
            found = np.broadcast_to(np.asarray(found, dtype=float), shape)
    except (NotHere, ValueError, TypeError, OverflowError):
        return None
    outside = np.zeros(shape, dtype=bool)
    if low is not None:
        outside |= found < low
    if high is not None:
        outside |= found > high
    if not outside.any():
        return None
    picked = np.unravel_index(int(outside.argmax()), shape)
    names: dict[str, Any] = {**folding.names, "params": folding.params}
    where = []
    for name, items, index in zip(loops, lists, picked, strict=True):
        names[name] = items[int(index)]
        where.append(name_item(name, items, int(index), names[name]))
    return Case(names, ", ".join(where))


class Walk:
    """One walk over one expression; raises NotHere at anything it cannot compute."""

    def __init__(self, loops: Sequence[str], folding: Folding) -> None:
        self.loops, self.folding = list(loops), folding

    def of(self, node: ast.AST) -> Numbers:
        """The numbers of a part."""
        found = getattr(self, f"_{type(node).__name__.lower()}", None)
        if found is None:
            raise NotHere
        return found(node)

    def _constant(self, node: ast.Constant) -> Numbers:
        return _number(node.value)

    def _name(self, node: ast.Name) -> Numbers:
        if node.id in self.loops:
            return self._along(node.id, self.folding.loops[node.id] or ())
        return _number(self.folding.names.get(node.id))

    def _attribute(self, node: ast.Attribute) -> Numbers:
        if not isinstance(node.value, ast.Name):
            raise NotHere
        owner, field = node.value.id, node.attr
        if owner == "params":
            return _number(self.folding.params.get(field))
        if owner not in self.loops:
            known = self.folding.names.get(owner)
            return _number(known.get(field) if isinstance(known, Mapping) else None)
        items = self.folding.loops[owner] or ()
        if isinstance(items, Grid):
            return self._of_grid(owner, items, field)
        return self._along(owner, [item[field] for item in items])

    def _of_grid(self, owner: str, grid: Grid, field: str) -> Numbers:
        import numpy as np

        if field not in FIELDS:
            raise NotHere
        index = np.arange(len(grid))
        if field == "index":
            return self._placed(owner, index, None)
        inner, outer = np.mod(index, grid.across), index // grid.across
        if grid.order == "snake":
            inner = np.where(outer % 2 == 1, grid.across - 1 - inner, inner)
        if grid.order == "columns":
            inner, outer = index // grid.down, np.mod(index, grid.down)
        if field in ("ix", "iy"):
            return self._placed(owner, inner if field == "ix" else outer, None)
        axis = _numbers(grid.x if field == "x" else grid.y)
        return self._placed(owner, axis.values[inner if field == "x" else outer], axis.unit)

    def _along(self, name: str, items: Sequence[Any]) -> Numbers:
        found = _numbers(items)
        return self._placed(name, found.values, found.unit)

    def _placed(self, name: str, values: Any, unit: str | None) -> Numbers:
        """The numbers of a loop along the axis of that loop."""
        shape = [1] * len(self.loops)
        shape[self.loops.index(name)] = len(values)
        return Numbers(values.reshape(shape), unit)

    def _unaryop(self, node: ast.UnaryOp) -> Numbers:
        inner = self.of(node.operand)
        if isinstance(node.op, ast.USub):
            return Numbers(-inner.values, inner.unit)
        if isinstance(node.op, ast.UAdd):
            return inner
        raise NotHere

    def _binop(self, node: ast.BinOp) -> Numbers:
        left, right = self.of(node.left), self.of(node.right)
        if isinstance(node.op, ast.Add | ast.Sub):
            unit = left.unit or right.unit
            a, b = left.in_unit(unit), right.in_unit(unit)
            return Numbers(a + b if isinstance(node.op, ast.Add) else a - b, unit)
        if isinstance(node.op, ast.Mult):
            return _with_unit(left.values * right.values, _product(left.unit, right.unit, 1))
        if isinstance(node.op, ast.Div):
            return _with_unit(left.values / right.values, _product(left.unit, right.unit, -1))
        if isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant):
            power = node.right.value
            unit = str(unit_of(left.unit) ** power) if left.unit is not None else None
            return _with_unit(left.values**power, unit)
        raise NotHere

    def _call(self, node: ast.Call) -> Numbers:
        import numpy as np

        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == LITERAL and all(isinstance(one, ast.Constant) for one in node.args):
            number, unit = (one.value for one in node.args)  # type: ignore[attr-defined]
            return Numbers(np.asarray(float(number)), str(unit_of(unit)))
        if name not in ("min", "max") or len(node.args) < 2 or node.keywords:
            raise NotHere
        parts = [self.of(one) for one in node.args]
        unit = next((part.unit for part in parts if part.unit), None)
        found = parts[0].in_unit(unit)
        for part in parts[1:]:
            pick = np.minimum if name == "min" else np.maximum
            found = pick(found, part.in_unit(unit))
        return Numbers(found, unit)


def _product(left: str | None, right: str | None, sign: int) -> str | None:
    if left is None and right is None:
        return None
    return str(unit_of(left or "") * unit_of(right or "") ** sign)


def _with_unit(values: Any, unit: str | None) -> Numbers:
    """Numbers whose units may have cancelled out: 4 mm / 100 um is 40."""
    if unit is None or not unit_of(unit).dimensionless:
        return Numbers(values, unit)
    return Numbers(values * magnitude_in(_one(unit), ""))


def _number(value: Any) -> Numbers:
    import numpy as np

    if is_quantity(value):
        return Numbers(np.asarray(float(value.magnitude)), str(value.units))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise NotHere
    return Numbers(np.asarray(float(value)))


def _numbers(items: Sequence[Any]) -> Numbers:
    """A list as numbers in the unit of its first item."""
    import numpy as np

    if isinstance(items, Span):
        return Numbers(items.start + np.arange(len(items)) * items.step, items.unit)
    first = items[0]
    unit = str(first.units) if is_quantity(first) else None
    if any(is_quantity(item) != (unit is not None) for item in items):
        raise NotHere
    if unit is None and not all(isinstance(item, int | float) for item in items):
        raise NotHere
    found = [magnitude_in(item, unit) if unit else item for item in items]
    return Numbers(np.asarray(found, dtype=float), unit)
