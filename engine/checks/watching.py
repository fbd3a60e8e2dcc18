"""A watch can look while the steps run.

E410. What `do` in a `watch` does is done again and again, so its action must be `pure`, and `every` says
how often. `id` names what it has read.

Passes:

    devices: {balance: balance@1, gantry: gantry@1}
    steps:
      - watch:
          - {every: 10 s, id: load, do: balance.weigh, when: "${{ steps.load.mass > 9 g }}", then: {fail: no}}
        steps: [{do: gantry.home}]

Fails:

    devices: {balance: balance@1, gantry: gantry@1}
    steps:
      - watch:
          - {id: load, do: balance.weigh, when: "${{ steps.load.mass > 50 g }}", then: {fail: too heavy}}
        steps: [{do: gantry.home}]

E411. A device that does one thing at a time cannot be read while a watched step uses it: the watch would
wait behind the step, and know nothing. Its status is told all the same; and an action that its
contract calls `meanwhile` is done at once.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - watch: [{when: "${{ status.gantry.state == 'alarm' }}", then: {fail: alarm}}]
        steps: [{do: gantry.home}]

Fails:

    devices: {balance: balance@1}
    steps:
      - watch:
          - {every: 10 s, id: load, do: balance.weigh, when: "${{ steps.load.mass > 5 g }}", then: {fail: no}}
        steps: [{do: balance.tare}]
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do, Group, StepBase, Use, Watch
from ..language.shape import Place
from .context import Context
from .within import within

CODES = {
    "E410": "a watch that cannot look",
    "E411": "a watch that reads a device while a step uses it",
}


def check(context: Context) -> Iterator[Problem]:
    """Every watch of every group."""
    for step, at in context.steps(Group):
        for index, watch in enumerate(step.watch):
            place = (*at.place, "watch", index)
            yield from _look(context, watch, place)
            yield from _beside(context, step, watch, at.place, place)


def _look(context: Context, watch: Watch, place: Place) -> Iterator[Problem]:
    if watch.do is None:
        for key in ("id", "with"):
            if watch.id if key == "id" else watch.with_:
                message = f"`{key}` belongs to `do`, and this watch has none"
                yield context.source.problem((*place, key), "E410", message, key=True)
        return
    found = context.survey.action(Do.model_construct(do=watch.do))
    if found is not None and found[1].effect != "pure":
        message = (
            f"{watch.do} is {found[1].effect}; a watch does it again and again, so it must be pure"
        )
        hint = "use an action that only reads, or `status.ROLE.FIELD`"
        yield context.source.problem((*place, "do"), "E410", message, hint)
    if watch.every is None:
        message = f"how often is {watch.do} to be done?"
        yield context.source.problem((*place, "do"), "E410", message, "give it `every: 10 s`")


def _beside(
    context: Context, step: Group, watch: Watch, at: Place, place: Place
) -> Iterator[Problem]:
    found = context.survey.action(Do.model_construct(do=watch.do)) if watch.do is not None else None
    if found is None or found[1].meanwhile or found[0].contract.concurrent:
        return
    for inner, there in within(step, at):
        if there[: len(at) + 1] != (*at, "steps"):
            continue
        if found[0].device in _devices(context, inner, there):
            message = f"{watch.do} would wait until the steps no longer use {found[0].device}"
            hint = "watch its status, or an action that its contract calls `meanwhile`"
            yield context.source.problem((*place, "do"), "E411", message, hint)
            return


def _devices(context: Context, step: StepBase, place: Place) -> set[str]:
    if isinstance(step, Do):
        role = context.roles.get(step.do.partition(".")[0])
        return {role.device} if role is not None else set()
    used = context.survey.used.get(place) if isinstance(step, Use) else None
    return {role.device for role in used.roles.values()} if used is not None else set()
