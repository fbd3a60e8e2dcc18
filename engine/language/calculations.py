"""Functions that calculate: statistics, roots and angles, curves, lists; with units and with null.

What is computed from null is null; a list's nulls, left by steps that did not run, are passed
over, as in `min` and `max`. Values of one dimension are computed in the unit of the first; a bare 0
fits any.
"""

import ast
import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import cmp_to_key
from itertools import pairwise
from typing import Any

from ...schemas.quantity import has_offset, is_number, is_quantity, magnitude_in, quantity
from .least_squares import least_squares
from .operators import (
    OPERATORS,
    OperatorFault,
    add,
    difference,
    divide,
    fit,
    power,
    words,
)  # fmt: skip

LONGEST_LIST = 100_000
HIGHEST_DEGREE = 10


def absolute(value: Any) -> Any:
    """The distance from zero; a quantity keeps its unit."""
    return _of_one("abs", value, abs)


def floor(value: Any) -> Any:
    """The next whole number below; a quantity keeps its unit."""
    return _of_one("floor", value, math.floor)


def ceil(value: Any) -> Any:
    """The next whole number above; a quantity keeps its unit."""
    return _of_one("ceil", value, math.ceil)


def _of_one(name: str, value: Any, function: Callable[[Any], Any]) -> Any:
    if value is None:
        return None
    if is_quantity(value):
        return quantity(function(value.magnitude), str(value.units))
    return function(_bare(name, value))


def integer(value: Any) -> Any:
    """A number without its fraction, or the whole number that a text says."""
    if isinstance(value, str):
        try:
            return int(value)
        except ValueError:
            raise OperatorFault(f"int: {words(value)} is not a whole number") from None
    return None if value is None else int(_bare("int", value))


def square_root(value: Any) -> Any:
    """The square root: of 4 mm * 1 mm it is 2 mm."""
    if value is None:
        return None
    if (value.magnitude if is_quantity(value) else _bare("sqrt", value)) < 0:
        raise OperatorFault(f"sqrt: {words(value)} has no real root")
    return power(value, 0.5)


def _plain(name: str, function: Callable[[float], float]) -> Callable[[Any], Any]:
    def of_a_number(value: Any) -> Any:
        if value is None:
            return None
        bare = _bare(name, value)
        try:
            return function(bare)
        except ValueError:
            raise OperatorFault(f"{name} of {words(value)} does not exist") from None

    of_a_number.__doc__ = f"{name} of a number without a unit; `log` is to the base e."
    return of_a_number


def _angle(name: str, function: Callable[[float], float]) -> Callable[[Any], Any]:
    def of_an_angle(angle: Any) -> Any:
        if angle is None:
            return None
        if is_quantity(angle):
            try:
                return function(magnitude_in(angle, "rad"))
            except ValueError:
                raise OperatorFault(f"{name}: {words(angle)} is not an angle") from None
        return function(_bare(name, angle))

    of_an_angle.__doc__ = f"{name} of an angle; a bare number is in rad."
    return of_an_angle


def atan2(y: Any, x: Any) -> Any:
    """The angle of the point (x, y), in rad, from -pi to pi."""
    if y is None or x is None:
        return None
    (up, across), _ = _alike("atan2", [y, x])
    return quantity(math.atan2(up, across), "rad")


def total(values: Any) -> Any:
    """The sum of a list; 0 if it is empty."""
    known = _known("sum", values)
    if not known:
        return 0 if len(values) == 0 else None
    result = known[0]
    for value in known[1:]:
        result = add(result, value)
    return result


def mean(values: Any) -> Any:
    """The arithmetic mean of a list."""
    from statistics import fmean

    return _statistic("mean", values, fmean)


def median(values: Any) -> Any:
    """The median of a list."""
    from statistics import median

    return _statistic("median", values, median)


def stdev(values: Any) -> Any:
    """The standard deviation of a sample (n - 1 in the denominator); of temperatures, in K."""
    from statistics import stdev

    return _statistic("stdev", values, stdev, least=2, differs=True)


def _statistic(
    name: str, values: Any, function: Callable[[Sequence[float]], float], *, least: int = 1,
    differs: bool = False,
) -> Any:  # fmt: skip
    known = _known(name, values)
    if len(known) < least:
        if len(values) == len(known):  # nothing is missing: the list is too short as it is
            raise OperatorFault(f"{name} needs at least {least} of them; the list has {len(known)}")
        return None
    numbers, unit = _alike(name, known)
    value = function(numbers)
    return difference(value, unit) if differs and unit is not None else _measured(value, unit)


def in_order(values: Any) -> list[Any]:
    """A list from its smallest to its largest value; nulls come last."""
    known = _known("sorted", values)
    before = OPERATORS[ast.Lt]
    order = cmp_to_key(lambda a, b: before(b, a) - before(a, b))
    return [*sorted(known, key=order), *[None] * (len(values) - len(known))]


def backwards(values: Any) -> list[Any]:
    """A list from its last to its first item."""
    return list(reversed(_list("reversed", values)))


def together(*lists: Any) -> list[list[Any]]:
    """The first items of several lists, then the second ones: [[a1, b1], [a2, b2]]."""
    found = [_list("zip", values) for values in lists]
    if len({len(values) for values in found}) > 1:
        counts = " and ".join(str(len(values)) for values in found)
        raise OperatorFault(f"zip: the lists have {counts} items; they must be of one length")
    return [list(items) for items in zip(*found, strict=True)]


def numbered(values: Any, start: int = 0) -> list[list[Any]]:
    """Each item with its number: [[0, a], [1, b]]."""
    if type(start) is not int:
        raise OperatorFault(f"enumerate: {words(start)} is not a whole number")
    return [[index, item] for index, item in enumerate(_list("enumerate", values), start)]


def linspace(start: Any, stop: Any, n: int) -> list[Any]:
    """`n` values from `start` to `stop`, both included, evenly apart."""
    if type(n) is not int or not 1 <= n <= LONGEST_LIST:
        raise OperatorFault(
            f"linspace: {words(n)} is not a whole number from 1 to {LONGEST_LIST:,}"
        )
    if start is None or stop is None:
        return [None] * n
    (first, last), unit = _alike("linspace", [start, stop])
    steps = max(n - 1, 1)
    numbers = [float(f"{first + (last - first) * i / steps:.12g}") for i in range(n)]
    return [_measured(number, unit) for number in numbers]


def polyfit(x: Any, y: Any, degree: int = 1) -> list[Any]:
    """The least-squares polynomial through points: coefficients, the highest power first.

    Coefficient of x**k is in the unit of y / x**k. Points with a null are left out.
    """
    if type(degree) is not int or not 0 <= degree <= HIGHEST_DEGREE:
        raise OperatorFault(
            f"polyfit: {words(degree)} is not a whole number from 0 to {HIGHEST_DEGREE}"
        )
    xs, x_unit, ys, y_unit = _points("polyfit", x, y)
    if x_unit is not None and has_offset(x_unit):
        raise OperatorFault(f"polyfit: x is in {x_unit}, whose zero is arbitrary; give it in K")
    if len(set(xs)) <= degree:
        raise OperatorFault(
            f"polyfit: degree {degree} needs points at {degree + 1} places; there are {len(set(xs))}"
        )
    try:
        found = least_squares(xs, ys, degree)
    except (ArithmeticError, ValueError):
        raise OperatorFault("polyfit: some numbers are too large, too small or too close") from None
    powers = range(degree, -1, -1)
    return [_coefficient(c, y_unit, x_unit, k) for c, k in zip(found, powers, strict=True)]


def _coefficient(value: float, y_unit: str | None, x_unit: str | None, k: int) -> Any:
    if k == 0 or (x_unit is None and y_unit is None):
        return _measured(value, y_unit)
    scaled = value if y_unit is None else difference(value, y_unit)
    return scaled if x_unit is None else divide(scaled, power(quantity(1.0, x_unit), k))


def interp(x: Any, xs: Any, ys: Any) -> Any:
    """y at x, on straight lines between the points; `xs` must rise, and x lie among them."""
    if x is None:
        return None
    places, unit, heights, y_unit = _points("interp", xs, ys)
    if len(places) < 2 or any(b <= a for a, b in pairwise(places)):
        raise OperatorFault("interp: xs must be at least two values, each larger than the last")
    (_, at), _ = _alike("interp", [_measured(places[0], unit), x])
    if not places[0] <= at <= places[-1]:
        low, high = (_measured(one, unit) for one in (places[0], places[-1]))
        raise OperatorFault(f"interp: {words(x)} lies outside {words(low)} to {words(high)}")
    left = min(bisect_right(places, at), len(places) - 1) - 1
    (x0, x1), (y0, y1) = places[left : left + 2], heights[left : left + 2]
    # At an end this is the value there, to the last digit.
    return _measured(y1 if at == x1 else y0 + (y1 - y0) / (x1 - x0) * (at - x0), y_unit)


def _points(name: str, x: Any, y: Any) -> tuple[list[float], str | None, list[float], str | None]:
    xs, ys = _list(name, x), _list(name, y)
    if len(xs) != len(ys):
        raise OperatorFault(f"{name}: {len(xs)} values of x and {len(ys)} of y")
    pairs = [(a, b) for a, b in zip(xs, ys, strict=True) if a is not None and b is not None]
    if not pairs:
        raise OperatorFault(f"{name}: there are no points")
    across, x_unit = _alike(name, [a for a, _ in pairs])
    up, y_unit = _alike(name, [b for _, b in pairs])
    return across, x_unit, up, y_unit


def _list(name: str, values: Any) -> list[Any]:
    if isinstance(values, str) or not isinstance(values, Sequence):
        raise OperatorFault(f"{name} takes a list; {words(values)} is none")
    if len(values) > LONGEST_LIST:
        raise OperatorFault(
            f"{name}: a list of {len(values):,} items; the limit is {LONGEST_LIST:,}"
        )
    return list(values)


def _known(name: str, values: Any) -> list[Any]:
    return [value for value in _list(name, values) if value is not None]


def _bare(name: str, value: Any) -> Any:
    if is_quantity(value):
        try:
            return magnitude_in(value, "")
        except ValueError:
            raise OperatorFault(f"{name}: {words(value)} has a unit; divide by one first") from None
    if not is_number(value):
        raise OperatorFault(f"{name}: {words(value)} is not a number")
    return value


def _alike(name: str, values: Sequence[Any]) -> tuple[list[float], str | None]:
    """Values of one dimension as numbers, and their unit."""
    unit = next((str(value.units) for value in values if is_quantity(value)), None)
    if unit is None:
        return [_bare(name, value) for value in values], None
    first = next(value for value in values if is_quantity(value))
    verb = f"used together in {name}"
    return [magnitude_in(fit(value, first, verb)[0], unit) for value in values], unit


def _measured(value: float, unit: str | None) -> Any:
    return value if unit is None else quantity(value, unit)


CALCULATIONS: dict[str, Callable[..., Any]] = {
    "abs": absolute, "floor": floor, "ceil": ceil, "int": integer, "sqrt": square_root,
    "exp": _plain("exp", math.exp), "log": _plain("log", math.log), "log10": _plain("log10", math.log10),
    "sin": _angle("sin", math.sin), "cos": _angle("cos", math.cos), "tan": _angle("tan", math.tan),
    "atan2": atan2, "sum": total, "mean": mean, "median": median, "stdev": stdev, "sorted": in_order,
    "reversed": backwards, "zip": together, "enumerate": numbered, "linspace": linspace,
    "polyfit": polyfit, "interp": interp,
}  # fmt: skip
"""Not reserved: a protocol may have names of its own that are spelt like these."""
