"""Infer the type that a function of the language returns, and find arguments that cannot work."""

import ast
import inspect
from functools import cache
from typing import TYPE_CHECKING, Any

from ...schemas.quantity import same_dimension
from .calculated import BARE, OF_LISTS, OF_NUMBERS, type_of_calculation
from .calculations import CALCULATIONS
from .functions import FUNCTIONS, LITERAL
from .grid import FITS, ORDERS
from .own_functions import misfit
from .read_expression import as_written
from .suggest import did_you_mean, listed
from .types import ANY, INTEGER, MOMENT, NUMBER, TEXT, Type, either, fields, in_words, number

if TYPE_CHECKING:
    from .infer import Inference

ZERO = Type("number", whole=True, zero=True)


def type_of_call(inference: "Inference", node: ast.Call) -> Type:
    """The type that a function returns for these arguments; what cannot work is recorded."""
    assert isinstance(node.func, ast.Name)
    name = node.func.id
    if name == LITERAL:
        return number(node.args[1].value)  # type: ignore[attr-defined]
    if name == "csv":
        return _table(inference, node)
    positional = [inference.of(argument) for argument in node.args]
    named = {keyword.arg or "": inference.of(keyword.value) for keyword in node.keywords}
    if name in inference.calls:
        return _own(inference, name, positional, named)
    try:
        bound = _signature(name).bind(*positional, **named)
    except TypeError as fault:
        return inference.fault("E307", f"{name}: {fault}", f"write {_example(name)}")
    if name in TOGETHER and not _are_alike(inference, name, node, positional):
        return ANY
    if name in OPTIONS and (fault := _unknown_option(inference, name, node)) is not None:
        return fault
    return _result(inference, name, bound.arguments, as_written(node))


OPTIONS = {"span": ("fit", FITS), "grid": ("order", ORDERS)}
"""What may be said in one of a few words, and these."""


def _unknown_option(inference: "Inference", name: str, node: ast.Call) -> Type | None:
    option, known = OPTIONS[name]
    for keyword in node.keywords:
        if keyword.arg == option and _is_text(keyword.value):
            said = keyword.value.value  # type: ignore[attr-defined]
            if said not in known:
                message = f"{name}: {option} is {said!r}{did_you_mean(said, known)}"
                return inference.fault("E307", message, f"it is one of {listed(known)}")
    return None


TOGETHER = {"min", "max", "sum", "mean", "median", "stdev", "sorted", "linspace", "atan2"}
"""Functions whose values are computed with each other, so that they need one dimension."""


def _are_alike(inference: "Inference", name: str, node: ast.Call, types: list[Type]) -> bool:
    """Whether the values of a call, or of the list that is written in it, go together."""
    values = list(zip(node.args, types, strict=True))
    if name == "linspace":
        values = values[:2]
    if len(values) == 1 and isinstance(node.args[0], ast.List):
        count = len(inference.faults)
        values = [(one, inference.of(one)) for one in node.args[0].elts]
        del inference.faults[count:]  # told already
    numbers = [(one, kind) for one, kind in values if kind.kind == "number" and not kind.zero]
    return all(
        inference.go_together(*numbers[0], *other, f"used together in {name}")
        for other in numbers[1:]
    )


def _own(inference: "Inference", name: str, given: list[Type], named: dict[str, Type]) -> Type:
    """What a function of the protocol's own returns; what cannot be its arguments is recorded."""
    function = inference.names.function(name)
    if function is None:
        return ANY
    try:
        bound = function.signature.bind(*given, **named)
    except TypeError as fault:
        return inference.fault("E307", f"{name}: {fault}", f"it is {name}{function.signature_text}")
    for parameter, kind in bound.arguments.items():
        if why := misfit(kind, function.signature.parameters[parameter].annotation):
            inference.fault("E308", f"{name}: {parameter} is {why}")
    return function.returns


def _result(inference: "Inference", name: str, given: dict[str, Any], said: str) -> Type:
    if name == "span":
        return _span(inference, given, said)
    if name == "grid":
        return _grid(inference, given)
    if name == "inside":
        return _inside(inference, given)
    if name in ("min", "max"):
        values = given["values"]
        if len(values) == 1:
            return values[0].item or ANY if values[0].kind == "list" else ANY
        return next((v for v in values if v.unit is not None), either(list(values)))
    if name == "round":
        value = given["value"]
        bare = value.kind == "number" and value.unit is None and "digits" not in given
        return INTEGER if bare else value
    if name == "range":
        return Type("list", item=INTEGER)
    if name in CALCULATIONS:
        return _calculation(inference, name, given, said)
    return {"len": INTEGER, "now": MOMENT, "elapsed": number("s")}.get(name, TEXT)


def _calculation(inference: "Inference", name: str, given: dict[str, Any], said: str) -> Type:
    first = next(iter(given.values()), ANY)
    if not isinstance(first, Type):  # `zip` takes any number of lists
        return type_of_calculation(name, given)
    wanted = "list" if name in OF_LISTS else "number"
    if first.kind not in (wanted, "any", "null"):
        takes_more = name in CALCULATIONS and name not in OF_LISTS | OF_NUMBERS
        if not takes_more and not (name == "int" and first.kind == "text"):
            what = "a list" if wanted == "list" else "a number"
            return inference.fault("E308", f"{said}: {name} takes {what}, not {in_words(first)}")
    if name in BARE and first.unit is not None:
        message = f"{said}: {name} takes a plain number, not {in_words(first)}"
        return inference.fault(
            "E308", message, f"divide by a unit first: {name}(x / (1 {first.unit}))"
        )
    angle = first.unit is None or same_dimension(first.unit, "rad")
    if name in ("sin", "cos", "tan") and first.kind == "number" and not angle:
        return inference.fault(
            "E308", f"{said}: {name} takes an angle, not {in_words(first)}", "such as 30 deg"
        )
    return type_of_calculation(name, given)


def _table(inference: "Inference", node: ast.Call) -> Type:
    given = [*node.args, *(keyword.value for keyword in node.keywords)]
    if len(node.args) != 1 or not all(_is_text(one) for one in given):
        message = "csv: the file and the kinds of its columns must be plain text"
        return inference.fault("E307", message, f"write {_example('csv')}")
    kinds = {k.arg or "": k.value.value for k in node.keywords}  # type: ignore[attr-defined]
    return inference.noted(inference.names.table(node.args[0].value, kinds))  # type: ignore[attr-defined]


def _span(inference: "Inference", given: dict[str, Any], said: str) -> Type:
    parts = [given[name] for name in ("start", "stop", "step")]
    united = next((part for part in parts if part.unit is not None), None)
    for name, part in zip(("start", "stop", "step"), parts, strict=True):
        if part.kind not in ("number", "any", "null"):
            return inference.fault("E308", f"{said}: {name} is {in_words(part)}, not a number")
        if united is None or part.kind != "number" or part.zero:
            continue
        if part.unit is None or not same_dimension(part.unit, united.unit or ""):
            message = f"{said}: {name} is {in_words(part)}, the others are {in_words(united)}"
            return inference.fault("E308", message)
    return Type("list", item=number(united.unit) if united else NUMBER)


def _grid(inference: "Inference", given: dict[str, Any]) -> Type:
    for name in ("x", "y"):
        axis = given.get(name)
        if axis is None:
            return inference.fault("E307", f"grid: {name} is missing", f"write {_example('grid')}")
        if axis.kind not in ("list", "any"):
            return inference.fault(
                "E308",
                f"grid: {name} is {in_words(axis)}, not a span or a list",
                f"write {_example('grid')}",
            )
    x, y = given["x"].item or ANY, given["y"].item or ANY
    return Type("list", item=fields(x=x, y=y, ix=INTEGER, iy=INTEGER, index=INTEGER))


def _inside(inference: "Inference", given: dict[str, Any]) -> Type:
    for name in ("points", "outline"):
        values = given.get(name)
        if values is None:
            message = f"inside: {name} is missing"
            return inference.fault("E307", message, f"write {_example('inside')}")
        if values.kind not in ("list", "any", "null"):
            return inference.fault("E308", f"inside: {name} is {in_words(values)}, not a list")
    points, margin = given["points"], given.get("margin", ZERO)
    x = (points.item or ANY).fields.get("x", ANY)
    if margin.kind not in ("number", "any") or not _measure_alike(margin, x):
        message = f"inside: margin is {in_words(margin)}, and x of the points is {in_words(x)}"
        return inference.fault("E308", message)
    return points


def _measure_alike(one: Type, other: Type) -> bool:
    if one.kind != "number" or other.kind != "number" or one.zero:
        return True
    if one.unit is None or other.unit is None:
        return one.unit is other.unit
    return same_dimension(one.unit, other.unit)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


@cache
def _signature(name: str) -> inspect.Signature:
    return inspect.signature(FUNCTIONS[name])


def _example(name: str) -> str:
    return {
        "grid": "grid(x=span(0, 4, 0.2), y=span(0, 10, 0.2), order='snake')",
        "span": "span(0, 4, 0.2)", "inside": "inside(grid(...), steps.look.samples[0].outline, 1 mm)",
        "range": "range(5)", "len": "len(params.samples)",
        "min": "min(a, b)", "max": "max(a, b)", "round": "round(x, 2)", "format": "format(x, '.2f')",
        "csv": "csv('samples.csv', x='mm', count='integer')", "atan2": "atan2(y, x)",
        "linspace": "linspace(0 mm, 4 mm, 9)", "polyfit": "polyfit(xs, ys, 1)", "zip": "zip(a, b)",
        "interp": "interp(x, xs, ys)", "now": "now()", "elapsed": "elapsed()",
        "enumerate": "enumerate(values)",
    }.get(name, f"{name}({'values' if name in OF_LISTS else 'x'})")  # fmt: skip
