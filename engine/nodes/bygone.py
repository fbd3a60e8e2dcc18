"""What failed before the engine died is gone through again up to where it had come.

A retried group or a fallback that had turned to its next way before a crash does not begin there:
what its earlier ways had set on the devices, and given to names, would be missing. So each of them is
ticked again as bygone: finished actions count as done, those whose device was touched since are
repeated, and at the first thing that was never finished it has failed, as it had.
"""

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ..failure import Failure
from ..run import Run
from .node import failure_of


def came_to_here(path: str) -> Failure:
    """The failure of a bygone step that an earlier life never finished."""
    return Failure("Unfinished", "the engine was killed before this", step=path, bygone=True)


def tick_bygone(run: Run, child: Behaviour) -> Iterator[Behaviour]:
    """Tick what has failed in an earlier life; nothing in it is begun that was not finished."""
    before, run.bygone = run.bygone, True
    try:
        yield from child.tick()
    finally:
        run.bygone = before


def failed_anew(child: Behaviour) -> Failure | None:
    """The failure of something repeated in a bygone way, which is no bygone failure itself."""
    if child.status != Status.FAILURE:
        return None
    failure = failure_of(child)
    return failure if failure.anew else None
