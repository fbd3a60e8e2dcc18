"""How often each step of a protocol runs: if nothing fails, and with every retry and fallback."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ...schemas import protocol as p
from ..language.shape import Place
from .forecast import Outlook

MOST_TURNS = 5000
"""If the body of a loop depends on its items, at most this many of them are examined one by one."""


@dataclass(frozen=True, slots=True)
class Times:
    """How often something happens: at least, at most if nothing fails, at most in the worst case.

    None if only the run can tell.
    """

    least: int = 1
    most: int | None = 1
    worst: int | None = 1

    def by(self, least: int | None, most: int | None) -> "Times":
        """Each time this often; None if only the run can tell."""
        return Times(
            self.least * (least or 0), _product(self.most, most), _product(self.worst, most)
        )

    def tried(self, attempts: int) -> "Times":
        """Each time up to this many attempts, as long as it fails."""
        return Times(self.least, self.most, _product(self.worst, attempts))

    def perhaps(self) -> "Times":
        """The same, or not at all."""
        return Times(0, self.most, self.worst)

    def on_failure(self) -> "Times":
        """Never, unless something fails."""
        return Times(0, 0, self.worst)

    def plus(self, other: "Times") -> "Times":
        """Both together."""
        return Times(
            self.least + other.least, _sum(self.most, other.most), _sum(self.worst, other.worst)
        )

    def either(self, other: "Times") -> "Times":
        """One of the two; it is not known which."""
        return Times(
            min(self.least, other.least),
            _greater(self.most, other.most),
            _greater(self.worst, other.worst),
        )


ONCE, NEVER = Times(), Times(0, 0, 0)


def _product(a: int | None, b: int | None) -> int | None:
    if a == 0 or b == 0:
        return 0
    return None if a is None or b is None else a * b


def _sum(a: int | None, b: int | None) -> int | None:
    return None if a is None or b is None else a + b


def _greater(a: int | None, b: int | None) -> int | None:
    return None if a is None or b is None else max(a, b)


@dataclass(slots=True)
class RunCounts:
    """The result of a walk over steps: each step's times by its place, and all actions.

    `open` says what is not known: `6 for each sample`; `asks` where a person may have a step
    repeated as often as they like.
    """

    times: dict[Place, Times] = field(default_factory=dict)
    actions: Times = NEVER
    open: list[str] = field(default_factory=list)
    asks: bool = False
    turns: int = 0


def count_runs(view: Outlook, steps: Sequence[Any], place: Place) -> RunCounts:
    """How often the steps of a list, and all in them, run when the list runs once."""
    found = RunCounts()
    Count(found).sequence(view, steps, place, ONCE)
    return found


class Count:
    """Walks as a run would, counting how often each step runs."""

    def __init__(self, found: RunCounts) -> None:
        self.found = found

    def sequence(self, view: Outlook, steps: Sequence[Any], place: Place, times: Times) -> None:
        """Steps in sequence."""
        for before, step, here in view.along(steps, place):
            self.step(before, step, here, times)

    def step(self, view: Outlook, step: p.StepBase, place: Place, times: Times) -> None:
        """One step with everything that it states around its kind."""
        if step.when is not None:
            truth = view.truth(step.when, (*place, "when"))
            times = NEVER if truth is False else times if truth else times.perhaps()
        tried = times.tried(attempts(step, view.protocol.defaults))
        key = (*view.within, *place)
        self.found.times[key] = self.found.times.get(key, NEVER).plus(tried)
        self._kind(view, step, place, tried)
        for index, alternative in enumerate(step.fallback):
            at, later = (*place, "fallback", index), times.on_failure()
            if isinstance(alternative, list):
                self.sequence(view, alternative, at, later)
            else:
                self.found.asks |= (
                    isinstance(alternative, p.Ask) and "repeat" in alternative.choices
                )
                self.step(view, alternative, at, later)
        for then, keys in p.thens(step):
            steps = then if isinstance(then, list) else [then]
            for index, one in enumerate(steps):
                at = (*place, *keys, *([index] if isinstance(then, list) else []))
                self.step(view, one, at, times.on_failure())

    def _kind(self, view: Outlook, step: p.StepBase, place: Place, times: Times) -> None:
        if isinstance(step, p.Do):
            self.found.actions = self.found.actions.plus(times)
        elif isinstance(step, p.Foreach):
            self._foreach(view, step, place, times)
        elif isinstance(step, p.Repeat):
            turns = view.number(step.repeat, (*place, "repeat"))
            self._loop(view, step, place, times, turns, turns)
        elif isinstance(step, p.While):
            most = view.number(step.max, (*place, "max")) if step.max is not None else None
            self._loop(view, step, place, times, 0, most)
        elif isinstance(step, p.If):
            self._if(view, step, place, times)
        elif isinstance(step, p.Use):
            self._use(view, step, place, times)
        else:
            for key, steps in p.inner_lists(step):
                self._members(view, step, steps, (*place, key), times)

    def _members(
        self, view: Outlook, step: p.StepBase, steps: Sequence[Any], place: Place, times: Times
    ) -> None:
        """A group, or the members of a set, which all start."""
        if isinstance(step, p.Group):
            self.sequence(view, steps, place, times)
            return
        for index, member in enumerate(steps):
            # Of the members of `any`, one that is a single action certainly starts; the rest may not.
            sure = isinstance(step, p.Parallel) or isinstance(member, p.Do)
            self.step(view, member, (*place, index), times if sure else times.perhaps())

    def _if(self, view: Outlook, step: p.If, place: Place, times: Times) -> None:
        truth = view.truth(step.if_, (*place, "if"))
        branches = []
        for key, steps, runs in (("then", step.then, True), ("else", step.else_ or [], False)):
            branch = RunCounts(turns=self.found.turns)
            part = times if truth in (None, runs) else NEVER
            Count(branch).sequence(view, steps, (*place, key), part)
            self._add(branch, perhaps=truth is None)
            branches.append(branch.actions)
        then, other = branches
        both = then.plus(other) if truth is not None else then.either(other)
        self.found.actions = self.found.actions.plus(both)

    def _add(self, branch: RunCounts, *, perhaps: bool) -> None:
        """The counts of a branch, except its actions; nothing in it is certain if it is `perhaps`."""
        for key, times in branch.times.items():
            known = self.found.times.get(key, NEVER)
            self.found.times[key] = known.plus(times.perhaps() if perhaps else times)
        self.found.open += branch.open
        self.found.asks |= branch.asks
        self.found.turns = branch.turns

    def _use(self, view: Outlook, step: p.Use, place: Place, times: Times) -> None:
        other = view.used(step, place)
        if other is not None:
            for section, steps in other.lists:
                self.sequence(other, steps, (section,), times)

    # --- loops

    def _foreach(self, view: Outlook, step: p.Foreach, place: Place, times: Times) -> None:
        name = next(iter(step.foreach))
        items = view.items(step, place)
        inside = view.forgetting(step.steps)
        if items is None:
            self._open(inside, step, place, times, name)
        elif self._differs(inside, step, place, len(items)):
            for item in items:
                self.sequence(inside.bound(**{name: item}), step.steps, (*place, "steps"), times)
        else:
            self._loop(view, step, place, times, len(items), len(items))

    def _loop(
        self, view: Outlook, step: p.LoopBase, place: Place, times: Times,
        least: int | None, most: int | None,
    ) -> None:  # fmt: skip
        """The same steps a number of times, each time the same."""
        inside = view.forgetting(step.steps)
        if most is None:
            self._open(inside, step, place, times, "turn")
        else:
            self.sequence(inside, step.steps, (*place, "steps"), times.by(least, most))

    def _open(self, view: Outlook, step: p.LoopBase, place: Place, times: Times, name: str) -> None:
        """A loop whose number of turns is not known yet."""
        each = RunCounts()
        Count(each).sequence(view, step.steps, (*place, "steps"), ONCE)
        before = self.found.actions
        for at in each.times:
            self.found.times[at] = times.by(0, None)
        if each.actions.most or each.open:
            loop = f" of {step.id!r}" if step.id else ""
            self.found.open.append(f"{number_of(each)} for each {name}{loop}")
            before = Times(before.least, before.most, None)
        self.found.actions = before
        self.found.asks |= each.asks

    def _differs(self, view: Outlook, step: p.Foreach, place: Place, count: int) -> bool:
        """True if the body depends on the item and there are few enough items to examine each."""
        if count > MOST_TURNS - self.found.turns or not _may_differ(step.steps):
            return False
        each = RunCounts(turns=MOST_TURNS)
        Count(each).sequence(view, step.steps, (*place, "steps"), ONCE)
        if each.open or each.actions.least != each.actions.most:
            self.found.turns += count
            return True
        return False


def _may_differ(steps: Sequence[Any]) -> bool:
    left = list(steps)
    while left:
        step = left.pop()
        if step.when is not None or isinstance(step, p.If | p.LoopBase | p.Use):
            return True
        for _, inner in p.inner_lists(step):
            left += inner
    return False


def attempts(step: p.StepBase, defaults: p.Defaults) -> int:
    """The total number of attempts of a step; the retry of a set is that of its members."""
    said = step.retry
    if said is None and isinstance(step, p.Do):
        said = defaults.retry
    return said.attempts if isinstance(said, p.Retry) else said or 1


def number_of(found: RunCounts) -> str:
    """`6,428`, `6 to 12`, `2 + 3 for each sample`: the actions if nothing fails."""
    times = found.actions
    most = times.most
    known = f"{times.least:,}" if times.least == most else f"{times.least:,} to {most:,}"
    if not found.open:
        return known
    terms = [f"{n} × ({one})" if n > 1 else one for one, n in Counter(found.open).items()]
    return " + ".join([*([known] if most else []), *terms])
