"""What every check is given: the file, its protocol, and the devices that it names."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

from ...schemas.protocol import Protocol
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
