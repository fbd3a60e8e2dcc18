"""A name has a value wherever it is used, and only one.

W421. A `set` in one branch of an `if`, under a `when`, or in a member of `any` gives its name a value
only if it runs. Where it did not, the first step that uses the name fails in the middle of the run.

Passes:

    params: {quick: {type: boolean, default: false}}
    devices: {balance: balance@1}
    steps:
      - set: {patience: "${{ 60 s }}"}
      - if: ${{ params.quick }}
        then: [{set: {patience: "${{ 5 s }}"}}]
      - {do: balance.weigh, with: {patience: "${{ patience }}"}}

Fails:

    params: {quick: {type: boolean, default: false}}
    devices: {balance: balance@1}
    steps:
      - if: ${{ params.quick }}
        then: [{set: {patience: "${{ 5 s }}"}}]
      - {do: balance.weigh, with: {patience: "${{ patience }}"}}

W422. The members of a set run side by side. If two of them give one name a value, the slower one
wins: today this member, tomorrow the other.

Passes:

    devices: {gantry: gantry@1, balance: balance@1}
    steps:
      - parallel:
          - steps: [{do: gantry.home}, {set: {homed: 1}}]
          - steps: [{do: balance.weigh}, {set: {weighed: 2}}]
      - log: ${{ homed }} ${{ weighed }}

Fails:

    devices: {gantry: gantry@1, balance: balance@1}
    steps:
      - parallel:
          - steps: [{do: gantry.home}, {set: {first: gantry}}]
          - steps: [{do: balance.weigh}, {set: {first: balance}}]
      - log: ${{ first }}
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ...schemas import protocol as p
from ...schemas.problem import Problem
from ..language.shape import Place
from ..survey.scope import SetName
from ..survey.spots import StepAt
from .constant import always
from .context import Context

CODES = {
    "W421": "a name that may have no value here",
    "W422": "a name that two members of a set give a value",
}
Given = Mapping[str, frozenset[str]]
"""Names that have a value for certain, each with {""}; others with the conditions under which they have."""
CERTAIN = frozenset({""})


def check(context: Context) -> Iterator[Problem]:
    """Every name that a `set` defines."""
    if not context.whole:
        return
    yield from _unset(context)
    yield from _twice(context)


def _unset(context: Context) -> Iterator[Problem]:
    sets = {name.name for name in context.survey.sets}
    if not sets:
        return
    walk = _Walk()
    walk.steps(context.protocol.steps, ("steps",), {}, frozenset())
    for spot in context.survey.spots:
        if spot.place[0] != "steps" or isinstance(spot.value, Exception):
            continue
        used = spot.value.names & sets - {loop.name for loop in spot.env.loops}
        at = walk.step_of(spot.place) if used else None
        if at is None or spot.inferred()[1]:
            continue
        given, holds = (walk.after if spot.use == "collect" else walk.before)[at]
        if spot.what == "when" and spot.use == "condition":
            holds -= {_condition(spot.raw)}
        lacking = [n for n in used if not given.get(n, frozenset()) & (holds | CERTAIN)]
        visible = spot.env.set_names() if lacking else {}
        for name in sorted(set(lacking) & visible.keys()):
            yield context.source.problem(
                spot.place, "W421", f"{name} may have no value here: {_why(visible[name])}",
                f"set it before, such as `set: {{{name}: null}}`",
            )  # fmt: skip


def _why(sets: Sequence[SetName]) -> str:
    kinds = {level.kind: level.name for one in sets for level in one.levels}
    if "branch" in kinds:
        return f"its `set` is only in the branch `{kinds['branch']}`"
    return "its `set` does not always run"


class _Walk:
    """What has a value before each step, by place, and the conditions that hold there."""

    def __init__(self) -> None:
        self.before: dict[Place, tuple[Given, frozenset[str]]] = {}
        self.after: dict[Place, tuple[Given, frozenset[str]]] = {}

    def step_of(self, place: Place) -> Place | None:
        """The place of the step that something belongs to."""
        ends = range(len(place), 0, -1)
        return next((place[:n] for n in ends if place[:n] in self.before), None)

    def steps(
        self, steps: Sequence[Any], place: Place, given: Given | None, holds: frozenset[str]
    ) -> Given | None:
        """What has a value after these steps; None if nothing comes after them."""
        for index, step in enumerate(steps):
            given = self.step(step, (*place, index), given, holds)
        return given

    def step(
        self, step: p.StepBase, place: Place, given: Given | None, holds: frozenset[str]
    ) -> Given | None:
        """One step, with its condition and its ladder."""
        if given is None:
            return None  # never reached, which is reported elsewhere
        when = _condition(step.when)
        inside = holds | {when} if when else holds
        self.before[place] = (given, inside)
        after = self.kind(step, place, given, inside)
        for index, alternative in enumerate(step.fallback):
            there = (*place, "fallback", index)
            if isinstance(alternative, list):
                other = self.steps(alternative, there, given, inside)
            else:
                other = self.step(alternative, there, given, inside)
                if isinstance(alternative, p.Ask):
                    other = None  # again, or not further
            after = both(after, other)
        for then, keys in p.thens(step):
            if isinstance(then, list):
                held = self.steps(then, (*place, *keys), given, inside)
            else:
                held = self.step(then, (*place, *keys), given, inside)
            after = both(after, held)
        if step.on_error == "continue" and not isinstance(step, p.Set):
            after = both(after, given)
        if when and not always(step.when):
            return under(when, given, after)
        return after

    def kind(
        self, step: p.StepBase, place: Place, given: Given, holds: frozenset[str]
    ) -> Given | None:
        """What a step gives when it succeeds."""
        match step:
            case p.Set():
                return {**given, **dict.fromkeys(step.set, CERTAIN)}
            case p.Fail():
                return None
            case p.Group():
                return self.steps(step.steps, (*place, "steps"), given, holds)
            case p.If():
                yes = _condition(step.if_)
                then = self.steps(step.then, (*place, "then"), given, holds | {yes})
                other = self.steps(step.else_ or [], (*place, "else"), given, holds)
                if always(step.if_):
                    return then
                return under(yes, other, then) if step.else_ is None else both(then, other)
            case p.Parallel() | p.AnyOf():
                return self._set(step, place, given, holds)
            case p.LoopBase():
                inner = self.steps(step.steps, (*place, "steps"), given, holds)
                self.after[place] = (given if inner is None else inner, holds)
                return given
        return given

    def _set(
        self, step: p.Parallel | p.AnyOf, place: Place, given: Given, holds: frozenset[str]
    ) -> Given | None:
        key = step.KIND
        ends = [
            self.step(member, (*place, key, index), given, holds)
            for index, member in enumerate(getattr(step, key))
        ]
        if key == "parallel":
            if any(one is None for one in ends):
                return None
            all_of: dict[str, frozenset[str]] = {}
            for one in ends:
                for name, kept in (one or {}).items():
                    all_of[name] = all_of.get(name, frozenset()) | kept
            return all_of
        found: Given | None = None
        for one in ends:
            found = both(found, one)
        return found


def both(a: Given | None, b: Given | None) -> Given | None:
    """What has a value after either of two ways."""
    if a is None or b is None:
        return b if a is None else a
    return {name: a[name] & b[name] for name in a.keys() & b.keys()}


def under(condition: str, without: Given | None, with_: Given | None) -> Given | None:
    """What has a value after steps that run only under a condition."""
    if without is None or with_ is None:
        return with_ if without is None else without
    return {
        name: without.get(name, frozenset()) | ({condition} if "" in kept else kept)
        for name, kept in with_.items()
    }


def _condition(raw: Any) -> str:
    return "" if raw is None else " ".join(str(raw).split())


def _twice(context: Context) -> Iterator[Problem]:
    """Names that two members of one `parallel` set to something different."""
    first: dict[tuple[Place, str], tuple[int | str, Any, int]] = {}
    loops = {at.place for _, at in context.steps(p.LoopBase)}
    for step, at in context.steps(p.Set):
        for name, raw in step.set.items():
            for depth in range(len(at.place) - 1, 0, -1):
                if at.place[depth] != "parallel":
                    continue
                if _is_own(context, at, name, loops, depth):
                    break
                member, place = at.place[depth + 1], (*at.place, "set", name)
                line = context.source.place(place, key=True)[0]
                known = first.setdefault((at.place[:depth], name), (member, raw, line))
                if known[0] != member and known[1] != raw:
                    message = (
                        f"another member of the set gives {name} a value, too (line {known[2]})"
                    )
                    yield context.source.problem(
                        place, "W422", message, "give each member a name of its own", key=True
                    )


def _is_own(context: Context, at: StepAt, name: str, loops: set[Place], depth: int) -> bool:
    """True if the name belongs to an iteration inside the member."""
    if not any(at.place[:n] in loops for n in range(depth + 2, len(at.place))):
        return False
    around = [level for level in at.env.levels if level.kind == "loop"]
    return not any(
        one.name == name and one.order < at.env.order and around[-1] not in one.levels
        for one in context.survey.sets
        if at.env.visible(one.levels)
    )
