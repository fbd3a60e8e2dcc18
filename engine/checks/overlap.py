"""What runs beside other things keeps its devices and its names apart.

E412. `reserve` keeps devices for one group. It takes all of them at once, and what is in it asks for no
device that another group reserves: then nothing can wait for ever. So an inner `reserve` may name only
devices of the outer one, and a device that some other group reserves must be named where it is used.

Passes:

    devices: {gantry: gantry@1, balance: balance@1}
    steps:
      - foreach: {x: [1 mm, 2 mm, 3 mm]}
        at_once: 2
        steps:
          - reserve: [gantry, balance]
            steps: [{do: gantry.move_to, with: {x: "${{ x }}"}}, {do: balance.weigh}]

Fails:

    devices: {gantry: gantry@1, balance: balance@1}
    steps:
      - reserve: [gantry]
        steps:
          - do: gantry.home
          - {reserve: [balance], steps: [{do: balance.weigh}]}

E413. Iterations that run at once, and a group in the background, have names of their own: which of
them were the last to set a name from outside would be chance.

Passes:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B]}
        at_once: 2
        steps: [{id: w, do: balance.weigh}, {set: {mass: "${{ steps.w.mass }}"}}]
        collect: {mass: "${{ mass }}"}

Fails:

    devices: {balance: balance@1}
    steps:
      - set: {mass: 0 g}
      - foreach: {vial: [A, B]}
        at_once: 2
        steps: [{id: w, do: balance.weigh}, {set: {mass: "${{ steps.w.mass }}"}}]
    outputs: {mass: "${{ mass }}"}

W424. While a person is asked, everybody else waits for the devices that are reserved around the question.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - confirm: Is the enclosure closed?
      - {reserve: [gantry], steps: [{do: gantry.home}]}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - reserve: [gantry]
        steps: [{confirm: Is the enclosure closed?}, {do: gantry.home}]

W425. Between two actions of one iteration, another one of those that run at once may use the same device.
What the first has set (a place, a range) is then not there for the second.

Passes:

    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - foreach: {x: [1 mm, 2 mm]}
        at_once: 2
        steps:
          - reserve: [gantry, libs]
            steps: [{do: gantry.move_to, with: {x: "${{ x }}"}}, {do: libs.measure, timeout: 60 s}]
    finally: [{do: libs.disarm, on_error: continue}]

Fails:

    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - foreach: {x: [1 mm, 2 mm]}
        at_once: 2
        steps: [{do: gantry.move_to, with: {x: "${{ x }}"}}, {do: libs.measure, timeout: 60 s}]
    finally: [{do: libs.disarm, on_error: continue}]

W427. While a loop without an end of its own keeps devices reserved, what runs beside it waits for them, for
ever if the loop's condition stays true.

Passes:

    devices: {furnace: furnace@1}
    steps:
      - foreach: {vial: [A, B]}
        at_once: 2
        steps:
          - while: ${{ status.furnace.temperature > 40 degC }}
            steps: [{wait: 1 min}]
          - {reserve: [furnace], steps: [{do: furnace.off}]}

Fails:

    devices: {furnace: furnace@1}
    steps:
      - foreach: {vial: [A, B]}
        at_once: 2
        steps:
          - reserve: [furnace]
            steps:
              - while: ${{ status.furnace.temperature > 40 degC }}
                steps: [{wait: 1 min}]
              - {do: furnace.off}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import (
    AnyOf,
    Ask,
    Confirm,
    Do,
    Foreach,
    Group,
    Parallel,
    Set,
    StepBase,
    Use,
    While,
)
from ..language.shape import Place
from ..language.suggest import did_you_mean
from ..survey.spots import StepAt
from .constant import fixed_count
from .context import Context
from .within import within

CODES = {
    "E412": "a reservation that others could wait for, for ever",
    "E413": "a name from outside that is set by what runs beside others",
    "W424": "a question while devices are reserved",
    "W425": "a device that others use in between",
    "W427": "devices for which others could wait for ever",
}


def check(context: Context) -> Iterator[Problem]:
    """Every reservation, and everything that runs beside other things."""
    reserved = {
        context.roles[role].device
        for step, _ in context.steps(Group)
        for role in step.reserve
        if role in context.roles
    }
    for step, at in context.steps(Group):
        if step.reserve:
            yield from _reservation(context, step, at, reserved)
            yield from _kept_for_ever(context, step, at)
        if step.mode is not None:
            yield from _names(context, step, at)
    for step, at in context.steps(Foreach):
        if step.at_once is not None and fixed_count(step.at_once) != 1:
            yield from _names(context, step, at)
            yield from _between(context, step, at)


def _reservation(
    context: Context, step: Group, at: StepAt, reserved: set[str]
) -> Iterator[Problem]:
    own, roles = set(), step.reserve
    for index, role in enumerate(roles):
        place = (*at.place, "reserve", index)
        if role in roles[:index]:
            yield context.source.problem(
                place, "E412", f"{role} is reserved twice", "keep one of the two"
            )
        elif role in context.roles:
            own.add(context.roles[role].device)
        elif role not in context.protocol.devices:
            guess = did_you_mean(role, context.protocol.devices)
            hint = f"roles: {', '.join(context.protocol.devices)}"
            yield context.source.problem(place, "E412", f"there is no role {role}{guess}", hint)
    if any(role not in context.roles for role in roles):
        return  # what it lacks may be what is misspelt
    for inner, place in within(step, at.place):
        if isinstance(inner, Confirm | Ask):
            message = f"while a person is asked, nobody else can use {', '.join(step.reserve)}"
            yield context.source.problem((*place, inner.KIND), "W424", message, "ask before")
        key = "do" if isinstance(inner, Do) else "use" if isinstance(inner, Use) else "reserve"
        for device in sorted(_used(context, inner, place) - own):
            if inner is step or (device not in reserved and key != "reserve"):
                continue
            message = f"{device} is used here, and not reserved by the group around it"
            hint = f"reserve: [{', '.join([*step.reserve, device])}]"
            yield context.source.problem((*place, key), "E412", message, hint)


def _kept_for_ever(context: Context, step: Group, at: StepAt) -> Iterator[Problem]:
    """Loops without an end of their own in a reservation that others could wait for."""
    if not _runs_beside_others(context, at.place):
        return
    for inner, place in within(step, at.place):
        if isinstance(inner, While) and inner.max is None:
            names = ", ".join(step.reserve)
            message = f"what runs beside this waits for {names} as long as this loop goes on"
            hint = "give the loop a `max`, or wait before the devices are reserved"
            yield context.source.problem((*place, "while"), "W427", message, hint)


def _runs_beside_others(context: Context, place: Place) -> bool:
    """Whether it is in a set, in iterations at once, in the background, or beside something there."""
    for step, other in context.steps(StepBase):
        if isinstance(step, Group) and step.mode is not None:
            return True
        if place[: len(other.place)] == other.place and (
            isinstance(step, Parallel | AnyOf)
            or (
                isinstance(step, Foreach)
                and step.at_once is not None
                and fixed_count(step.at_once) != 1
            )
        ):
            return True
    return False


def _used(context: Context, step: StepBase, place: Place) -> set[str]:
    if isinstance(step, Do):
        role = context.roles.get(step.do.partition(".")[0])
        return {role.device} if role is not None and not role.contract.concurrent else set()
    if isinstance(step, Group):
        return {context.roles[r].device for r in step.reserve if r in context.roles}
    used = context.survey.used.get(place) if isinstance(step, Use) else None
    roles = used.roles.values() if used is not None else ()
    return {role.device for role in roles if not role.contract.concurrent}


def _names(context: Context, step: StepBase, at: StepAt) -> Iterator[Problem]:
    """Names that were there before what runs beside others, and are set in it."""
    outer = {
        one.name for one in context.survey.sets
        if one.order < at.env.order and at.env.visible(one.levels)
    }  # fmt: skip
    for inner, place in within(step, at.place):
        if not isinstance(inner, Set):
            continue
        for name in inner.set:
            if name in outer:
                message = f"{name} is a name from outside, and others run beside this step"
                hint = "give it another name here; `collect` keeps a value of each iteration"
                yield context.source.problem((*place, "set", name), "E413", message, hint, key=True)


def _between(context: Context, step: Foreach, at: StepAt) -> Iterator[Problem]:
    """Two actions of one device that no reservation keeps together, or of what an action was set for."""
    seen: dict[str, str] = {}
    moved = ""
    for inner, place in within(step, at.place, fallbacks=False):
        if not isinstance(inner, Do) or _is_reserved(context, place, at.place):
            continue
        found = context.survey.action(inner)
        if found is None or found[0].contract.concurrent:
            continue
        role, action = found
        before = seen.get(role.device) or (moved if action.effect == "once" else "")
        if before:
            message = f"between {before} and {inner.do}, another iteration may use what they use"
            hint = "keep both in one group with `reserve: [...]`"
            yield context.source.problem((*place, "do"), "W425", message, hint)
            return
        if action.effect == "idempotent":
            seen[role.device] = moved = inner.do


def _is_reserved(context: Context, place: Place, loop: Place) -> bool:
    return any(
        isinstance(at.step, Group) and at.step.reserve and place[: len(at.place)] == at.place
        for at in context.survey.steps
        if len(at.place) > len(loop)
    )
