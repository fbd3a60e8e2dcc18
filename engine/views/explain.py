"""A protocol as P = [A1, ..., AT]: sets of actions in order, their sizes, how often they run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ...schemas import protocol as p
from ..check import Checked
from ..language.shape import Place
from .count import NEVER, RunCounts, Times, attempts, count_runs, number_of
from .english import bare, count_of, items_text, joined, shortened
from .forecast import Outlook, outlook

WIDEST = 44
"""The width of the sets' column; a wider set shifts the rest of its own line."""


@dataclass(slots=True)
class Row:
    """One line: a set with its size and times, or anything else as text alone."""

    text: str
    size: str = ""
    times: str = ""
    said: str = ""


def explain_protocol(checked: Checked) -> Iterator[str]:
    """The lines that describe what a checked protocol does."""
    assert checked.protocol is not None
    view = outlook(checked)
    protocol = view.protocol
    yield protocol.name + (f": {protocol.summary}" if protocol.summary else "")
    for role, bound in checked.roles.items():
        yield f"  {role} is played by {bound.device} ({bound.contract.type})"
    yield ""
    explanation = Explanation()
    counted = explanation.section(view, protocol.steps, ("steps",))
    sets = explanation.number
    known = "P = []" if sets == 0 else "P = [A1]" if sets == 1 else f"P = [A1, ..., A{sets}]"
    yield f"{known}: {_actions_text(counted)}, if nothing fails"
    yield from _worst(counted, len(known))
    yield from explanation.lines()
    for title, steps in (("on_resume", protocol.on_resume), ("finally", protocol.finally_)):
        if steps:
            after = Explanation(explanation.number)
            counted = after.section(view, steps, (title,))
            explanation.number = after.number
            yield f"{title}: {_actions_text(counted)}"
            yield from after.lines()


def _actions_text(counted: RunCounts) -> str:
    number = number_of(counted)
    return f"{number} action{'' if number == '1' else 's'}"


def _worst(counted: RunCounts, indent: int) -> Iterator[str]:
    worst = counted.actions.worst
    space = " " * (indent + 2)
    if counted.asks:
        fixed = f"{worst:,} with every retry and fallback, and " if worst is not None else ""
        yield f"{space}{fixed}more if a person chooses `repeat`"
    elif worst is not None and worst != counted.actions.most:
        yield f"{space}{worst:,} at most, with every retry and fallback"


class Explanation:
    """Writes the rows, numbering the sets as it goes."""

    def __init__(self, number: int = 0) -> None:
        self.number = number
        self.rows: list[Row] = []
        self.times: dict[Place, Times] = {}

    def section(self, view: Outlook, steps: Sequence[Any], place: Place) -> RunCounts:
        """The rows of a phase of the protocol, and what is counted in it."""
        counted = count_runs(view, steps, place)
        self.times = counted.times
        self.sequence(view, steps, place, 1)
        return counted

    def lines(self) -> Iterator[str]:
        """The rows with their columns under each other."""
        sets = [row for row in self.rows if row.size]
        wide = min(max((len(row.text) for row in sets), default=0), WIDEST)
        size = max((len(row.size) for row in sets), default=0)
        times = max((len(row.times) for row in sets), default=0)
        for row in self.rows:
            if row.size:
                parts = (
                    f"{row.text:<{wide}}   {row.size:<{size}}   {row.times:>{times}}   {row.said}"
                )
                yield parts.rstrip()
            else:
                yield row.text + (f"   ({row.said})" if row.said else "")

    def sequence(self, view: Outlook, steps: Sequence[Any], place: Place, depth: int) -> None:
        """Steps in sequence."""
        for before, step, here in view.along(steps, place):
            self.step(before, step, here, depth)

    def step(self, view: Outlook, step: p.StepBase, place: Place, depth: int) -> None:
        """One step: a set, or what holds sets; then what is tried if it fails."""
        said = _said(step, view.protocol.defaults)
        if _is_set(step):
            times = self.times.get((*view.within, *place), NEVER)
            self._set(step, times, depth, said)
        else:
            self._say(depth, self._holder(view, step, place), said)
            self._inside(view, step, place, depth + 1)
        for index, alternative in enumerate(step.fallback):
            self._say(depth + 1, f"if it still fails ({index + 1}): {_alternative(alternative)}")
        for watch in p.watches(step):
            then = "pause" if watch.then == "pause" else _alternative(watch.then)
            self._say(depth + 1, f"meanwhile, as soon as {shortened(bare(watch.when))}: {then}")

    def _set(self, step: p.StepBase, times: Times, depth: int, said: str) -> None:
        self.number += 1
        members = [step] if isinstance(step, p.Do) else getattr(step, step.KIND)
        named = [" then ".join(_actions(member)) or member.KIND for member in members]
        text = f"A{self.number} = {{{', '.join(named)}}}"
        if isinstance(step, p.AnyOf):
            said = ", ".join([*([said] if said else []), "the first success wins"])
        size = f"|A{self.number}| = {len(members)}"
        self.rows.append(Row("  " * depth + text, size, f"{times_text(times)} ×", said))

    def _holder(self, view: Outlook, step: p.StepBase, place: Place) -> str:
        if isinstance(step, p.Foreach):
            name, raw = next(iter(step.foreach.items()))
            items = view.items(step, place)
            what = f"the items of {shortened(bare(raw))}" if items is None else items_text(items)
            return f"for each {name} of {what}"
        if isinstance(step, p.Repeat):
            times = view.number(step.repeat, (*place, "repeat"))
            return f"{shortened(bare(step.repeat)) if times is None else f'{times:,}'} times"
        if isinstance(step, p.While):
            most = "" if step.max is None else f", up to {shortened(bare(step.max))} times"
            return f"while {shortened(bare(step.while_))}{most}"
        if isinstance(step, p.If):
            truth = view.truth(step.if_, (*place, "if"))
            known = "" if truth is None else f" ({'always' if truth else 'never'} true here)"
            return f"if {shortened(bare(step.if_))}{known}"
        if isinstance(step, p.Parallel | p.AnyOf):
            members = count_of(len(getattr(step, step.KIND)), "member")
            wins = ", the first success wins" if isinstance(step, p.AnyOf) else ""
            return f"at the same time, {members}{wins}"
        if isinstance(step, p.Use):
            other = view.used(step, place)
            return f"use {step.use}" + (f": {other.protocol.name}" if other is not None else "")
        return "group" if isinstance(step, p.Group) else _other(step)

    def _inside(self, view: Outlook, step: p.StepBase, place: Place, depth: int) -> None:
        inside = view.forgetting([step])
        if isinstance(step, p.If):
            self.sequence(view, step.then, (*place, "then"), depth)
            if step.else_:
                self._say(depth - 1, "else", "")
                self.sequence(view, step.else_, (*place, "else"), depth)
        elif isinstance(step, p.Use):
            other = view.used(step, place)
            if other is not None:
                self.sequence(other, other.protocol.steps, ("steps",), depth)
                if other.protocol.on_resume:
                    steps = count_of(len(other.protocol.on_resume), "step")
                    self._say(depth, f"if a run is resumed in it, its on_resume first: {steps}")
                if other.protocol.finally_:
                    self._say(depth - 1, "finally of " + other.protocol.name, "")
                    self.sequence(other, other.protocol.finally_, ("finally",), depth)
        elif isinstance(step, p.Group):
            self.sequence(view, step.steps, (*place, "steps"), depth)
        elif isinstance(step, p.Parallel | p.AnyOf):
            for index, member in enumerate(getattr(step, step.KIND)):
                self.step(view, member, (*place, step.KIND, index), depth)
        elif isinstance(step, p.LoopBase):
            self.sequence(inside, step.steps, (*place, "steps"), depth)

    def _say(self, depth: int, text: str, said: str = "") -> None:
        self.rows.append(Row("  " * depth + text, said=said))


def _is_set(step: p.StepBase) -> bool:
    """True for what is one set: a `do`, or members that are actions, or a few one after the other."""
    if isinstance(step, p.Do):
        return True
    if not isinstance(step, p.Parallel | p.AnyOf):
        return False
    return all(
        isinstance(member, p.Do)
        or (isinstance(member, p.Group) and all(isinstance(one, p.Do) for one in member.steps))
        for member in getattr(step, step.KIND)
    )


def times_text(times: Times) -> str:
    """`1,071`, `0 to 4`, `?`: how often, if nothing fails."""
    if times.most is None:
        return "?"
    if times.least == times.most:
        return f"{times.most:,}"
    return f"{times.least:,} to {times.most:,}"


def _said(step: p.StepBase, defaults: p.Defaults) -> str:
    """The text after a line: the id, retries, guard."""
    parts = [step.id] if step.id else []
    if step.name:
        parts.append(f'"{shortened(step.name, 50)}"')
    tried = attempts(step, defaults)
    if tried > 1:
        parts.append(f"tried up to {count_of(tried, 'time')}")
    if isinstance(step, p.Group) and step.reserve:
        parts.append(f"keeps {joined(step.reserve, 'and')} for itself")
    if isinstance(step, p.Foreach) and step.at_once is not None:
        shortest = " in the shortest order" if step.order == "shortest" else ""
        parts.append(f"{bare(step.at_once)} at once{shortest}")
    if isinstance(step, p.Do | p.Group) and step.mode:
        parts.append("in the background")
    if step.when is not None:
        parts.append(f"only when {shortened(bare(step.when))}")
    if isinstance(step, p.LoopBase) and step.keep_going is not None:
        most, in_a_row = step.keep_going.max_failed, step.keep_going.in_a_row
        some = "any number" if most is None else f"up to {shortened(bare(most))}"
        row = "" if in_a_row is None else f", {shortened(bare(in_a_row))} in a row"
        parts.append(f"{some} may fail{row}")
    if step.on_error == "continue":
        parts.append("failures are ignored")
    return ", ".join(parts)


def _alternative(alternative: Any) -> str:
    steps = alternative if isinstance(alternative, list) else [alternative]
    actions = [action for step in steps for action in _actions(step)]
    if len(steps) == 1 and not actions:
        return _other(steps[0])
    name = getattr(alternative, "name", None)
    return (f'"{shortened(name, 50)}": ' if name else "") + " then ".join(
        f"{{{action}}}" for action in actions
    )


def _actions(step: Any) -> Iterator[str]:
    """The actions of a step and of all in it, in order, without fallbacks."""
    if isinstance(step, p.Do):
        yield step.do
    for _, inner in p.inner_lists(step):
        for one in inner:
            yield from _actions(one)


def _other(step: p.StepBase) -> str:
    said = getattr(step, step.KIND, "")
    text = ", ".join(said) if isinstance(said, dict) else f'"{shortened(bare(said))}"'
    if isinstance(step, p.Ask):
        text += f" ({joined(step.choices, 'or')})"
    if isinstance(step, p.Wait) and step.until is not None:
        text = f"until {shortened(bare(step.until))}"
    elif isinstance(step, p.Require | p.Wait):
        text = shortened(bare(said))
    return f"{step.KIND}: {text}"
