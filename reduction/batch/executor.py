"""The common interface of executors: processes of this machine, or workers of a cluster."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from .source import Source
from .work import Done

Chunk = Sequence[Source]


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to the chunk of that number: its results, or a sentence on why there are none."""

    number: int
    done: list[Done] = field(default_factory=list)
    lost: str = ""


class ExecutorFault(Exception):
    """No worker can reduce anything; the message is a sentence with a way out."""


class ExecutorUnreachable(ExecutorFault):
    """The cluster does not answer."""


class Executor(Protocol):
    """room: how many chunks may be under way at a time."""

    room: int

    def start(self, number: int, chunk: Chunk) -> None:
        """Submit a chunk; its answer comes later, under its number."""
        ...

    def answers(self, wait_s: float) -> list[Answer]:
        """Answers within that time, immediately if there are any. Raises ExecutorFault."""
        ...

    def close(self) -> None:
        """End everything that is under way, within about a second."""
        ...
