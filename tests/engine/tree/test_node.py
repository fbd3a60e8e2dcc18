"""What all nodes of the tree do alike."""

import pytest
from py_trees.common import Status

from labrun.engine.tree.nodes.failure import Failure
from labrun.engine.tree.nodes.in_order import InOrder
from labrun.engine.tree.nodes.node import Node


class FailsOnce(Node):
    """Fails in its first turn."""

    turns = 0

    def update(self):
        self.turns += 1
        if self.turns == 1:
            self.result = "half of it"
            return self.fail(Failure("Broken", "it broke"))
        return Status.SUCCESS


@pytest.mark.parametrize("of", [lambda leaf: leaf, lambda leaf: InOrder("steps", None, [leaf])])
def test_what_has_failed_and_is_ticked_again_keeps_nothing_of_its_failure(of):
    node = of(FailsOnce("shot", None))
    node.tick_once()
    failed = node.status, node.failure
    node.tick_once()

    assert failed == (Status.FAILURE, Failure("Broken", "it broke"))
    assert (node.status, node.failure, node.result) == (Status.SUCCESS, None, None)
