"""The actions of one set start together, so no two of them use the same device.

E402. A device does one thing at a time, unless its contract says that it is `concurrent`. Two
actions of one device in a set would wait for each other, in an arbitrary order.

Passes:

    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - parallel:
          - do: gantry.home
          - do: libs.locate

Fails:

    devices: {gantry: gantry@1}
    steps:
      - parallel:
          - {do: gantry.move_to, with: {x: 10 mm}}
          - {do: gantry.move_to, with: {y: 10 mm}}

E405. The members of a set are actions (`do`), or groups (`steps`) of anything: this makes clear
what starts and ends together.

Passes:

    devices: {gantry: gantry@1, libs: libs_analyzer@1}
    steps:
      - parallel:
          - do: gantry.home
          - steps:
              - wait: 3 s
              - do: libs.locate

Fails:

    devices: {gantry: gantry@1}
    steps:
      - parallel:
          - do: gantry.home
          - wait: 3 s

E406. A background action ends with its iteration or with the enclosing list of steps. A set ends
when all its members have ended, a fallback has to succeed, and `finally` waits for everything:
nothing can run in the background there.

Passes:

    devices: {libs: libs_analyzer@1, gantry: gantry@1}
    steps:
      - {do: libs.locate, mode: background}
      - do: gantry.home

Fails:

    devices: {libs: libs_analyzer@1, gantry: gantry@1}
    steps:
      - parallel:
          - {do: libs.locate, mode: background}
          - do: gantry.home
"""

from collections.abc import Iterator, Sequence

from ...schemas.problem import Problem
from ...schemas.protocol import AnyOf, Do, Group, Parallel, StepBase, Use
from ..language.load import Broken
from ..language.shape import Place
from ..survey.spots import StepAt
from .context import Context
from .within import within

CODES = {
    "E402": "two actions of one device in a set",
    "E405": "a member of a set that is neither an action nor a group",
    "E406": "a background action where it cannot be",
}

TO_DO = {
    "parallel": "make them two steps, one after the other",
    "any": "make the second one a `fallback` of the first",
}
TO_READ = (
    "it does one thing at a time: go in short steps, in a loop that reads after each; "
    "if it can do both at once, its contract says `concurrent: true`"
)
"""Where one of the two only reads: after the other it would tell nothing of what went on meanwhile."""


def check(context: Context) -> Iterator[Problem]:
    """Every set, then every background action."""
    for step, members, at in _sets(context):
        place = (*at.place, step.KIND)
        yield from _members(context, members, place)
        yield from _devices(context, members, place, TO_DO[step.KIND], isinstance(step, Parallel))
    yield from _background(context)


def _sets(context: Context) -> Iterator[tuple[StepBase, Sequence[StepBase], StepAt]]:
    for step, at in context.steps(Parallel):
        yield step, step.parallel, at
    for step, at in context.steps(AnyOf):
        yield step, step.any, at


def _members(context: Context, members: Sequence[StepBase], place: Place) -> Iterator[Problem]:
    for index, member in enumerate(members):
        if not isinstance(member, Do | Group | Broken):
            kind = member.KIND
            message = f"a member of a set is an action (`do`) or a group (`steps`), not `{kind}`"
            hint = f"make it a group: `steps: [{{{kind}: ...}}]`, or put it before the set"
            yield context.source.problem((*place, index, kind), "E405", message, hint, key=True)


def _devices(
    context: Context, members: Sequence[StepBase], place: Place, hint: str, turns: bool
) -> Iterator[Problem]:
    """`turns`: groups that use one device take turns on it."""
    taken: dict[str, tuple[int, str, bool]] = {}
    for index, member in enumerate(members):
        for device, label, reads, at in _asked(context, member, (*place, index)):
            first = taken.setdefault(device, (index, label, reads))
            groups = isinstance(members[first[0]], Group) or isinstance(member, Group)
            if first[0] == index or (turns and groups):
                continue
            what = f"{first[1]} and {label}" if first[1] != label else f"two members ({label})"
            message = f"{what} of one set use the same device, {device}"
            yield context.source.problem(
                at, "E402", message, TO_READ if reads != first[2] else hint
            )
            break  # one problem per member is enough


def _asked(
    context: Context, member: StepBase, place: Place
) -> Iterator[tuple[str, str, bool, Place]]:
    """The devices used by a member that do one thing at a time, and whether it only reads them."""
    for step, at in within(member, place, fallbacks=False):
        if isinstance(step, Do):
            role = step.do.partition(".")[0]
            bound, found = context.roles.get(role), context.survey.action(step)
            if bound is None or not bound.contract.concurrent:
                reads = found is not None and found[1].effect == "pure"
                yield (bound.device if bound else role), step.do, reads, (*at, "do")
        elif isinstance(step, Use) and at in context.survey.used:
            for bound in context.survey.used[at].roles.values():
                if not bound.contract.concurrent:
                    yield bound.device, step.use, False, (*at, "use")


def _background(context: Context) -> Iterator[Problem]:
    for step, at in context.steps(StepBase):
        if not isinstance(step, Do | Group) or step.mode is None:
            continue
        where = _no_place_for_background(at)
        if where:
            message = f"a background action cannot be in {where}"
            yield context.source.problem(
                (*at.place, "mode"), "E406", message, "leave out `mode: background`"
            )


def _no_place_for_background(at: StepAt) -> str:
    kinds = {level.kind for level in at.env.levels}
    if "member" in kinds:
        return "a set: it ends when all its members have ended"
    if "fallback" in kinds:
        return "a fallback: the step succeeds only when the fallback has"
    return f"`{at.place[0]}`" if at.place[0] in ("finally", "on_resume") else ""
