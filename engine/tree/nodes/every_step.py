"""Steps of `finally`: one after the other, and each of them, whatever became of those before it."""

from dataclasses import replace

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.run import Run
from .action_set import gravest
from .failure import Failure
from .node import Parent, failure_of


class EveryStep(Parent):
    """Fails when all have ended and one has failed: with the gravest failure, the first of several.

    Only a person's `stop`, or the point that an earlier engine session had reached, ends it before.
    """

    def __init__(self, name: str, run: Run, steps: list[Behaviour]) -> None:
        super().__init__(name, run, steps)
        self.current = 0
        self.failures: list[Failure] = []

    def initialise(self) -> None:
        self.current, self.failures = 0, []

    def advance(self) -> None:
        while self.current < len(self.children):
            step = self.children[self.current]
            step.tick_once()
            if step.status == Status.RUNNING:
                return
            self.current += 1
            if step.status == Status.FAILURE and self._ends_it(failure_of(step)):
                break
        self.status = self.fail(self._failure()) if self.failures else Status.SUCCESS

    def _ends_it(self, failure: Failure) -> bool:
        self.failures.append(failure)
        ends = failure.stop or failure.bygone or failure.anew
        if not ends and self.current < len(self.children):
            self.run.log(f"{failure.words()} (the rest of `finally` runs)", failure.step)
        return ends

    def _failure(self) -> Failure:
        first = gravest(self.failures)
        return replace(first, others=tuple(one for one in self.failures if one is not first))
