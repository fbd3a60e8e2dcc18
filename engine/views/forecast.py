"""What is known about a protocol before it runs: its values, the items of its loops, its branches."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...schemas import protocol as p
from ..check import Checked
from ..lab.bind import BoundRole
from ..language.expression import ExpressionError
from ..language.shape import Place
from ..language.value import value_of
from ..params.value import ParamFault, take
from ..survey.spots import Spot
from ..survey.survey import Survey

DEEPEST_USE = 30


class Unknown:
    """A value that is known only during the run."""

    def __bool__(self) -> bool:
        raise TypeError("an unknown value is neither true nor false yet")


UNKNOWN = Unknown()


@dataclass(frozen=True)
class Outlook:
    """A place in a protocol, seen before the run: `names` are the names that have a value there.

    It follows the protocol as a run would, so that what an item of a loop decides is known for
    each item; `within` is where the protocol is used by another one, the empty place for the
    protocol of the file itself.
    """

    protocol: p.Protocol
    survey: Survey
    roles: Mapping[str, BoundRole]
    spots: Mapping[Place, Spot]
    names: Mapping[str, Any]
    within: Place = ()
    depth: int = 0

    def value(self, raw: Any, place: Place) -> Any:
        """The value at a place; UNKNOWN if only the run can tell."""
        spot = self.spots.get(place)
        try:
            value = spot.value if spot is not None else value_of(raw, self.survey.own_names)
            return UNKNOWN if isinstance(value, Exception) else value.evaluate(self.names)
        except ExpressionError:
            return UNKNOWN

    def truth(self, raw: Any, place: Place) -> bool | None:
        """True, false, or None if only the run can tell."""
        found = self.value(raw, place)
        return found if isinstance(found, bool) else None

    def number(self, raw: Any, place: Place) -> int | None:
        """A whole number, 0 or more, or None if only the run can tell."""
        found = self.value(raw, place)
        whole = isinstance(found, int) and not isinstance(found, bool) and found >= 0
        return found if whole else None

    def items(self, step: p.Foreach, place: Place) -> Sequence[Any] | None:
        """The items of a loop, or None if only the run can tell."""
        ((name, raw),) = step.foreach.items()
        found = self.value(raw, (*place, "foreach", name))
        listed = isinstance(found, Sequence) and not isinstance(found, str)
        return found if listed else None

    @property
    def lists(self) -> tuple[tuple[str, Sequence[Any]], ...]:
        """What runs of it in every case, by the keys of the protocol."""
        return ("steps", self.protocol.steps), ("finally", self.protocol.finally_)

    # --- the same protocol, at later places

    def along(self, steps: Sequence[Any], place: Place) -> Iterator[tuple["Outlook", Any, Place]]:
        """Each step of a list with its place, and what is known before it."""
        view = self
        for index, step in enumerate(steps):
            here = (*place, index)
            yield view, step, here
            view = view.after(step, here)

    def bound(self, **names: Any) -> "Outlook":
        """With these names known as well; one whose value is UNKNOWN is forgotten."""
        known = {**self.names, **names}
        return replace(self, names={n: v for n, v in known.items() if v is not UNKNOWN})

    def after(self, step: p.StepBase, place: Place) -> "Outlook":
        """After a step: with the values of a `set`, without what a step inside may have changed."""
        if isinstance(step, p.Set) and step.when is None:
            found = {n: self.value(raw, (*place, "set", n)) for n, raw in step.set.items()}
            return self.bound(**found)
        return self.forgetting([step])

    def forgetting(self, steps: Iterable[Any]) -> "Outlook":
        """Without the names that these steps, or any inside them, assign."""
        gone = {name for step in steps for name in set_inside(step)} & set(self.names)
        return self.bound(**dict.fromkeys(gone, UNKNOWN)) if gone else self

    def used(self, step: p.Use, place: Place) -> "Outlook | None":
        """The protocol that a step uses, with its parameters as far as they are known."""
        other = self.survey.used.get(place)
        if other is None or self.depth >= DEEPEST_USE:
            return None
        params = dict(other.survey.values)
        for name, raw in step.with_.items():
            params.pop(name, None)
            value = self.value(raw, (*place, "with", name))
            if value is not UNKNOWN and name in other.protocol.params:
                try:
                    params[name] = take(name, other.protocol.params[name], value)
                except ParamFault:
                    continue  # reported by the checks
        within = (*self.within, *place, "use")
        return _outlook(other, params, within, self.depth + 1)


def outlook(checked: Checked) -> Outlook:
    """The protocol of a checked file, at its start."""
    assert checked.survey is not None
    return _outlook(checked, checked.params, (), 0)


def _outlook(of: Any, params: Mapping[str, Any], within: Place, depth: int) -> Outlook:
    spots = {spot.place: spot for spot in of.survey.spots}
    names = {"params": params, "csv": of.survey.tables}
    return Outlook(of.protocol, of.survey, of.roles, spots, names, within, depth)


def inner_steps(step: p.StepBase) -> Iterator[tuple[Place, Any]]:
    """Every step directly inside a step, with its place from there; fallbacks too."""
    for key, steps in p.inner_lists(step):
        for index, inner in enumerate(steps):
            yield (key, index), inner
    for index, alternative in enumerate(step.fallback):
        if isinstance(alternative, list):
            for deeper, inner in enumerate(alternative):
                yield ("fallback", index, deeper), inner
        else:
            yield ("fallback", index), alternative
    for then, keys in p.thens(step):
        if isinstance(then, list):
            for deeper, inner in enumerate(then):
                yield (*keys, deeper), inner
        else:
            yield keys, then


def set_inside(step: p.StepBase) -> Iterator[str]:
    """The names that a step assigns, itself or by a step inside it."""
    if isinstance(step, p.Set):
        yield from step.set
    for _, inner in inner_steps(step):
        yield from set_inside(inner)
