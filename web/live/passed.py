"""Steps that a run has gone past without a record: skipped ones, and those that only compute.

A journal says nothing of a step whose `when` was false, nor of `set` and `require`. What stands
before a step that has begun, in the same list, is behind the run all the same.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from ...schemas import protocol as p
from ..models.runs import Status
from .outline import Outline, Step

SILENT = (p.Set, p.Require)
"""Done without a record."""


def passed(
    outline: Outline, begun: Collection[str], round_done: Callable[[str], bool], over: bool
) -> dict[str, Status]:
    """Path -> `skipped` or `ok` of the steps that are behind the run and not in `begun`.

    `round_done` says of a loop whether an iteration of it has succeeded, `over` whether the
    whole run has.
    """
    walk = _Walk(begun, round_done)
    for phase in outline.phases.values():
        walk.sequence(phase.values(), over)
    return walk.found


class _Walk:
    """Goes through lists from their ends, where it is known how far the run is."""

    def __init__(self, begun: Collection[str], round_done: Callable[[str], bool]) -> None:
        self.found: dict[str, Status] = {}
        self._begun = begun
        self._round_done = round_done

    def sequence(self, steps: Iterable[Step], behind: bool) -> None:
        """Steps one after the other; `behind`: what comes after them has begun."""
        for step in reversed(list(steps)):
            if step.told.path in self._begun:
                self._inside(step, behind)
                behind = True
            elif behind:
                self._mark(step)

    def _inside(self, step: Step, behind: bool) -> None:
        """What is in a step that has begun itself."""
        if step.is_loop:
            self.sequence(step.below.values(), self._round_done(step.told.path))
        elif isinstance(step.step, p.If):
            for branch in step.below.values():
                if any(one.told.path in self._begun for one in branch.below.values()):
                    self.sequence(branch.below.values(), behind)
                elif behind:
                    self._mark_all(branch.below)
        elif isinstance(step.step, p.Parallel | p.AnyOf):
            for member in step.below.values():
                self.sequence([member], behind)
        else:
            self.sequence(step.below.values(), behind)
        self.sequence(step.last.values(), behind)

    def _mark(self, step: Step) -> None:
        """It is behind the run, and nothing was heard of it or of what is in it."""
        quiet = all(isinstance(one, SILENT) for one in _leaves(step))
        self.found[step.told.path] = "ok" if quiet and not _may_be_skipped(step) else "skipped"
        self._mark_all(step.below)
        self._mark_all(step.last)

    def _mark_all(self, steps: Mapping[str, Step]) -> None:
        for step in steps.values():
            if step.step is None:  # a branch of an `if`, which is no row of its own
                self._mark_all(step.below)
            else:
                self._mark(step)


def _leaves(step: Step) -> Iterator[object]:
    """The steps in a step that hold no others."""
    if not step.below:
        yield step.step
    for one in step.below.values():
        yield from _leaves(one)


def _may_be_skipped(step: Step) -> bool:
    return getattr(step.step, "when", None) is not None
