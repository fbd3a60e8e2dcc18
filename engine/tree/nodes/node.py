"""What all nodes share: how they are ticked, a failure and a result; and how to read those of any."""

from collections.abc import Iterator
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.run import Run
from .failure import Failure

REPLAYED = "replayed"
"""Set on the root of what is replayed."""
UNTOLD = Failure("Fault", "a node failed without a reason")


class Node(Behaviour):
    """A leaf, or a node with children that it ticks itself. Never waits, never raises.

    It is ticked as py_trees has it, without the generators: those hand every node that was visited up
    through all of its ancestors, where nobody asks for it.
    """

    def __init__(self, name: str, run: Run) -> None:
        super().__init__(name)
        self.run = run
        self.failure: Failure | None = None
        self.result: Any = None

    @property
    def replaying(self) -> bool:
        """True while it is ticked in what failed in an earlier engine session: see replay_failed.py."""
        node: Behaviour | None = self
        while node is not None and not getattr(node, REPLAYED, False):
            node = node.parent
        return node is not None

    def fail(self, failure: Failure) -> Status:
        """End in FAILURE, with the reason."""
        self.failure = failure
        return Status.FAILURE

    def tick_once(self) -> None:
        """One tick: start if not RUNNING, then update."""
        if self.status != Status.RUNNING:
            self.failure, self.result = None, None
            self.initialise()
        new_status = self.update()
        if new_status != Status.RUNNING:
            self.stop(new_status)
        self.status = new_status

    def tick(self) -> Iterator[Behaviour]:
        """For py_trees' own classes around it: of what a tick visits they are given only this node."""
        self.tick_once()
        yield self

    def stop(self, new_status: Status) -> None:
        """End, or be interrupted."""
        self.terminate(new_status)
        self.status = new_status


class Parent(Node):
    """A node with children: `advance` is what it does in one tick."""

    def __init__(self, name: str, run: Run, children: list[Behaviour]) -> None:
        super().__init__(name, run)
        for child in children:
            self.children.append(child)
            child.parent = self

    def advance(self) -> None:
        """Tick children as needed and set `self.status`."""
        raise NotImplementedError

    def tick_once(self) -> None:
        """One tick: start if not RUNNING, advance, and end the children that are left running."""
        if self.status != Status.RUNNING:
            self.failure, self.result = None, None
            self.status = Status.RUNNING
            self.initialise()
        if self.status == Status.RUNNING:
            self.advance()
        if self.status != Status.RUNNING:
            self.stop(self.status)

    def update(self) -> Status:
        """What `advance` has decided; py_trees asks leaves only."""
        return self.status

    def stop(self, new_status: Status) -> None:
        """Interrupt running children, then end."""
        for child in self.children:
            if child.status == Status.RUNNING:
                child.stop(Status.INVALID)
        super().stop(new_status)


def failure_of(node: Behaviour) -> Failure:
    """Why a node failed."""
    return (node.failure if isinstance(node, Node) else None) or UNTOLD


def result_of(node: Behaviour) -> Any:
    """The result of a node; that of a sequence is its last step's."""
    return node.result if isinstance(node, Node) else None
