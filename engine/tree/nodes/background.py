"""Background actions: started here, joined by the loop or the group around them."""

from collections.abc import Callable

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.frame import Frame, Scope
from ...run.run import Run
from .action_set import gravest
from .node import Node, Parent, failure_of, result_of

Build = Callable[[Scope], Behaviour]


class Background(Node):
    """Starts a new small tree for its action and succeeds at once.

    A new tree is built each time, since the one of the last iteration may still be running.
    """

    def __init__(self, name: str, run: Run, scope: Scope, build: Build) -> None:
        super().__init__(name, run)
        self.scope = scope
        self.build = build

    def update(self) -> Status:
        frame = self.scope.frame
        aside = self.build(Scope(frame))
        aside.parent = self
        frame.joiner.pending.append(aside)
        # At once: its arguments have their values of now, and it is requested before what follows.
        aside.tick_once()
        self.run.requests.again()
        return Status.SUCCESS


def tick_pending(frame: Frame) -> None:
    """Tick everything in the background of a frame that has not ended."""
    for aside in frame.pending:
        if aside.status not in (Status.SUCCESS, Status.FAILURE):
            aside.tick_once()


def all_ended(frame: Frame) -> bool:
    """True when nothing in the background of this frame is running."""
    return all(aside.status in (Status.SUCCESS, Status.FAILURE) for aside in frame.pending)


def stop_pending(frame: Frame) -> None:
    """Interrupt what runs in the background."""
    for aside in frame.pending:
        if aside.status == Status.RUNNING:
            aside.stop(Status.INVALID)


class Join(Parent):
    """Steps outside loops: over when they and the background actions they started have ended."""

    def __init__(self, name: str, run: Run, outer: Scope, inner: Scope, child: Behaviour) -> None:
        super().__init__(name, run, [child])
        self.child = child
        self.outer = outer
        self.inner = inner
        self.steps_over = False

    def initialise(self) -> None:
        self.steps_over = False
        self.inner.frame = self.outer.frame.joining()

    def advance(self) -> None:
        frame = self.inner.frame
        if not self.steps_over:
            self.child.tick_once()
            self.steps_over = self.child.status != Status.RUNNING
        tick_pending(frame)
        if not self.steps_over or not all_ended(frame):
            return
        ended = (self.child, *frame.pending)
        failures = [failure_of(one) for one in ended if one.status == Status.FAILURE]
        self.result = result_of(self.child)
        self.status = self.fail(gravest(failures)) if failures else Status.SUCCESS

    def stop(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.status == Status.RUNNING:
            stop_pending(self.inner.frame)
        super().stop(new_status)
