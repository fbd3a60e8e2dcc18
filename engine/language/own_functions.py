"""Functions of one's own: `functions: {endpoint: ./analysis.py:endpoint}`, read from their text.

Their file is parsed, never imported: what they take and give is what their annotations say, with the
unit where there is one, `Annotated[float, "mm"]`. A run calls them in a process of their own.
"""

import ast
import inspect
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from ...schemas.quantity import UnitError, is_quantity, magnitude_in, quantity, unit_of
from .moments import moment_text
from .operators import OperatorFault, words
from .suggest import did_you_mean, listed
from .types import ANY, BOOLEAN, INTEGER, LIST, NULL, NUMBER, TEXT, Type, in_words, number
from .used_files import FileFault, find_file

LARGEST = 1_000_000
LONGEST = 100_000
SAID = re.compile(r"(?P<file>[^:]+\.py):(?P<name>[A-Za-z_]\w*)")
PLAIN_TYPES = {
    "float": NUMBER, "int": INTEGER, "str": TEXT, "bool": BOOLEAN, "list": LIST, "Any": ANY,
    "dict": Type("map", rest=ANY), "tuple": LIST, "None": NULL, "Sequence": LIST,
    "Mapping": Type("map", rest=ANY),
}  # fmt: skip


class FunctionFault(ValueError):
    """A function that cannot be used; the message says which and why, `hint` the way on."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


@dataclass(frozen=True, slots=True, eq=False)
class OwnFunction:
    """One function: where it is, its text, and the types of what it takes and gives."""

    name: str
    written: str
    path: Path
    function: str
    text: str
    signature: inspect.Signature
    returns: Type

    @property
    def signature_text(self) -> str:
        """`(widths, offset)`: what it takes, by name."""
        return f"({', '.join(self.signature.parameters)})"

    def given(self, args: Sequence[Any], kwargs: Mapping[str, Any]) -> dict[str, Any]:
        """The arguments as plain data in the units that they are annotated with; raises OperatorFault."""
        try:
            bound = self.signature.bind(*args, **kwargs)
        except TypeError as fault:
            raise OperatorFault(f"{self.name}: {fault}") from None
        return {
            name: _plain(value, self.signature.parameters[name].annotation, f"{self.name}: {name}")
            for name, value in bound.arguments.items()
        }

    def result(self, plain: Any) -> Any:
        """What the function gave, with its unit; raises OperatorFault."""
        return _united(plain, self.returns, self.name)


def read_function(name: str, said: str, protocol: Path, folders: Sequence[Path]) -> OwnFunction:
    """The function that `./analysis.py:endpoint` names; raises FunctionFault."""
    match = SAID.fullmatch(said.strip())
    if match is None:
        raise FunctionFault(
            f"{said!r} is not a function in a file", "such as ./analysis.py:mean_area"
        )
    try:
        path, data = find_file(protocol, match["file"], LARGEST, folders)
        text = data.decode("utf-8")
        tree = ast.parse(text)
    except FileFault as fault:
        raise FunctionFault(str(fault)) from fault
    except SyntaxError as fault:
        where = match["file"] + (f", line {fault.lineno}" if fault.lineno else "")
        raise FunctionFault(f"{where} is not Python: {fault.msg}") from fault
    except (UnicodeDecodeError, ValueError, RecursionError, MemoryError) as fault:
        raise FunctionFault(f"{match['file']} cannot be read as Python: {fault}") from fault
    if any(isinstance(n, ast.AsyncFunctionDef) and n.name == match["name"] for n in tree.body):
        raise FunctionFault(
            f"{match['name']} is `async`", "a function computes; it waits for nothing"
        )
    found = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    node = found.get(match["name"])
    if node is None:
        known = f"it has {listed(found)}" if found else "it has no functions of its own"
        guess = did_you_mean(match["name"], found)
        raise FunctionFault(f"{match['file']} has no function {match['name']}{guess}", known)
    signature = _signature(node)
    returns = _type(node.returns, f"{node.name}, what it returns")
    return OwnFunction(name, match["file"], path, node.name, text, signature, returns)


def _signature(node: ast.FunctionDef) -> inspect.Signature:
    said = node.args
    if said.vararg or said.kwarg:
        raise FunctionFault(f"{node.name} takes any number of arguments (*)", "name each of them")
    if said.posonlyargs:
        raise FunctionFault(
            f"{node.name} takes arguments without their names (/)", "leave out the /"
        )
    if any(isinstance(part, ast.Yield | ast.YieldFrom) for part in ast.walk(node)):
        raise FunctionFault(f"{node.name} is a generator (yield)", "return a list")
    first_default = len(said.args) - len(said.defaults)
    parts = [
        _parameter(arg, node, inspect.Parameter.POSITIONAL_OR_KEYWORD, given=index >= first_default)
        for index, arg in enumerate(said.args)
    ]
    parts += [
        _parameter(arg, node, inspect.Parameter.KEYWORD_ONLY, given=default is not None)
        for arg, default in zip(said.kwonlyargs, said.kw_defaults, strict=True)
    ]
    return inspect.Signature(parts)


def _parameter(arg: ast.arg, node: ast.FunctionDef, kind: Any, *, given: bool) -> inspect.Parameter:
    default = None if given else inspect.Parameter.empty
    kept = _type(arg.annotation, f"{node.name}, {arg.arg}")
    return inspect.Parameter(arg.arg, kind, default=default, annotation=kept)


def _type(node: ast.expr | None, what: str) -> Type:
    """The type that an annotation says."""
    if node is None:
        hint = 'such as `def area(widths: list[float]) -> Annotated[float, "mm**2"]:`'
        raise FunctionFault(f"{what}: there is no annotation", hint)
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        try:
            return _type(ast.parse(node.value, mode="eval").body, what)
        except SyntaxError:
            raise FunctionFault(f"{what}: {node.value!r} is not a type") from None
    if isinstance(node, ast.Constant) and node.value is None:
        return NULL
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):  # float | None
        sides = [_type(side, what) for side in (node.left, node.right)]
        known = [side for side in sides if side.kind != "null"]
        return known[0] if len(known) == 1 else ANY
    name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")
    if isinstance(node, ast.Subscript):
        return _of_parts(node, what)
    if name not in PLAIN_TYPES:
        known = listed(one for one in PLAIN_TYPES if one.islower())
        raise FunctionFault(
            f"{what}: a protocol has no values of the type {ast.unparse(node)}",
            f'there are {known}, list[float], and Annotated[float, "mm"]',
        )
    return PLAIN_TYPES[name]


def _of_parts(node: ast.Subscript, what: str) -> Type:
    """`list[float]`, `Annotated[float, "mm"]`, `dict[str, float]`."""
    owner = (
        node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
    )
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    if owner == "Annotated" and len(parts) == 2:
        return _with_unit(_type(parts[0], what), parts[1], what)
    if owner in ("list", "Sequence") and len(parts) == 1:
        return Type("list", item=_type(parts[0], what))
    if owner in ("dict", "Mapping") and len(parts) == 2:
        return Type("map", rest=_type(parts[1], what))
    if owner == "tuple":
        return LIST
    if owner == "Optional":
        return _type(parts[0], what)
    raise FunctionFault(f"{what}: a protocol has no values of the type {ast.unparse(node)}")


def _with_unit(kept: Type, node: ast.expr, what: str) -> Type:
    unit = node.value if isinstance(node, ast.Constant) else None
    if not isinstance(unit, str):
        raise FunctionFault(f"{what}: {ast.unparse(node)} is not a unit", 'such as "mm"')
    if kept.kind == "list":
        return Type("list", item=_with_unit(kept.item or ANY, node, what))
    if kept.kind != "number":
        raise FunctionFault(f"{what}: {in_words(kept)} has no unit")
    try:
        unit_of(unit)
    except UnitError as fault:
        raise FunctionFault(f"{what}: {fault}") from None
    return number(unit)


def misfit(given: Type, wanted: Type) -> str:
    """Why a value of one type cannot be an argument of another; empty where it can."""
    if "any" in (given.kind, wanted.kind) or given.kind == "null":
        return ""
    if given.kind == "moment" and wanted.kind == "text":
        return ""
    if given.kind != wanted.kind:
        return f"{in_words(given)}, not {in_words(wanted)}"
    if given.kind == "list":
        return misfit(given.item or ANY, wanted.item or ANY)
    if given.unit is None or given.unit == wanted.unit:
        return ""
    if wanted.unit is None:
        return f"{in_words(given)}, and it is annotated without a unit"
    if unit_of(given.unit).dimensionality != unit_of(wanted.unit).dimensionality:
        return f"{in_words(given)}, not {in_words(wanted)}"
    return ""


# --- values on their way there and back


def _plain(value: Any, wanted: Type, what: str) -> Any:
    if value is None:
        return None
    if isinstance(value, datetime):
        value = moment_text(value)
    if is_quantity(value):
        if wanted.unit is None:
            raise OperatorFault(f"{what} is {words(value)}, and it is annotated without a unit")
        try:
            return magnitude_in(value, wanted.unit)
        except UnitError as fault:
            raise OperatorFault(f"{what}: {fault}") from None
    if isinstance(value, Mapping):
        _expect(value, wanted, "map", what)
        return {str(key): _plain(item, wanted.rest or ANY, what) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        _expect(value, wanted, "list", what)
        if len(value) > LONGEST:
            raise OperatorFault(f"{what}: a list of {len(value):,} items; the limit is {LONGEST:,}")
        return [_plain(item, wanted.item or ANY, what) for item in value]
    _expect(value, wanted, _kind(value), what)
    return value


def _united(plain: Any, wanted: Type, what: str) -> Any:
    if plain is None:
        return None
    if isinstance(plain, float) and not math.isfinite(plain):
        raise OperatorFault(f"{what} gave {plain}, which is not a finite number")
    _expect(plain, wanted, _kind(plain), f"{what} gave")
    if isinstance(plain, list):
        return [_united(item, wanted.item or ANY, what) for item in plain]
    if isinstance(plain, dict):
        return {key: _united(item, wanted.rest or ANY, what) for key, item in plain.items()}
    return quantity(plain, wanted.unit) if wanted.unit is not None else plain


def _kind(value: Any) -> str:
    if isinstance(value, bool):
        return "boolean"
    kinds = {str: "text", list: "list", dict: "map", int: "number", float: "number"}
    return kinds.get(type(value), "any")


def _expect(value: Any, wanted: Type, kind: str, what: str) -> None:
    if wanted.kind not in ("any", kind):
        raise OperatorFault(f"{what} {words(value)}, not {in_words(wanted)}")


def read_functions(
    said: Mapping[str, str], protocol: Path, folders: Sequence[Path]
) -> Iterator[tuple[str, OwnFunction | FunctionFault]]:
    """Every function that a protocol declares, or why it cannot be used."""
    for name, written in said.items():
        try:
            yield name, read_function(name, written, protocol, folders)
        except FunctionFault as fault:
            yield name, fault
