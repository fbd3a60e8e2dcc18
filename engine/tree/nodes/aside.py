"""A group in the background: steps with names and results of their own, beside those that follow."""

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.frame import Scope
from ...run.run import Run
from .node import Parent, failure_of, result_of


class Aside(Parent):
    """Gives its steps a frame of their own: what they set and what they return is known to them alone."""

    def __init__(self, name: str, run: Run, outer: Scope, inner: Scope, child: Behaviour) -> None:
        super().__init__(name, run, [child])
        self.child = child
        self.outer = outer
        self.inner = inner

    def initialise(self) -> None:
        self.inner.frame = self.outer.frame.apart(f"{self.outer.frame.path}/{self.name}")

    def advance(self) -> None:
        self.child.tick_once()
        if self.child.status == Status.SUCCESS:
            self.result = result_of(self.child)
            self.status = Status.SUCCESS
        elif self.child.status == Status.FAILURE:
            self.status = self.fail(failure_of(self.child))
