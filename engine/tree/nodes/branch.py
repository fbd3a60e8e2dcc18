"""`if`: one of two lists of steps, chosen once, even across several engine sessions."""

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import Turned
from ...language.expression import ExpressionError
from ...language.value import Value
from ...run.frame import Scope
from ...run.run import Run
from .failure import Failure
from .node import Parent, failure_of, result_of
from .replay_failed import came_to_here

THEN, ELSE = 1, 2


class Branch(Parent):
    """Ticks `then` or `else`; with neither to tick it succeeds, its result null.

    When a run is resumed, the values of a condition may have been measured again and differ; the
    branch whose actions were started is the one that continues. Only a changed protocol chooses
    again.
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
        """The current path of this step."""
        return f"{self.scope.frame.path}/{self.name}"

    def initialise(self) -> None:
        done = self.run.past
        past = done.turned.get(f"{self.path}/i")
        if past is None and self.replaying:
            self.status = self.fail(came_to_here(self.path))
            return
        try:
            stands = past is not None and not done.is_before_change(past)
            way = past.turn if past is not None and stands else self._decide()
        except ExpressionError as fault:
            self.status = self.fail(Failure("Expression", str(fault), step=self.path))
            return
        self.chosen = self.children[way - 1] if way <= len(self.children) else None

    def _decide(self) -> int:
        names = self.run.names(self.scope.frame.names, self.path)
        way = THEN if self.condition.evaluate(names) else ELSE
        self.run.record(Turned(path=f"{self.path}/i", turn=way))
        return way

    def advance(self) -> None:
        if self.chosen is None:
            self.status = Status.SUCCESS
            return
        self.chosen.tick_once()
        if self.chosen.status == Status.SUCCESS:
            self.result = result_of(self.chosen)
            self.status = Status.SUCCESS
        elif self.chosen.status == Status.FAILURE:
            self.status = self.fail(failure_of(self.chosen))
