"""Steps one after the other, until one fails: py_trees' `Sequence` with memory, ticked as a node of ours."""

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.run import Run
from .node import Parent, failure_of, result_of


class InOrder(Parent):
    """Fails with the step that fails; its result is the last step's."""

    def __init__(self, name: str, run: Run, steps: list[Behaviour]) -> None:
        super().__init__(name, run, steps)
        self.current = 0

    def initialise(self) -> None:
        self.current = 0
        self._forget(self.children)

    def advance(self) -> None:
        while self.current < len(self.children):
            step = self.children[self.current]
            step.tick_once()
            if step.status == Status.RUNNING:
                return
            self.current += 1
            if step.status == Status.FAILURE and self.ended_by(step):
                break
        self.end()

    def ended_by(self, step: Behaviour) -> bool:
        """A step has failed: whether the rest of them is left out."""
        self.failure = failure_of(step)
        return True

    def end(self) -> None:
        """Its steps are over, or one of them has ended it."""
        if self.failure is None and self.children:
            self.result = result_of(self.children[-1])
        self.status = Status.SUCCESS if self.failure is None else Status.FAILURE

    def stop(self, new_status: Status) -> None:
        if new_status == Status.INVALID:
            self._forget(self.children)
        super().stop(new_status)

    @staticmethod
    def _forget(steps: list[Behaviour]) -> None:
        """What has ended in an earlier turn has not begun in this one."""
        for step in steps:
            if step.status != Status.INVALID:
                step.stop(Status.INVALID)
