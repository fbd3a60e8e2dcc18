"""The arguments of an action fit its contract: names, types, units, ranges.

Whatever can be computed before the run is checked: parameters, constants, and every item of a
loop whose items are known, so that a grid that leaves the bench is found before the first point.

E203. An argument that the action does not have would do nothing: with `fed: 100` the axis would
move at its default speed.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 4, feed: 100}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 4, fed: 100}}

E204. A quantity must have the dimension that the contract requires, in any unit; a bare number is
in the contract's unit. A time where a length belongs is always a mistake.

Passes:

    params: {depth: {type: quantity, unit: mm, default: 4 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 1 cm, z: "${{ params.depth }}"}}

Fails:

    params: {dwell: {type: quantity, unit: s, default: 4 s}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: 1 cm, z: "${{ params.dwell }}"}}

E205. An action cannot start without a parameter that it requires.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: shot-1, file: a.csv}}

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: shot-1}}

E206. Text is not a number, and a number is not text: a driver that receives a type other than the
one its contract promises may do anything.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: "5", file: a.csv}}

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: 5, file: a.csv}}

E207. The contract and the lab's `limits` both set ranges. A point outside the bench would be
rejected by the device in the middle of the scan, or run the axis into a wall.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {point: "${{ grid(x=span(0, 700, 100), y=span(0, 800, 100), order='snake') }}"}
        steps:
          - {do: gantry.move_to, with: {x: "${{ point.x }}", y: "${{ point.y }}"}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {point: "${{ grid(x=span(0, 700, 100), y=span(0, 900, 100), order='snake') }}"}
        steps:
          - {do: gantry.move_to, with: {x: "${{ point.x }}", y: "${{ point.y }}"}}
"""

from collections.abc import Iterator, Mapping
from typing import Any

from ...schemas.contract import Action
from ...schemas.lab import Limit
from ...schemas.problem import Problem
from ...schemas.protocol import Do, Scalar
from ...schemas.quantity import UnitError, capital_slip, has_offset, is_quantity, same_dimension
from ..lab.bind import BoundRole
from ..language.arguments import ArgumentFault, fit_arguments
from ..language.expression import ExpressionError
from ..language.fold import Case, Folded, cases, fold
from ..language.operators import words
from ..language.shape import at as raw_at
from ..language.shape import keys_of
from ..language.types import Type, in_words
from ..language.value import Computed, Value, value_of
from ..language.wanted import bounds, wants
from ..survey.spots import Spot, StepAt
from .context import Context
from .points import first_outside, is_long

CODES = {
    "E203": "a parameter that the action does not have",
    "E204": "a quantity of the wrong dimension",
    "E205": "a missing parameter",
    "E206": "a value of the wrong type",
    "E207": "a value outside the range, pattern or choices that the contract or the lab allows",
}
DO = set(keys_of(Do))


def check(context: Context) -> Iterator[Problem]:
    """Every `do` whose action is known."""
    for step, at, bound, action in context.survey.actions():
        yield from _check(context, at, bound, action, step.do)


def _check(
    context: Context, at: StepAt, bound: BoundRole, action: Action, label: str
) -> Iterator[Problem]:
    known: dict[str, Any] = {}
    later: list[str] = []
    for name, spot in at.arguments.items():
        folded = _fold(spot)
        if (apart := _a_difference(spot, action, f"{label}.{name}")) is not None:
            later.append(name)
            yield _problem(context, at, apart)
            continue
        if folded.known and not folded.loops:
            known[name] = folded.value
            continue
        later.append(name)
        if name not in action.param_schemas():
            continue
        if folded.loops:
            fault = _by_cases(spot, folded, name, bound, action, label, at.step.when)
        else:
            fault = _by_type(spot, action.param_schemas()[name], f"{label}.{name}")
        if fault is not None:
            yield _problem(context, at, fault)
    given = {**known, **{name: None for name in later if name not in action.param_schemas()}}
    _, faults = fit_arguments(action, given, bound.limits, label=label, later=later)
    wrong = {fault.param for fault in faults}
    for name in action.param_schemas().keys() & at.arguments.keys() - wrong:
        unit = action.param_schemas()[name].get("unit", "")
        if slip := capital_slip(at.arguments[name].raw, unit):
            yield context.source.problem(
                (*at.place, "with", name), "W221", f"{label}.{name}: {slip}"
            )
    for fault in faults:
        if fault.code != "E205" or not _has_unknown_keys(context, at):
            yield _problem(context, at, fault)


def _has_unknown_keys(context: Context, at: StepAt) -> bool:
    """True where the missing key may be beside `with`, which is already reported."""
    return not context.whole and bool(set(raw_at(context.source.data, at.place)) - DO)


def _fold(spot: Spot) -> Folded:
    if spot.inferred()[1]:
        return Folded(known=False)
    return fold(spot.value, spot.env.folding())


def _problem(context: Context, at: StepAt, fault: ArgumentFault) -> Problem:
    name = fault.path[0] if fault.path else ""
    if not name or fault.code == "E205":
        return context.source.problem((*at.place, "do"), fault.code, fault.message, fault.hint)
    place = (*at.place, "with", *fault.path)
    return context.source.problem(
        place, fault.code, fault.message, fault.hint, key=fault.code == "E203"
    )


def _a_difference(spot: Spot, action: Action, label: str) -> ArgumentFault | None:
    """A difference of two temperatures where a place on a scale such as °C is wanted."""
    kind, faults = spot.inferred()
    unit = action.param_schemas().get(spot.what, {}).get("unit")
    if faults or not kind.difference or unit is None or not has_offset(unit):
        return None
    says = f"{label}: a difference of temperatures (K), the device wants a temperature ({unit})"
    return ArgumentFault(spot.what, says, "add it to a temperature", code="E204")


def _by_type(spot: Spot, schema: Mapping[str, Any], label: str) -> ArgumentFault | None:
    """What is wrong with a value that is not yet known but has a known type."""
    kind, faults = spot.inferred()
    if faults or kind.kind in ("any", "null"):
        return None
    unit = schema.get("unit")
    wanted = schema.get("type")
    says = f"{label}: {in_words(kind)}, the device wants {wants(schema)}"
    if kind.kind == "number" and kind.unit is not None:
        fits = unit is not None and same_dimension(kind.unit, unit)
        return None if fits else ArgumentFault(spot.what, says, code="E204")
    if wanted is None:
        return None
    names = _json_names(kind)
    allowed = {wanted} if isinstance(wanted, str) else set(wanted)
    if kind.kind == "text" and unit is not None:
        return (
            None
            if not spot.value or _inserts(spot)
            else ArgumentFault(spot.what, says, code="E206")
        )
    return None if names & allowed else ArgumentFault(spot.what, says, code="E206")


def _inserts(spot: Spot) -> bool:
    """Text with expressions in it may turn out to be `0.2 mm`."""
    return isinstance(spot.raw, str) and not spot.raw.strip().startswith("${{")


def _json_names(kind: Type) -> set[str]:
    if kind.kind == "number":
        return {"number", "integer"}
    return {
        {
            "text": "string",
            "moment": "string",
            "boolean": "boolean",
            "list": "array",
            "map": "object",
        }[kind.kind]
    }


def _there(computed: Any, case: Case) -> str:
    """The value where the item's own name does not show it."""
    number = computed.magnitude if is_quantity(computed) else computed
    plain = f"{number:g}" if isinstance(number, int | float) else ""
    return "" if plain and plain in case.where else f": it is {words(computed)} there"


def _by_cases(
    spot: Spot, folded: Folded, name: str, bound: BoundRole, action: Action, label: str,
    when: Scalar,
) -> ArgumentFault | None:  # fmt: skip
    """The first item of the enclosing loops that gives a value that does not fit, where it runs."""
    value = spot.value
    if not isinstance(value, Value):
        return None
    case = _far_outside(value, folded, spot, action.param_schemas()[name], bound.limits.get(name))
    if case is not None and not _left_out(when, case):
        return _case_fault(value, case, name, bound, action, label)
    for case in cases(folded, spot.env.folding(), value):
        fault = _case_fault(value, case, name, bound, action, label)
        if fault is not None and not _left_out(when, case):
            return fault
    return None


def _left_out(when: Scalar, case: Case) -> bool:
    """Whether the step is surely left out for this item, by its own `when`."""
    try:
        return when is not None and value_of(when).evaluate(case.names) is False
    except ExpressionError:
        return False  # only the run can tell


def _far_outside(
    value: Value, folded: Folded, spot: Spot, schema: Mapping[str, Any], limit: Limit | None
) -> Case | None:
    """In loops too long to try every item: an item whose value leaves the range."""
    folding = spot.env.folding()
    if not isinstance(value, Computed) or not is_long(value, folded.loops, folding):
        return None
    try:
        low, high = bounds(schema, limit)
    except UnitError:
        return None  # reported for the lab
    return first_outside(value, folded.loops, folding, schema.get("unit"), low, high)


def _case_fault(
    value: Value, case: Case, name: str, bound: BoundRole, action: Action, label: str
) -> ArgumentFault | None:
    try:
        computed = value.evaluate(case.names)
    except ExpressionError:
        return None  # reported by the family `calculations`
    _, faults = fit_arguments(
        action, {name: computed}, bound.limits, label=label, later=action.required()
    )
    if not faults:
        return None
    fault = faults[0]
    if fault.bounds:
        message = f"{label}.{name}: {case.where} is outside {fault.bounds}"
        message += _there(computed, case)
    else:
        message = f"{fault.message} (at {case.where})"
    return ArgumentFault(name, message, fault.hint, code=fault.code, path=(name,))
