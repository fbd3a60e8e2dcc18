"""Who reduces: processes of this machine or workers of a cluster, asked in the same way."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from .source import Source
from .work import Done

Chunk = Sequence[Source]


@dataclass(frozen=True, slots=True)
class Answer:
    """To the chunk of that number: what was done, or a sentence on why nobody will do it."""

    number: int
    done: list[Done] = field(default_factory=list)
    lost: str = ""


class CrewFault(Exception):
    """Nobody can reduce anything; the message is a sentence with a way out."""


class CrewUnreachable(CrewFault):
    """The cluster does not answer."""


class Crew(Protocol):
    """room: how many chunks may be under way at a time."""

    room: int

    def start(self, number: int, chunk: Chunk) -> None:
        """Have a chunk reduced; its answer comes some time, under its number."""
        ...

    def answers(self, wait_s: float) -> list[Answer]:
        """What was answered within that time, at once if something was. Raises CrewFault."""
        ...

    def close(self) -> None:
        """End everything that is under way, within about a second."""
        ...
