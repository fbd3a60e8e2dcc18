"""Wait for a time; a pause of the run does not count."""

from py_trees.common import Status

from ....schemas.journal import StepEnded
from ....schemas.quantity import seconds
from ...language.expression import ExpressionError
from ...language.value import Value
from ...run.frame import Scope
from ...run.run import Run
from .failure import Failure
from .node import Node
from .replay_failed import came_to_here


class Wait(Node):
    """Done when its time is over. A wait cut short by the engine's death starts again."""

    def __init__(self, segment: str, run: Run, scope: Scope, duration: Value) -> None:
        super().__init__(segment, run)
        self.scope = scope
        self.duration = duration
        self.until: float | None = None
        self.over = False
        self.path = ""

    def initialise(self) -> None:
        self.failure, self.until = None, None
        self.path = f"{self.scope.frame.path}/{self.name}"
        try:
            duration_s = seconds(self.duration.evaluate(self.scope.frame.names))
        except (ExpressionError, ValueError) as fault:
            self.failure = Failure("Expression", str(fault), step=self.path)
            return
        known = self.path in self.run.past.steps
        if self.run.replaying and not known:
            self.failure = came_to_here(self.path)
            return
        # What was set again has to settle again: then the wait after it no longer counts.
        self.over = known and self.scope.frame.owner.path not in self.run.repeated
        self.until = self.run.clock.now() + (0.0 if self.over else duration_s)

    def update(self) -> Status:
        if self.until is None:
            return Status.FAILURE
        if self.run.clock.now() < self.until:
            self.run.requests.wake_at(self.until)
            return Status.RUNNING
        if not self.over:
            self.run.record(StepEnded(path=self.path, fate="succeeded"))
        return Status.SUCCESS
