"""Steps of `finally`: one after the other, and each of them, whatever became of those before it."""

from dataclasses import replace

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from .action_set import gravest
from .failure import Failure
from .in_order import InOrder
from .node import failure_of


class EveryStep(InOrder):
    """Fails when all have ended and one has failed: with the gravest failure, the first of several.

    Only a person's `stop`, or the point that an earlier engine session had reached, ends it before.
    """

    def initialise(self) -> None:
        super().initialise()
        self.failures: list[Failure] = []

    def ended_by(self, step: Behaviour) -> bool:
        """A step has failed: whether the rest of them is left out."""
        failure = failure_of(step)
        self.failures.append(failure)
        ends = failure.stop or failure.bygone or failure.anew
        if not ends and self.current < len(self.children):
            self.run.log(f"{failure.words()} (the rest of `finally` runs)", failure.step)
        return ends

    def end(self) -> None:
        """All of its steps are over, or one of them has ended it."""
        if not self.failures:
            self.status = Status.SUCCESS
            return
        first = gravest(self.failures)
        others = tuple(one for one in self.failures if one is not first)
        self.status = self.fail(replace(first, others=others))
