"""An action set that ends with the first member that succeeds; the others are cancelled."""

from collections import deque

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import Turned
from ...run.frame import Scope
from ...run.run import Run
from .failure import Failure
from .finally_of_use import FinallyOfUse
from .node import Parent, failure_of, result_of
from .replay_failed import replay_failed
from .retry import Retry
from .step import StepNode


class AnyOf(Parent):
    """Its result is the winner's. It fails when no member is left, with the last failure's reason.

    A member that was skipped (`when`) has not succeeded; if all were, the set is skipped, too.
    The winner is in the journal: a resumed run does not start the others again. What they had
    set until then is set again.
    """

    def __init__(self, name: str, run: Run, scope: Scope, members: list[Behaviour]) -> None:
        super().__init__(name, run, members)
        self.scope = scope
        self.out: set[int] = set()
        self.last: Failure | None = None
        self.winner: int | None = None
        self.gone: deque[Behaviour] = deque()
        self.finally_due: FinallyOfUse | None = None

    @property
    def path(self) -> str:
        """The current path of the set."""
        return f"{self.scope.frame.path}/{self.name}"

    def initialise(self) -> None:
        self.out, self.last, self.finally_due, self.winner = set(), None, None, None
        self.gone.clear()
        done = self.run.past
        past = done.turned.get(f"{self.path}/w")
        if past is not None and past.turn <= len(self.children):
            self.winner = past.turn - 1
            self.gone.extend(m for i, m in enumerate(self.children) if i != self.winner)
            for member in self.gone:
                done.forget_under_way(f"{self.scope.frame.path}/{member.name}", past.n)

    def advance(self) -> None:
        self._losers()
        if self.finally_due is None and not self.gone:
            self._race()
        if self.finally_due is not None:
            self.finally_due.tick_once()
            if not self.finally_due.due:
                self.status = Status.SUCCESS if self.failure is None else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        if self.finally_due is not None:
            self.finally_due.stop()

    def _losers(self) -> None:
        """Those that had lost in an earlier session, as far as they had got then."""
        while self.gone:
            replay_failed(self.gone[0])
            if self.gone[0].status == Status.RUNNING:
                return
            self.gone.popleft()

    def _race(self) -> None:
        for index, member in enumerate(self.children):
            if index in self.out or self.winner not in (None, index):
                continue  # ticking a member that has ended would start it again
            member.tick_once()
            if member.status == Status.RUNNING:
                continue
            if member.status == Status.FAILURE:
                self._lost(index, failure_of(member))
            elif was_skipped(member):
                self.out.add(index)
            else:
                self._won(index, member)
            if self.finally_due is not None:
                return
        if len(self.out) == len(self.children):
            self._over(self.last)

    def _won(self, index: int, member: Behaviour) -> None:
        if self.winner is None:
            self.run.record(Turned(path=f"{self.path}/w", turn=index + 1))
        self.winner = index
        self.result = result_of(member)
        self._over(None)

    def _lost(self, index: int, failure: Failure) -> None:
        self.out.add(index)
        self.last = failure
        ends = failure.skip or failure.stop or failure.bygone or failure.anew
        if ends or self.winner is not None:
            self._over(failure)
        elif len(self.out) < len(self.children):
            told = failure.told_in(self.scope.frame)
            self.run.log(f"{told} (the others continue)", self.path)

    def _over(self, failure: Failure | None) -> None:
        self.failure = failure
        for member in self.children:
            if member.status == Status.RUNNING:
                member.stop(Status.INVALID)
        self.finally_due = FinallyOfUse(self, [self.path])


def was_skipped(member: Behaviour) -> bool:
    """True for a member whose `when` was false; a retried one is looked into."""
    step = member.child if isinstance(member, Retry) else member
    return isinstance(step, StepNode) and step.skipped
