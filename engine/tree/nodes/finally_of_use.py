"""The `finally` of used protocols: started by themselves, or at once by the step that stopped them."""

from collections import deque
from collections.abc import Iterable

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import Turned
from ...run.frame import Frame, Scope
from ...run.run import Run
from .failure import Failure
from .node import Node, failure_of


def finals_before(run: Run, path: str, *, replaying: bool) -> int:
    """How many times the `finally` of this `use` has finished, its steps tried again since.

    One that was started but has not finished continues under its own ids.
    """
    past = run.past.turned.get(f"{path}/e")
    if past is None:
        return 0
    return past.turn if run.past.is_over(past) and not replaying else past.turn - 1


def begin_finally(
    run: Run, path: str, *, failure: Failure | None, stopped: bool, replaying: bool
) -> Frame:
    """The frame of the next `finally` of this `use`.

    If it failed or was stopped, that is in the journal: if its steps are continued after that,
    another `finally` is due, not the rest of this one.
    """
    past = run.past.turned.get(f"{path}/e")
    is_over = past is not None and past.error is None and not (stopped or replaying)
    final = run.finals.begin(path, past.turn if past is not None and is_over else 0)
    known = past is not None and past.turn >= final.begun
    if (failure is not None or stopped) and not known and not replaying:
        error = None if failure is None else failure.as_error()
        run.record(Turned(path=f"{path}/e", turn=final.begun, error=error))
    return Frame.phase(f"{path}/finally:{final.begun}", final.names, final.frame)


class FinallyOfUse:
    """Runs every `finally` that is due under some paths, the innermost first.

    Each is taken off the run's list when it is over: an abort in between leaves it to the run's end.
    """

    def __init__(self, step: Node, paths: Iterable[str]) -> None:
        self.step, self.run = step, step.run
        self.due = deque(self.run.finals.under(paths))
        self.root: Behaviour | None = None

    def tick_once(self) -> None:
        """One tick; over when `due` is empty."""
        while self.due:
            path = self.due[0]
            root = self.root = self.root or self._build(path)
            root.tick_once()
            if root.status == Status.RUNNING:
                return
            failure = failure_of(root) if root.status == Status.FAILURE else None
            if failure is not None:
                self.run.log(f"finally: {failure.words()}", path)
            self.run.finals.end(path, unfinished=failure is not None and failure.bygone)
            self.due.popleft()
            self.root = None

    def stop(self) -> None:
        """Interrupt what runs."""
        if self.root is not None and self.root.status == Status.RUNNING:
            self.root.stop(Status.INVALID)

    def _build(self, path: str) -> Behaviour:
        frame = begin_finally(
            self.run, path, failure=None, stopped=True, replaying=self.step.replaying
        )
        root = self.run.finals.of(path).build(Scope(frame))
        root.parent = self.step
        return root
