"""An action set: its members start together, and it ends when all of them have ended."""

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ..run import Run
from .node import Parent, failure_of, result_of


class ActionSet(Parent):
    """Succeeds when every member did. A failure lets the others finish, or cancels them."""

    def __init__(self, name: str, run: Run, members: list[Behaviour], *, cancel: bool) -> None:
        super().__init__(name, run, members)
        self.cancel = cancel
        self.ended: set[int] = set()

    def initialise(self) -> None:
        self.ended = set()

    def advance(self) -> Iterator[Behaviour]:
        for index, member in enumerate(self.children):
            if index in self.ended:
                continue  # ticking a member that has ended would start it again
            yield from member.tick()
            if member.status == Status.RUNNING:
                continue
            self.ended.add(index)
            if member.status == Status.FAILURE and self.failure is None:
                self.failure = failure_of(member)
        if self.failure is not None and self.cancel:
            self._cancel_the_rest()
        if len(self.ended) == len(self.children):
            self.result = [result_of(member) for member in self.children]
            self.status = Status.SUCCESS if self.failure is None else Status.FAILURE

    def _cancel_the_rest(self) -> None:
        for index, member in enumerate(self.children):
            if index not in self.ended:
                member.stop(Status.INVALID)
                self.ended.add(index)
