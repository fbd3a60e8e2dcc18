"""Wait for a time, in which a pause of the run does not count; or until a time of day."""

from datetime import datetime

from py_trees.common import Status

from ....schemas.journal import StepEnded
from ....schemas.quantity import seconds
from ...language.expression import ExpressionError
from ...language.moments import moment_text, next_moment
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
        self.until = None
        self.path = f"{self.scope.frame.path}/{self.name}"
        try:
            duration_s = seconds(self.duration.evaluate(self.scope.frame.names))
        except (ExpressionError, ValueError) as fault:
            self.failure = Failure("Expression", str(fault), step=self.path)
            return
        known = self.path in self.run.past.steps
        if self.replaying and not known:
            self.failure = came_to_here(self.path)
            return
        # What was set again has to settle again: then the wait after it no longer counts.
        self.over = known and not self.scope.frame.owner.repeats
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


LOOK_S = 30.0
"""How soon it is noticed that the computer's clock was set, or that it has slept."""


class WaitUntil(Node):
    """Done at a moment that is fixed when it begins: a resumed run waits for the same one.

    It is a time of the day, so a pause makes no difference to it; one that is over does not wait.
    """

    def __init__(self, segment: str, run: Run, scope: Scope, until: Value) -> None:
        super().__init__(segment, run)
        self.scope = scope
        self.said = until
        self.until: datetime | None = None
        self.over = False
        self.path = ""

    def initialise(self) -> None:
        self.until, self.over = None, False
        self.path = f"{self.scope.frame.path}/{self.name}"
        known = self.path in self.run.past.steps
        if self.replaying and not known:
            self.failure = came_to_here(self.path)
            return
        try:
            said = self.said.evaluate(self.run.names(self.scope.frame.names, self.path))
            now = self.run.clock.time_of_day
            until = self.run.computed(f"{self.path}/until", lambda: next_moment(said, now()))
        except (ExpressionError, ValueError) as fault:
            self.failure = Failure("Expression", str(fault), step=self.path)
            return
        self.until, self.over = until, known
        if not known:
            self.run.log(f"waiting until {moment_text(until)}", self.path)

    def update(self) -> Status:
        if self.until is None:
            return Status.FAILURE
        left = (self.until - self.run.clock.time_of_day()).total_seconds()
        if not self.over and left > 0:
            self.run.requests.wake_at(self.run.clock.now() + min(left + 0.001, LOOK_S))
            return Status.RUNNING
        if not self.over:
            self.run.record(StepEnded(path=self.path, fate="succeeded"))
        return Status.SUCCESS
