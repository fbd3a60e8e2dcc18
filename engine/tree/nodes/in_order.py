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
            if step.status == Status.FAILURE:
                self.status = self.fail(failure_of(step))
                return
            self.current += 1
        self.result = result_of(self.children[-1]) if self.children else None
        self.status = Status.SUCCESS

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
