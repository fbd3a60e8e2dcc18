"""What all nodes share: a failure and a result; and how to read those of any tree."""

from collections.abc import Iterator
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...run.run import Run
from .failure import Failure

REPLAYED = "replayed"
"""Set on the root of what is replayed."""
UNTOLD = Failure("Fault", "a node failed without a reason")


class Node(Behaviour):
    """A leaf, or a node with children that it ticks itself. Never waits, never raises."""

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


class Parent(Node):
    """A node with children: `step` is what it does in one tick and yields the nodes it visits."""

    def __init__(self, name: str, run: Run, children: list[Behaviour]) -> None:
        super().__init__(name, run)
        for child in children:
            self.children.append(child)
            child.parent = self

    def advance(self) -> Iterator[Behaviour]:
        """Tick children as needed and set `self.status`."""
        raise NotImplementedError

    def tick(self) -> Iterator[Behaviour]:
        """One tick: start if not RUNNING, advance, and end the children that are left running."""
        if self.status != Status.RUNNING:
            self.failure, self.result = None, None
            self.status = Status.RUNNING
            self.initialise()
        if self.status == Status.RUNNING:
            yield from self.advance()
        if self.status != Status.RUNNING:
            self.stop(self.status)
        yield self

    def update(self) -> Status:
        """What `advance` has decided; py_trees asks leaves only."""
        return self.status

    def stop(self, new_status: Status) -> None:
        """Interrupt running children, then end."""
        for child in self.children:
            if child.status == Status.RUNNING:
                child.stop(Status.INVALID)
        self.terminate(new_status)
        self.status = new_status


def failure_of(node: Behaviour) -> Failure:
    """Why a node failed, looked up where py_trees' own composites hide it."""
    if isinstance(node, Node):
        return node.failure or UNTOLD
    if isinstance(node, py_trees.composites.Sequence) and node.current_child is not None:
        return failure_of(node.current_child)
    return UNTOLD


def result_of(node: Behaviour) -> Any:
    """The result of a node; that of a sequence is its last step's."""
    if isinstance(node, Node):
        return node.result
    if isinstance(node, py_trees.composites.Sequence) and node.children:
        return result_of(node.children[-1])
    return None
