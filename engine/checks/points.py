"""Find where a number leaves its range in a long loop; not a check, but a helper of `arguments`.

Only some items of a long loop are evaluated as a run would. Here an expression becomes a function of
bare numbers, its units reckoned once, quick enough for all of them. What this cannot compute (text,
results) is left alone.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from ...schemas.quantity import UnitError, is_number, is_quantity, magnitude_in, unit_of
from ..language.fold import MOST_ITEMS, Case, Folding, is_linear, name_item
from ..language.functions import LITERAL
from ..language.grid import Grid, Span
from ..language.value import Computed

MOST_POINTS = 5_000_000
Indices = tuple[int, ...]
"""Of one item of each loop, outermost first."""


class NotHere(Exception):
    """Something that is not computed here."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """Numbers of one unit, each computed from the indices of its items; no unit for plain numbers."""

    at: Callable[[Indices], float]
    unit: str | None = None

    def in_unit(self, unit: str | None) -> Callable[[Indices], float]:
        """The numbers in another unit; a bare 0 fits any."""
        if self.unit == unit or unit is None or self.unit is None:
            return self.at
        try:
            return _times(self.at, magnitude_in(_one(self.unit), unit))
        except UnitError as fault:
            raise NotHere from fault


def _times(at: Callable[[Indices], float], factor: float) -> Callable[[Indices], float]:
    return lambda indices: at(indices) * factor


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
    lists = [folding.loops[name] or () for name in loops]
    low, high = -math.inf if low is None else low, math.inf if high is None else high
    every = product(*(range(len(items)) for items in lists))
    try:
        at = Walk(loops, folding).of(value.expression.tree.body).in_unit(unit)
        picked = next((i for i in every if (n := at(i)) < low or n > high), None)
    except (NotHere, ValueError, TypeError, ArithmeticError):
        return None
    if picked is None:
        return None
    names = folding.given
    where = []
    for name, items, index in zip(loops, lists, picked, strict=True):
        names[name] = items[index]
        where.append(name_item(name, items, index, names[name]))
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
        if field == "index":
            return self._along(owner, range(len(grid)))
        if field not in ("x", "y", "ix", "iy"):
            raise NotHere
        across = field in ("x", "ix")
        axis = (grid.x if across else grid.y) if field in ("x", "y") else range(len(grid))
        values, unit = _numbers(axis)
        k, place, columns_of = self.loops.index(owner), 0 if across else 1, grid.columns_of
        return Numbers(lambda indices: values[columns_of(indices[k])[place]], unit)

    def _along(self, name: str, items: Sequence[Any]) -> Numbers:
        values, unit = _numbers(items)
        k = self.loops.index(name)
        return Numbers(lambda indices: values[indices[k]], unit)

    def _unaryop(self, node: ast.UnaryOp) -> Numbers:
        inner = self.of(node.operand)
        if isinstance(node.op, ast.USub):
            return Numbers(_times(inner.at, -1), inner.unit)
        if isinstance(node.op, ast.UAdd):
            return inner
        raise NotHere

    def _binop(self, node: ast.BinOp) -> Numbers:
        left, right = self.of(node.left), self.of(node.right)
        if isinstance(node.op, ast.Add | ast.Sub):
            unit = left.unit or right.unit
            work = operator.add if isinstance(node.op, ast.Add) else operator.sub
            return Numbers(_joined(work, left.in_unit(unit), right.in_unit(unit)), unit)
        if isinstance(node.op, ast.Mult):
            found = _joined(operator.mul, left.at, right.at)
            return _with_unit(found, _product(left.unit, right.unit, 1))
        if isinstance(node.op, ast.Div):
            found = _joined(_over, left.at, right.at)
            return _with_unit(found, _product(left.unit, right.unit, -1))
        if isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant):
            unit = str(unit_of(left.unit) ** node.right.value) if left.unit is not None else None
            return _with_unit(_joined(_power, left.at, right.at), unit)
        raise NotHere

    def _call(self, node: ast.Call) -> Numbers:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name == LITERAL and all(isinstance(one, ast.Constant) for one in node.args):
            number, unit = (one.value for one in node.args)  # type: ignore[attr-defined]
            return _constant(float(number), str(unit_of(unit)))
        if name not in ("min", "max") or len(node.args) < 2 or node.keywords:
            raise NotHere
        parts = [self.of(one) for one in node.args]
        unit = next((part.unit for part in parts if part.unit), None)
        first, *others = [part.in_unit(unit) for part in parts]
        for other in others:
            first = _joined(min if name == "min" else max, first, other)
        return Numbers(first, unit)


def _joined(
    work: Callable[[float, float], float],
    left: Callable[[Indices], float],
    right: Callable[[Indices], float],
) -> Callable[[Indices], float]:
    return lambda indices: work(left(indices), right(indices))


def _over(a: float, b: float) -> float:
    if b:
        return a / b
    return math.copysign(math.inf, a) if a else math.nan


def _power(a: float, b: float) -> float:
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.inf
    except ValueError:  # a root of less than 0, or 0 ** -1
        return math.nan if a else math.inf


def _product(left: str | None, right: str | None, sign: int) -> str | None:
    if left is None and right is None:
        return None
    return str(unit_of(left or "") * unit_of(right or "") ** sign)


def _with_unit(at: Callable[[Indices], float], unit: str | None) -> Numbers:
    """Numbers whose units may have cancelled out: 4 mm / 100 um is 40."""
    if unit is None or not unit_of(unit).dimensionless:
        return Numbers(at, unit)
    return Numbers(_times(at, magnitude_in(_one(unit), "")))


def _constant(number: float, unit: str | None = None) -> Numbers:
    return Numbers(lambda _: number, unit)


def _number(value: Any) -> Numbers:
    if is_quantity(value):
        return _constant(float(value.magnitude), str(value.units))
    if not is_number(value):
        raise NotHere
    return _constant(float(value))


def _numbers(items: Sequence[Any]) -> tuple[Sequence[float], str | None]:
    """A list as numbers in the unit of its first item."""
    if isinstance(items, Span):
        return [items.number(index) for index in range(len(items))], items.unit
    if isinstance(items, range):
        return items, None
    unit = str(items[0].units) if is_quantity(items[0]) else None
    if any(is_quantity(item) != (unit is not None) for item in items):
        raise NotHere
    if unit is None and not all(isinstance(item, int | float) for item in items):
        raise NotHere
    return [float(magnitude_in(item, unit) if unit else item) for item in items], unit
