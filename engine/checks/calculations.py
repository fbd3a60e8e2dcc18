"""Every expression can be computed, and gives the kind of value that its place needs.

E307. Some calculations have no result: a division by zero, a span whose step does not divide its
range (`fit='inside'` lets the last step fall short), a function without an argument that it needs.

Passes:

    params: {width: {type: quantity, unit: mm, default: 4 mm}}
    devices: {gantry: gantry@1}
    steps:
      - foreach: {x: "${{ span(0, params.width, 0.5 mm) }}"}
        steps:
          - {do: gantry.move_to, with: {x: "${{ x }}"}}

Fails:

    params: {width: {type: quantity, unit: mm, default: 4 mm}}
    devices: {gantry: gantry@1}
    steps:
      - foreach: {x: "${{ span(0, params.width, 0.3 mm) }}"}
        steps:
          - {do: gantry.move_to, with: {x: "${{ x }}"}}

E308. A length cannot be added to a time, nor text to a number. A bare 0 fits any unit; for any
other bare number beside a quantity, the intended unit is unclear.

Passes:

    params: {width: {type: quantity, unit: mm, default: 4 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: "${{ params.width + 1 cm }}"}}

Fails:

    params: {width: {type: quantity, unit: mm, default: 4 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: "${{ params.width + 1 s }}"}}

E309. `foreach` needs a list, a span or a grid; `timeout` and `wait` need a time, `until` a time of day
or a date with its time; `repeat`, `max` and `max_failed` need a whole number; `when`, `if`, `while` and
`require` need an expression, all of it between the braces: `${{ a }} > 3` is text, and always true. The
`key` of an iteration is its name for ever, so no clock gives it.

Passes:

    params: {ready: {type: boolean, default: true}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, when: "${{ params.ready }}"}
      - wait: 5 s

Fails:

    params: {ready: {type: boolean, default: true}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, when: "${{ params.ready }}"}
      - wait: a moment
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any

from ...schemas.problem import Problem
from ...schemas.protocol import Retry
from ...schemas.quantity import UnitError, is_quantity, same_dimension, seconds
from ..language.expression import Expression, ExpressionError
from ..language.fold import cases, fold
from ..language.grid import LONGEST
from ..language.moments import next_moment
from ..language.operators import words
from ..language.types import Type, in_words, type_of_value
from ..language.value import Constant, Text, Value
from ..survey.spots import Spot
from .context import Context
from .texts import as_quantity, items_like_quantities, texts_like_quantities

CODES = {
    "E307": "something that cannot be computed with the values it has",
    "E308": "values in an expression that cannot be combined",
    "E309": "a value of the wrong kind for its place",
}


def check(context: Context) -> Iterator[Problem]:
    """Every place that may hold an expression, and the durations that may not."""
    texts = {name: as_quantity(name, text) for _, name, text in texts_like_quantities(context)}
    texts |= {name: as_quantity(name, items) for name, items in items_like_quantities(context)}
    for spot in context.survey.spots:
        yield from _check(context, spot, texts)
    for at in context.survey.steps:
        yield from _retry_times(context, at.step.retry, (*at.place, "retry"))
    yield from _retry_times(context, context.protocol.defaults.retry, ("defaults", "retry"))


def _check(context: Context, spot: Spot, texts: Mapping[str, str]) -> Iterator[Problem]:
    if isinstance(spot.value, Exception):
        return
    kind, faults = spot.inferred()
    as_text = next((texts[name] for name in spot.value.names & texts.keys()), "")
    for fault in faults:
        if fault.code in CODES:
            hint = as_text or fault.hint
            yield context.source.problem(spot.place, fault.code, fault.message, hint)
    if faults:
        return
    if spot.use == "condition" and isinstance(spot.value, Text):
        message = f"{spot.what}: text around `${{{{ }}}}` makes text of it, which would always count as true"
        yield context.source.problem(
            spot.place, "E309", message, _between_braces(spot.what, spot.value)
        )
        return
    if spot.use == "key" and spot.value.live:
        message = "a clock cannot give the key: it is the iteration's name for ever"
        yield context.source.problem(spot.place, "E309", message, "use what the loop goes through")
        return
    folded = fold(spot.value, spot.env.folding())
    if folded.fault or folded.loops:
        message = folded.fault or _first_fault(spot)
        if message:
            yield context.source.problem(spot.place, "E307", message, as_text)
        return
    wrong = _wrong_value(spot, folded.value) if folded.known else _wrong_type(spot, kind)
    if wrong:
        yield context.source.problem(spot.place, "E309", *wrong)


def _between_braces(what: str, text: Text) -> str:
    """How a condition is written that has something beside its braces."""
    meant = "".join(part if isinstance(part, str) else part.text for part in text.parts).strip(
        " =;,."
    )
    try:
        Expression(meant)
    except ExpressionError:
        return "write all of it between the braces"
    return f"write {what}: ${{{{ {meant} }}}}"


def _first_fault(spot: Spot) -> str:
    """Why the value cannot be computed for one of the items of the enclosing loops."""
    value = spot.value
    assert isinstance(value, Value)
    folding = spot.env.folding()
    for case in cases(fold(value, folding), folding, value):
        try:
            value.evaluate(case.names)
        except ExpressionError as fault:
            return f"{fault.reason} (at {case.where})"
    return ""


Wrong = tuple[str, str]
CHOICE = re.compile(r"\$\{\{\s*steps\.\w+\.choice\s*\}\}")


def _wrong_value(spot: Spot, value: Any) -> Wrong | None:
    """What is wrong with a value that is known."""
    use, what = spot.use, spot.what
    if use == "items" and (isinstance(value, str) or not isinstance(value, Sequence)):
        hint = "such as [1, 2, 3]"
        if isinstance(value, int) and not isinstance(value, bool):
            hint = f"${{{{ range({value}) }}}} has so many; `repeat: {value}` needs no name"
        if isinstance(value, str) and value.endswith(".csv"):
            hint = f"write \"${{{{ csv('{value}') }}}}\""
        if isinstance(value, str) and "(" in value:  # a call, without its braces or with too few
            hint = f"write ${{{{ {value.strip('${} ')} }}}}"
        return f"foreach needs a list, a span or a grid, not {words(value)}", hint
    if use == "duration":
        return _wrong_duration(what, value)
    if use == "moment":
        return _wrong_moment(value)
    least = int(what == "at_once")
    if use == "count" and not _is_count(value, least):
        return f"{what}: {words(value)} is not a whole number from {least}", f"such as {what}: 3"
    if use == "count" and isinstance(value, int) and value > LONGEST:
        return f"{what}: more than {LONGEST:,}", f"such as {what}: 3"
    if use == "condition" and not isinstance(spot.value, Constant):
        return _neither(what, type_of_value(value))
    if use == "condition" and isinstance(spot.value, Constant) and not isinstance(value, bool):
        hint = f"write {what}: ${{{{ {value} }}}}" if isinstance(value, str) else "write ${{ ... }}"
        return f"{what}: {words(value)} is not an expression", hint
    return None


def _wrong_moment(value: Any) -> Wrong | None:
    try:
        next_moment(value, datetime.now().astimezone())
    except ValueError as fault:
        return f"until: {fault}", 'such as until: "07:00"'
    return None


def _is_count(value: Any, least: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def _wrong_duration(what: str, value: Any) -> Wrong | None:
    hint = f"such as {what}: 30 s"
    if isinstance(value, bool) or not (isinstance(value, int | float | str) or is_quantity(value)):
        return f"{what}: {words(value)} is not a time", hint
    try:
        length = seconds(value)
    except (UnitError, ValueError, TypeError) as fault:
        return f"{what}: {fault}", hint
    if length < 0 or (length == 0 and what in ("timeout", "every", "stale")):
        return f"{what}: {words(value)} is too short", hint
    return None


def _wrong_type(spot: Spot, kind: Type) -> Wrong | None:
    """What is wrong with a value of which only the type is known."""
    if kind.kind in ("any", "null"):
        return None
    if spot.use == "condition" and (kind.unit is not None or CHOICE.fullmatch(str(spot.raw))):
        return _neither(spot.what, kind)
    if spot.use == "items" and kind.kind != "list":
        return (
            f"foreach needs a list, a span or a grid; this is {in_words(kind)}",
            "such as [1, 2, 3]",
        )
    if spot.use == "duration" and kind.kind != "text":
        fits = kind.kind == "number" and (kind.unit is None or same_dimension(kind.unit, "s"))
        hint = (
            "`while:` with a `wait` among its steps waits for a condition"
            if kind.kind == "boolean" and spot.what == "wait"
            else ""
        )
        return None if fits else (f"{spot.what} needs a time; this is {in_words(kind)}", hint)
    if spot.use == "moment" and kind.kind not in ("moment", "text"):
        return f"until needs a time of day or a moment; this is {in_words(kind)}", 'such as "07:00"'
    if spot.use == "count" and not (kind.kind == "number" and kind.unit is None):
        return f"{spot.what} needs a whole number; this is {in_words(kind)}", ""
    return None


def _neither(what: str, kind: Type) -> Wrong | None:
    """A quantity, or a text that is never empty, as a condition: true whatever it says."""
    if kind.kind == "text":
        return f"{what}: this is text, neither true nor false", "compare it: ${{ ... == 'yes' }}"
    if kind.unit is not None:
        return (
            f"{what}: this is {in_words(kind)}, neither true nor false",
            "compare it with another",
        )
    return None


def _retry_times(context: Context, retry: Any, place: tuple[str | int, ...]) -> Iterator[Problem]:
    if isinstance(retry, int) and retry < 1:
        yield context.source.problem(
            place, "E309", f"retry: {retry} attempts; at least 1 is needed, including the first"
        )
    if not isinstance(retry, Retry):
        return
    for name in ("wait", "max_wait"):
        value = getattr(retry, name)
        wrong = _wrong_duration(name, value) if value is not None else None
        if wrong:
            yield context.source.problem((*place, name), "E309", *wrong)
