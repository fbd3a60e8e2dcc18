"""An action set that ends with the first member that succeeds; the others are cancelled."""

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...schemas.journal import Turned
from ..frame import Scope
from ..run import Run
from .node import Parent, failure_of, result_of


class AnyOf(Parent):
    """Its result is the winner's. It fails when every member has, with the last one's reason.

    Who has won is in the journal: a run that goes on does not begin the others again.
    """

    def __init__(self, name: str, run: Run, scope: Scope, members: list[Behaviour]) -> None:
        super().__init__(name, run, members)
        self.scope = scope
        self.failed: set[int] = set()
        self.winner: int | None = None

    @property
    def path(self) -> str:
        """Where the set stands now."""
        return f"{self.scope.frame.path}/{self.name}"

    def initialise(self) -> None:
        self.failed = set()
        past = self.run.history.turns.get(f"{self.path}/w")
        self.winner = past.turn - 1 if past is not None else None

    def advance(self) -> Iterator[Behaviour]:
        for index, member in enumerate(self.children):
            if index in self.failed or self.winner not in (None, index):
                continue  # ticking a member that has ended would start it again
            yield from member.tick()
            if member.status == Status.SUCCESS:
                self._won(index, member)
                return
            if member.status == Status.FAILURE:
                self._lost(index, member)
                if self.status != Status.RUNNING:
                    return

    def _won(self, index: int, member: Behaviour) -> None:
        if self.winner is None:
            self.run.record(Turned(path=f"{self.path}/w", turn=index + 1))
        self.winner = index
        self.result = result_of(member)
        self.status = Status.SUCCESS  # whoever is still RUNNING is stopped with that

    def _lost(self, index: int, member: Behaviour) -> None:
        self.failed.add(index)
        failure = failure_of(member)
        ends = failure.skip or failure.stop or failure.bygone or failure.anew
        if ends or len(self.failed) == len(self.children) or self.winner is not None:
            self.status = self.fail(failure)
        else:
            self.run.log(f"{failure.sentence()} (the others go on)", self.path)
