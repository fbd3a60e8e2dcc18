"""Steps that a run has passed without a record: skipped ones, and those that only compute.

A journal has no record of a step whose `when` was false, or of `set` and `require`. The steps
before one that has begun, in the same list, have been passed nevertheless.
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
    """Path -> `skipped` or `ok` of the steps that the run has passed and that are not in `begun`.

    `round_done` tells whether an iteration of a loop has succeeded, `over` whether the whole run
    has.
    """
    walk = _Walk(begun, round_done)
    for name, phase in outline.phases.items():
        walk.sequence(phase.values(), over and name != "resume")
    return walk.found


class _Walk:
    """Goes through lists from their ends, where the run's progress is known."""

    def __init__(self, begun: Collection[str], round_done: Callable[[str], bool]) -> None:
        self.found: dict[str, Status] = {}
        self._begun = begun
        self._round_done = round_done

    def sequence(self, steps: Iterable[Step], behind: bool) -> None:
        """Steps in sequence; `behind`: a step after them has begun."""
        for step in reversed(list(steps)):
            if step.told.path in self._begun:
                self._inside(step, behind)
                behind = True
            elif behind:
                self._mark(step)

    def _inside(self, step: Step, behind: bool) -> None:
        """The steps inside a step that has begun."""
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
        """It has been passed, without a record of it or of the steps in it."""
        quiet = all(isinstance(one, SILENT) for one in _leaves(step))
        self.found[step.told.path] = "ok" if quiet and not _may_be_skipped(step) else "skipped"
        self._mark_all(step.below)
        self._mark_all(step.last)

    def _mark_all(self, steps: Mapping[str, Step]) -> None:
        for step in steps.values():
            if step.step is None:  # a branch of an `if`, which has no row
                self._mark_all(step.below)
            else:
                self._mark(step)


def _leaves(step: Step) -> Iterator[object]:
    """The innermost steps of a step."""
    if not step.below:
        yield step.step
    for one in step.below.values():
        yield from _leaves(one)


def _may_be_skipped(step: Step) -> bool:
    return getattr(step.step, "when", None) is not None
