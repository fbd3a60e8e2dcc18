"""`if`: one of two lists of steps, chosen once, also over several lives of the engine."""

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...schemas.journal import Turned
from ..failure import Failure
from ..frame import Scope
from ..language.expression import ExpressionError
from ..language.value import Value
from ..run import Run
from .bygone import came_to_here
from .node import Parent, failure_of, result_of

THEN, ELSE = 1, 2


class Branch(Parent):
    """Ticks `then` or `else`; with neither to tick it succeeds, its result null.

    What a condition is computed from may have been measured anew when a run goes on, and come out
    otherwise; the branch whose actions were begun is the one that is gone on with. Only another
    protocol chooses anew.
    """

    def __init__(
        self, name: str, run: Run, scope: Scope, condition: Value,
        then: Behaviour, otherwise: Behaviour | None,
    ) -> None:  # fmt: skip
        super().__init__(name, run, [then] if otherwise is None else [then, otherwise])
        self.scope = scope
        self.condition = condition
        self.chosen: Behaviour | None = None

    @property
    def path(self) -> str:
        """Where this step stands now."""
        return f"{self.scope.frame.path}/{self.name}"

    def initialise(self) -> None:
        history = self.run.history
        past = history.turns.get(f"{self.path}/i")
        if past is None and self.run.bygone:
            self.status = self.fail(came_to_here(self.path))
            return
        try:
            stands = past is not None and not history.is_before_change(past)
            way = past.turn if past is not None and stands else self._decide()
        except ExpressionError as fault:
            self.status = self.fail(Failure("Expression", str(fault), step=self.path))
            return
        self.chosen = self.children[way - 1] if way <= len(self.children) else None

    def _decide(self) -> int:
        way = THEN if self.condition.evaluate(self.scope.frame.names) else ELSE
        self.run.record(Turned(path=f"{self.path}/i", turn=way))
        return way

    def advance(self) -> Iterator[Behaviour]:
        if self.chosen is None:
            self.status = Status.SUCCESS
            return
        yield from self.chosen.tick()
        if self.chosen.status == Status.SUCCESS:
            self.result = result_of(self.chosen)
            self.status = Status.SUCCESS
        elif self.chosen.status == Status.FAILURE:
            self.status = self.fail(failure_of(self.chosen))
