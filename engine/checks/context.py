"""What every check is given: the file, its protocol, and the devices that it names."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

from ...schemas.contract import Action
from ...schemas.protocol import Do, Protocol
from ..lab.bind import BoundRole
from ..lab.lab import LoadedLab
from ..language.source import Source
from ..survey.spots import StepAt
from ..survey.survey import Survey

Kind = TypeVar("Kind")


@dataclass(frozen=True, slots=True)
class Context:
    """A protocol as read, bound and surveyed; `whole` where all of it could be read."""

    source: Source
    protocol: Protocol
    lab: LoadedLab | None
    roles: Mapping[str, BoundRole]
    survey: Survey
    whole: bool = True
    used: bool = False
    """True for a protocol used by another one; the steps around the `use` are not known here."""

    def steps(self, kind: type[Kind]) -> Iterator[tuple[Kind, StepAt]]:
        """Every step of one kind, with its place."""
        for at in self.survey.steps:
            if isinstance(at.step, kind):
                yield at.step, at

    def action(self, step: Do) -> tuple[BoundRole, Action] | None:
        """The device that a `do` addresses and its action; None where either is unknown."""
        role, _, name = step.do.partition(".")
        bound = self.roles.get(role)
        if bound is None or name not in bound.contract.actions:
            return None
        return bound, bound.contract.actions[name]

    def actions(self) -> Iterator[tuple[Do, StepAt, BoundRole, Action]]:
        """Every `do` whose action is known."""
        for step, at in self.steps(Do):
            found = self.action(step)
            if found is not None:
                yield step, at, *found
