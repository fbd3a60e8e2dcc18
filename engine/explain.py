"""A protocol as P = [A1, ..., AT]: sets of actions in order, their sizes, how often they run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..schemas import protocol as p
from .check import Checked
from .language.grid import Grid, Span
from .language.shape import Place


@dataclass(slots=True)
class Count:
    """A number that may not be known before the run: `unknown` names what it depends on."""

    actions: int = 0
    unknown: list[str] = field(default_factory=list)

    def add(self, other: "Count", times: int | None = 1, name: str = "") -> None:
        """Add another count, so many times; None where that is not known."""
        if times is None:
            if other.actions or other.unknown:
                self.unknown.append(f"{other.actions} for each {name}")
            return
        self.actions += other.actions * times
        self.unknown += other.unknown

    def text(self) -> str:
        """`4285 actions`, with what is not known yet."""
        more = "".join(f" + {part}" for part in self.unknown)
        return f"{self.actions:,}{more} action{'' if self.actions == 1 and not more else 's'}"


class Explanation:
    """Writes the lines, numbering the sets as it goes."""

    def __init__(self, checked: Checked) -> None:
        assert checked.survey is not None
        self.checked = checked
        self.survey = checked.survey
        self.items = {
            at.place: loop for at, loop in zip(
                (at for at in self.survey.steps if isinstance(at.step, p.Foreach)),
                self.survey.loops, strict=True,
            )
        }  # fmt: skip
        self.number = 0
        self.lines: list[str] = []

    def sequence(self, steps: Sequence[Any], place: Place, depth: int) -> Count:
        """Steps one after the other."""
        count = Count()
        for index, step in enumerate(steps):
            count.add(self.step(step, (*place, index), depth))
        return count

    def step(self, step: p.StepBase, place: Place, depth: int) -> Count:
        """One step: a set, or what holds sets."""
        if isinstance(step, p.Do):
            self._set([step.do], step, depth)
            return Count(1)
        if isinstance(step, p.Parallel):
            return self._parallel(step, depth)
        if isinstance(step, p.Foreach):
            return self._loop(step, place, depth)
        if isinstance(step, p.Group):
            self._say(depth, f"group{_named(step)}")
            return self.sequence(step.steps, (*place, "steps"), depth + 1)
        self._say(depth, _other(step))
        return Count()

    def _set(self, actions: list[str], step: p.StepBase, depth: int) -> None:
        self.number += 1
        aside = ", in the background" if isinstance(step, p.Do) and step.mode else ""
        text = f"A{self.number} = {{{', '.join(actions)}}}"
        self._say(
            depth,
            f"{text:<40} |A{self.number}| = {len(actions)}{aside}{_named(step)}{_guard(step)}",
        )

    def _parallel(self, step: p.Parallel, depth: int) -> Count:
        names, count = [], 0
        for member in step.parallel:
            actions = list(_actions(member))
            count += len(actions)
            names.append(" then ".join(actions) if actions else member.KIND)
        self._set(names, step, depth)
        return Count(count)

    def _loop(self, step: p.Foreach, place: Place, depth: int) -> Count:
        name = next(iter(step.foreach))
        items = self.items[place].items
        times = len(items) if items is not None else None
        self._say(depth, f"for each {name} of {_items_text(items)}{_named(step)}{_guard(step)}")
        inner = self.sequence(step.steps, (*place, "steps"), depth + 1)
        count = Count()
        count.add(inner, times, name)
        return count

    def _say(self, depth: int, text: str) -> None:
        self.lines.append("  " * depth + text.rstrip())


def explain_protocol(checked: Checked) -> Iterator[str]:
    """The lines that say what a checked protocol does."""
    protocol = checked.protocol
    assert protocol is not None
    yield f"{protocol.name}" + (f": {protocol.summary}" if protocol.summary else "")
    for role, bound in checked.roles.items():
        yield f"  {role} is played by {bound.device} ({bound.contract.type})"
    explanation = Explanation(checked)
    count = explanation.sequence(protocol.steps, ("steps",), 1)
    sets = f"P = [A1, ..., A{explanation.number}]" if explanation.number > 1 else "P = [A1]"
    yield f"{sets if explanation.number else 'P = []'}: {count.text()}, if nothing fails"
    yield from explanation.lines
    explanation.lines = []
    for title, steps in (("on_resume", protocol.on_resume), ("finally", protocol.finally_)):
        if steps:
            yield title
            explanation.sequence(steps, ("finally" if title == "finally" else title,), 1)
            yield from explanation.lines
            explanation.lines = []


def _actions(step: Any) -> Iterator[str]:
    if isinstance(step, p.Do):
        yield step.do
    elif isinstance(step, p.Group | p.Foreach):
        for inner in step.steps:
            yield from _actions(inner)


def _items_text(items: Sequence[Any] | None) -> str:
    if items is None:
        return "a number of items that is known only in the run"
    if isinstance(items, Grid):
        return (
            f"a grid of {items.across:,} x {items.down:,} = {len(items):,} points ({items.order})"
        )
    kind = "a span of " if isinstance(items, Span) else ""
    return f"{kind}{len(items):,} item{'' if len(items) == 1 else 's'}"


def _named(step: p.StepBase) -> str:
    return f"   ({step.id})" if step.id else ""


def _guard(step: p.StepBase) -> str:
    return "   only when " + str(step.when) if step.when is not None else ""


def _other(step: p.StepBase) -> str:
    said = getattr(step, step.KIND, "")
    text = ", ".join(said) if isinstance(said, dict) else str(said)
    return f"{step.KIND}: {text if len(text) <= 70 else text[:67] + '...'}{_guard(step)}"
