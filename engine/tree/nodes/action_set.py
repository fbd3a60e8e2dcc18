"""An action set: its members start together, and it ends when all of them have ended."""

from collections.abc import Iterable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.run import Run
from .failure import Failure
from .finally_of_use import FinallyOfUse
from .node import Parent, failure_of, result_of
from .retry import Retry
from .step import StepNode


def gravest(failures: Iterable[Failure]) -> Failure:
    """Of simultaneous failures the one that goes up: no other hides a `stop` by a person.

    `skip` is the least of them, since a loop continues after it whatever it tolerates.
    """
    return max(failures, key=lambda f: (f.anew, f.stop, f.bygone, not f.skip))


class ActionSet(Parent):
    """Succeeds when every member did. A failure lets the others finish, or cancels them."""

    def __init__(self, name: str, run: Run, members: list[Behaviour], *, cancel: bool) -> None:
        super().__init__(name, run, members)
        self.cancel = cancel
        self.ended: set[int] = set()
        self.lost: set[int] = set()
        self.kept: set[int] = set()
        self.finally_due: FinallyOfUse | None = None

    def initialise(self) -> None:
        self.ended, self.lost, self.kept, self.finally_due = self.kept, set(), set(), None

    def keep_done(self) -> None:
        """Next time only what failed is started again."""
        self.kept = self.ended - self.lost

    def with_in_place(self, other: Any) -> list[Any]:
        """Its results, with `other` in place of each missing one."""
        return [other if i in self.lost else result_of(m) for i, m in enumerate(self.children)]

    def advance(self) -> None:
        for index, member in enumerate(self.children):
            if index in self.ended:
                continue  # ticking a member that has ended would start it again
            member.tick_once()
            if member.status == Status.RUNNING:
                continue
            self.ended.add(index)
            if member.status == Status.FAILURE:
                self.lost.add(index)
                failure = failure_of(member)
                self.failure = gravest([self.failure, failure]) if self.failure else failure
        if self.failure is not None and self.cancel:
            self._cancel_the_rest()
        if self.finally_due is not None:
            self.finally_due.tick_once()
        if len(self.ended) == len(self.children) and not (
            self.finally_due and self.finally_due.due
        ):
            self.result = [result_of(member) for member in self.children]
            self.status = Status.SUCCESS if self.failure is None else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        if self.finally_due is not None:
            self.finally_due.stop()

    def _cancel_the_rest(self) -> None:
        stopped = [i for i in range(len(self.children)) if i not in self.ended]
        for index in stopped:
            self.children[index].stop(Status.INVALID)
        self.ended.update(stopped)
        self.lost.update(stopped)
        members = [self.children[i] for i in stopped]
        if members:
            paths = [m.path for m in members if isinstance(m, StepNode | Retry)]
            self.finally_due = FinallyOfUse(self, paths)
