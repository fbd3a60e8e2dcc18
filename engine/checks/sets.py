"""The actions of one set start together, so no two of them ask the same device.

A device does one thing at a time, unless its contract says that it is `concurrent`. The members
of a set are actions (`do`) or groups (`steps`); none of them is in the background, since a set
ends when all have ended.

Passes:

    labrun: 1
    name: sets
    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - parallel:
          - do: gantry.home
          - do: libs.locate

Fails (E402):

    labrun: 1
    name: sets
    devices: {gantry: gantry@1}
    steps:
      - parallel:
          - do: gantry.home
          - do: gantry.halt
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do, Group, Parallel
from ..context import Context
from ..language.load import Broken
from ..language.spots import StepAt

CODES = {
    "E402": "two actions of one device in a set",
    "E405": "a member of a set that is no action and no group",
    "E406": "a background action where it cannot be",
}


def check(context: Context) -> Iterator[Problem]:
    """Every set, then every background action."""
    for step, at in context.steps(Parallel):
        yield from _members(context, step, at)
        yield from _devices(context, at)
    yield from _background(context)


def _members(context: Context, step: Parallel, at: StepAt) -> Iterator[Problem]:
    for index, member in enumerate(step.parallel):
        if not isinstance(member, Do | Group | Broken):
            message = (
                f"a member of a set is an action (`do`) or a group (`steps`), not `{member.KIND}`"
            )
            place = (*at.place, "parallel", index)
            yield context.source.problem(
                (*place, member.KIND), "E405", message, "put it before or after the set", key=True
            )


def _devices(context: Context, at: StepAt) -> Iterator[Problem]:
    start = (*at.place, "parallel")
    taken: dict[str, tuple[int | str, str]] = {}
    for step, inner in context.steps(Do):
        if inner.place[: len(start)] != start or _in_fallback(inner, start):
            continue
        member = inner.place[len(start)]
        role = step.do.partition(".")[0]
        bound = context.roles.get(role)
        if bound is not None and bound.contract.concurrent:
            continue
        device = bound.device if bound is not None else role
        first = taken.setdefault(device, (member, step.do))
        if first[0] != member:
            message = f"{first[1]} and {step.do} of one set ask the same device, {device}"
            hint = "make two steps of them, one after the other"
            yield context.source.problem((*inner.place, "do"), "E402", message, hint)


def _in_fallback(at: StepAt, start: tuple[str | int, ...]) -> bool:
    return "fallback" in at.place[len(start) :]


def _background(context: Context) -> Iterator[Problem]:
    for step, at in context.steps(Do):
        if step.mode is None:
            continue
        where = None
        if any(level.kind == "member" for level in at.env.levels):
            where = "a set: it ends when all its members have ended"
        elif any(level.kind == "fallback" for level in at.env.levels):
            where = "a fallback: it has to succeed before the step has"
        elif at.place[0] in ("finally", "on_resume"):
            where = f"`{at.place[0]}`"
        if where:
            message = f"a background action cannot be in {where}"
            yield context.source.problem(
                (*at.place, "mode"), "E406", message, "leave out `mode: background`"
            )
