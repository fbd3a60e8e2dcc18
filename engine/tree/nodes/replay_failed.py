"""What failed before the engine died is replayed up to where it had got.

A retried group or a fallback that had moved on to its next branch before a crash does not start
there: what its earlier branches had set on the devices, and assigned to names, would be missing. So
each of them is ticked again as bygone: finished actions count as done, those whose device was touched
since are repeated, and at the first action that was never finished it fails, as it had.
"""

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from .failure import Failure
from .node import REPLAYED, failure_of


def came_to_here(path: str) -> Failure:
    """The failure of a bygone step that an earlier session never finished."""
    return Failure("Unfinished", "the engine was killed before this", step=path, bygone=True)


def replay_failed(child: Behaviour) -> None:
    """Tick what failed in an earlier session; nothing in it is started that was not finished."""
    setattr(child, REPLAYED, True)
    try:
        child.tick_once()
    finally:
        setattr(child, REPLAYED, False)


def failed_anew(child: Behaviour) -> Failure | None:
    """The failure of something repeated in a bygone branch, which is not a bygone failure itself."""
    if child.status != Status.FAILURE:
        return None
    failure = failure_of(child)
    return failure if failure.anew else None
