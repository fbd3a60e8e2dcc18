"""Everything declared is used; an unused name often means that another one is misspelt.

W407. Setting a parameter that nothing uses has no effect.

Passes:

    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: "${{ params.depth }}"}}

Fails:

    params: {depth: {type: quantity, unit: mm, default: 1 mm}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.move_to, with: {z: 1 mm}}

W408. Even an unused role needs a device: the run would wait for a device that it never uses.
One whose status a condition looks at is used.

Passes:

    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - {do: gantry.move_to, with: {z: 1 mm}, when: "${{ status.libs.argon > 1 bar }}"}

Fails:

    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - {do: gantry.move_to, with: {z: 1 mm}}

W419. A name that a `set` defines and nothing uses was often meant for a condition or a column that
still uses another name.

Passes:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {empty: "${{ steps.weight.mass }}"}
      - log: The empty vial weighs ${{ empty }}

Fails:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {empty: "${{ steps.weight.mass }}"}
      - log: The empty vial weighs ${{ steps.weight.mass }}
"""

import re
from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do, Group, Set, Use, watches
from ..language.expression import told_roles
from ..language.fold import needs
from ..language.shape import Place
from ..survey.scope import RESERVED
from .context import Context

CODES = {
    "W407": "a parameter that nothing uses",
    "W408": "a role that nothing uses",
    "W419": "a name that `set` defines and nothing uses",
}


def check(context: Context) -> Iterator[Problem]:
    """Parameters, roles, names; silent where a part of the file could not be read."""
    if not context.whole:
        return
    yield from _roles(context)
    used = _names(context)
    if used is None:
        return
    # Where an expression uses an unknown name, that may be a misspelling of the unused one.
    faults = {fault.code for spot in context.survey.spots for fault in spot.inferred()[1]}
    for name in context.protocol.params:
        if name not in used[0] and not faults & {"E302", "E303"}:
            yield _warning(context, ("params", name), "W407", f"nothing uses the parameter {name}")
    for step, at in context.steps(Set):
        for name in step.set:
            if name not in {*used[1], *RESERVED} and "E302" not in faults:
                message = f"nothing uses the name {name} that this `set` defines"
                yield _warning(context, (*at.place, "set", name), "W419", message)


def _warning(context: Context, place: Place, code: str, message: str) -> Problem:
    return context.source.problem(place, code, message, key=True)


def _names(context: Context) -> tuple[set[str], set[str]] | None:
    """The parameters and the other names that expressions use; None where that is not known."""
    params: set[str] = set()
    names: set[str] = set()
    if any("${{" in step.use for step, _ in context.steps(Use)):
        return None
    for spot in context.survey.spots:
        if isinstance(spot.value, Exception):
            return None
        if spot.use == "condition" and isinstance(spot.raw, str) and "${{" not in spot.raw:
            words = set(
                re.findall(r"\w+", spot.raw)
            )  # not an expression, which is already reported
            params, names = params | words, names | words
        for expression in spot.value.expressions():
            wanted = needs(expression)
            if wanted is None:
                return None
            params |= wanted[0]
            names |= wanted[1]
    return params, names


def _roles(context: Context) -> Iterator[Problem]:
    declared = context.source.names("devices")
    roles = {step.do.partition(".")[0] for step, _ in context.steps(Do)}
    if not roles <= set(declared):
        return  # one is misspelt, which is already reported
    for step, at in context.steps(Use):
        used = context.survey.used.get(at.place)
        if used is None:
            return  # what it needs is not known
        roles |= {step.devices.get(its, its) for its in used.protocol.devices}
    roles |= _watched(context)
    for name in context.protocol.devices:
        if name not in roles:
            yield _warning(context, ("devices", name), "W408", f"no step uses the role {name}")


def _watched(context: Context) -> set[str]:
    """The roles whose status an expression looks at, or that a watch reads."""
    found = {watch.do for group, _ in context.steps(Group) for watch in watches(group) if watch.do}
    roles = {do.partition(".")[0] for do in found}
    for spot in context.survey.spots:
        if isinstance(spot.value, Exception):
            return set(context.protocol.devices)
        for expression in spot.value.expressions():
            roles |= told_roles(expression, context.protocol.devices)
    return roles
