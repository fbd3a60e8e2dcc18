"""Everything an expression names exists, has a value at that point, and has the named field.

`params.NAME` is a parameter; `steps.ID.FIELD` is a field of the result of a step that has run
before. What an action returns is in its contract; a loop's result has total, succeeded, failed
and skipped; `confirm` and `ask` return choice.

E301. A field that is not in the result would be null in every row of the table, and this would not
be noticed before the end.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shotid }}", file: a.csv}}
    finally: [{do: libs.disarm}]

E302. A name must come from an enclosing loop or a `set`, or be `params`, `steps`, `run`, or, in a
fallback, `error`. Text needs quotes: `'Li'`. In an optimizer's constraint it is one of its `space`.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {depth: [1 mm, 2 mm]}
        steps:
          - {do: gantry.move_to, with: {z: "${{ depth }}"}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {depth: [1 mm, 2 mm]}
        steps:
          - {do: gantry.move_to, with: {z: "${{ dept }}"}}

E303. A parameter must be declared under `params:` before anything can use it.

Passes:

    params: {pitch: {type: quantity, unit: mm, default: 2 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: "${{ params.pitch }}"}}

Fails:

    params: {pitch: {type: quantity, unit: mm, default: 2 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {x: "${{ params.pich }}"}}

E304. `steps.ID` is the result of the step with that `id:`; a step without an id cannot be named.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure}
      - {do: libs.export, with: {shot: "${{ steps.shot.shot_id }}", file: a.csv}}
    finally: [{do: libs.disarm}]

E305. A result can be used only after its step, not beside it in the same set or in the other
branch of an `if`: there is no value yet.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}
      - {id: shoot, do: libs.measure}
    finally: [{do: libs.disarm}]

E306. Names inside a loop are known only inside it: outside, it would be unclear which iteration is
meant. `collect` keeps values of every iteration. Names in a fallback are known only within it, and
names in `on_resume` or `finally` only within that section.

Passes:

    devices: {balance: balance@1}
    steps:
      - id: weights
        foreach: {vial: [A, B]}
        steps:
          - {id: weight, do: balance.weigh}
        collect: {mass: "${{ steps.weight.mass }}"}
      - log: ${{ steps.weights.succeeded }} vials were weighed

Fails:

    devices: {balance: balance@1}
    steps:
      - id: weights
        foreach: {vial: [A, B]}
        steps:
          - {id: weight, do: balance.weigh}
      - log: The vial weighs ${{ steps.weight.mass }}

E310. A background action may still be running when the next step begins. Its result is known
only where the run has waited for it: in `collect` and in `outputs`.

Passes:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh, mode: background}
    outputs: {mass: "${{ steps.weight.mass }}"}

Fails:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh, mode: background}
      - log: It weighs ${{ steps.weight.mass }}

E311. In a `fallback`, `error` says why the step failed: name, message, step, device and action.
Anywhere else nothing has failed.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        fallback:
          - {ask: "No zero: ${{ error.message }}", choices: [repeat, stop]}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
      - log: ${{ error.message }}

E313. `csv('samples.csv')` reads a table from the folder of the protocol. Its first line names the
columns; `x (mm)` is a column with a unit. The table is read before the run, so that a cell that is
not a number is found now and not when the run reaches its row.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {sample: "${{ csv('samples.csv') }}"}
        key: ${{ sample.name }}
        steps:
          - {do: gantry.move_to, with: {x: "${{ sample.x }}"}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {sample: "${{ csv('sample.csv') }}"}
        key: ${{ sample.name }}
        steps:
          - {do: gantry.move_to, with: {x: "${{ sample.x }}"}}

Beside it, samples.csv:

    name,x (mm)
    SPD-07,12.5
    SPD-08,30
"""

import ast
import re
from collections.abc import Iterator

from ...schemas.problem import Problem
from ..language.infer import Fault
from ..language.suggest import did_you_mean, listed
from ..survey.spots import Spot, StepAt
from .context import Context

CODES = {
    "E301": "a field that the result or value does not have",
    "E302": "a name that does not exist",
    "E303": "a parameter that does not exist",
    "E304": "a step id that does not exist",
    "E305": "a step that has not run yet at this point",
    "E306": "a name that is known only inside a loop, a fallback or another phase",
    "E310": "the result of a background action where it is not known",
    "E311": "`error` outside a fallback",
    "E313": "a table that cannot be read, or does not fit",
}


def check(context: Context) -> Iterator[Problem]:
    """Every expression, by the names in it."""
    for spot in context.survey.spots:
        faults = [fault for fault in spot.inferred()[1] if _is_news(context, fault)]
        if faults and not context.whole and _ill_named(context, spot):
            continue
        dashed = _dashed(context, spot) if len(faults) > 1 else None
        for fault in [dashed] if dashed else faults:
            yield context.source.problem(spot.place, fault.code, fault.message, fault.hint)
    for _, at, _, action in context.survey.actions():
        for name, schema in action.param_schemas().items():
            of = schema.get("items", {}).get("computed_from")
            if of and name in at.arguments and of in at.arguments:
                yield from _computed_from(context, at, name, of)


def _computed_from(context: Context, at: StepAt, name: str, of: str) -> Iterator[Problem]:
    """Texts that a device computes, such as an optimizer's constraints, from the keys of another argument."""
    texts, known = at.arguments[name].raw, at.arguments[of].raw
    if not isinstance(texts, list) or not isinstance(known, dict):
        return
    for index, text in enumerate(texts):
        if not isinstance(text, str) or "${{" in text:
            continue
        place = (*at.place, "with", name, index)
        try:
            tree = ast.parse(text.strip(), mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            yield context.source.problem(place, "E300", f"{text!r} cannot be computed")
            continue
        names = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name)]
        for unknown in dict.fromkeys(one for one in names if one not in known):
            yield context.source.problem(
                place, "E302", f"{of} has no {unknown}{did_you_mean(unknown, known)}",
                f"it has {listed(known)}",
            )  # fmt: skip


def _is_news(context: Context, fault: Fault) -> bool:
    """False for another family's fault, and for a name whose misspelling, or its key's, is reported."""
    if context.whole or fault.code not in ("E303", "E304", "E305"):
        return fault.code in CODES
    if fault.code == "E303":
        return bool(context.survey.params)
    if fault.code == "E305":
        return bool(fault.step)
    return fault.step not in {re.sub(r"\W", "_", known) for known in context.survey.raw_names}


def _ill_named(context: Context, spot: Spot) -> bool:
    """Whether it uses a name that is reported where it was given, such as `first-weight`."""
    assert not isinstance(spot.value, Exception)
    names = [*context.survey.raw_names, *context.survey.params]
    ill = [name for name in names if not name.isidentifier()]
    return any(name in one.text for name in ill for one in spot.value.expressions())


DASHED = re.compile(r"params\.(\w+(?:-[A-Za-z_]\w*)+)")


def _dashed(context: Context, spot: Spot) -> Fault | None:
    """`params.z-safe`, which is a difference, where `params.z_safe` is meant."""
    assert not isinstance(spot.value, Exception)
    for one in spot.value.expressions():
        for match in DASHED.finditer(one.text):
            meant = match[1].replace("-", "_")
            if meant in context.survey.params:
                message = f"{match[0]} is a difference; did you mean params.{meant}?"
                return Fault("E303", message, "a dash in an expression is a minus")
    return None
