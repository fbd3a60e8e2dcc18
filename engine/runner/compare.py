"""Compare a changed protocol with finished work: replayed in memory, nothing is sent.

The changed protocol's own tree is run against the journal. Each finished action counts as done,
and how it was done is compared with what the changed protocol asks for.
"""

import asyncio
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ...drivers.client.client import Outcome
from ...schemas import journal as j
from ...schemas.plainest import plainest
from ..check import Checked
from ..control.control import Control
from ..dispatch.dispatcher import Dispatcher
from ..dispatch.request import Request
from ..journal.history import read_history
from ..journal.journal import Journal, R
from ..journal.past import PastGoal
from ..run.clock import RunClock
from ..run.frame import Frame, Scope
from ..run.function_calls import call_at_once
from ..run.questions import Questions
from ..run.run import Run
from ..run.virtual_time import VirtualLoop
from ..tree.compile import TreeCompiler
from ..tree.tick import run_tree


@dataclass(frozen=True, slots=True)
class Difference:
    """One finished action that differs in the changed protocol, or one that is new."""

    path: str
    within: str
    label: str
    effect: str
    was: dict[str, Any] | None
    now: dict[str, Any]
    instead_of: str = ""
    """The action that was done at its path, where the changed protocol has another, or has it elsewhere."""
    means: str = ""

    def words(self) -> str:
        """`libs.measure: power 10 -> 12`."""
        if self.instead_of:
            return f"{self.instead_of} is {self.label} now"
        if self.was is None:
            return f"{self.label} is new"
        names = sorted({*self.was, *self.now})
        changed = [
            f"{name} {self.was.get(name, 'not given')} -> {self.now.get(name, 'not given')}"
            for name in names
            if self.was.get(name) != self.now.get(name)
        ]
        return f"{self.label}: {', '.join(changed) or 'different contract or role'}"


@dataclass(slots=True)
class Comparison:
    """What was found: differences, in order, and what they mean for finished work."""

    agreeing: int = 0
    differences: list[Difference] = field(default_factory=list)
    undone: list[Difference] = field(default_factory=list)
    """Finished `once` actions that differ in the changed protocol: they prevent the resume."""
    doubtful: list[tuple[Difference, str]] = field(default_factory=list)
    """Finished `once` actions, by path, that followed an action which differs now."""
    reopened: list[str] = field(default_factory=list)


def compare(checked: Checked, records: Sequence[j.JournalRecord]) -> Comparison:
    """Compare a changed protocol with a journal."""
    with (
        tempfile.TemporaryDirectory(prefix="labrun-compare-") as folder,
        asyncio.Runner(loop_factory=VirtualLoop) as runner,
    ):
        return runner.run(_compare(checked, records, Path(folder)))


async def _compare(
    checked: Checked, records: Sequence[j.JournalRecord], folder: Path
) -> Comparison:
    assert checked.protocol is not None and checked.lab is not None
    history = read_history(records, comparing=True)
    assert history.started is not None
    journal = Unwritten(folder / "journal.jsonl", sync=False)
    clock = RunClock.virtual(asyncio.get_running_loop().time)
    about = {
        "id": history.started.run, "name": checked.protocol.name, "simulated": checked.lab.lab.simulated,
        "started": history.started.began,
    }  # fmt: skip
    run = Run(
        id=history.started.run, folder=folder, journal=journal, history=history, roles=checked.roles,
        params=checked.params, about=about, questions=Questions(yes=True), clock=clock,
        past=history.past.copy(),
    )  # fmt: skip
    run.call = call_at_once
    run.questions.person = lambda question: question.choices[0]
    dispatcher = _Comparing(run)
    control = Control(run, dispatcher.wake.set)
    assert checked.survey is not None
    compiler = TreeCompiler(run, dispatcher, checked.survey, folder)
    names = {"params": run.params, "run": about, "csv": checked.survey.tables}
    frame = Frame.phase("main", names)
    root = compiler.sequence(checked.protocol.steps, Scope(frame))
    await run_tree(root, run, dispatcher, control, abortable=False)
    journal.close()
    finished = {f"{r.loop}/{r.key}" for r in records if isinstance(r, j.IterationEnded)}
    return dispatcher.found(finished)


class Unwritten(Journal):
    """A journal that keeps nothing: a comparison leaves no trace."""

    def append(self, record: R) -> R:
        self.count += 1
        return record.model_copy(update={"n": self.count})


class _Comparing(Dispatcher):
    """Sends nothing: notes what was replayed, and counts as done what would have to be sent."""

    def __init__(self, run: Run) -> None:
        super().__init__(run, {})
        self._comparison = Comparison()
        self._seen: set[str] = set()

    def request(self, request: Request, *, first: bool = False) -> Request:
        open_goal = request.adopt
        if open_goal is None:
            self._differs(request, None)
        elif open_goal.sent.means != request.means():
            difference = self._differs(request, open_goal)
            if _is_once(request, open_goal):  # it may have happened as it was requested
                self._comparison.undone.append(difference)
        result = plainest({**request.action.returns, "type": "object"})
        request.outcome = Outcome("SUCCEEDED", result=result)
        self.wake.set()
        self.run.requests.again()
        return request

    def another_watch(self, path: str, was: str, now: str) -> None:
        difference = Difference(
            path, path, f"one for {now}", "once", None, {}, f"the watch that was right ({was})"
        )
        self._comparison.undone.append(difference)

    def replayed(self, request: Request, past: PastGoal) -> None:
        self._seen.add(request.path)
        if past.sent.means == request.means():
            if request.action.effect == "once":
                self._doubt(request)
            self._comparison.agreeing += 1
            return
        difference = self._differs(request, past)
        if _is_once(request, past) and _may_have_happened(past):
            self._comparison.undone.append(difference)

    def _differs(self, request: Request, past: PastGoal | None) -> Difference:
        self._seen.add(request.path)
        other = past is not None and past.sent.action != request.action_name
        difference = Difference(
            request.path, request.within, request.label, request.action.effect,
            None if past is None else past.sent.params, request.params,
            past.sent.label if past is not None and other else "", request.means(),
        )  # fmt: skip
        self._comparison.differences.append(difference)
        return difference

    def _doubt(self, request: Request) -> None:
        """A shot after a move that would now go elsewhere: it no longer means the same."""
        for earlier in self._comparison.differences:
            if earlier.effect != "pure" and request.path.startswith(f"{earlier.within}/"):
                self._comparison.doubtful.append((earlier, request.path))
                return

    def _find_moved(self) -> None:
        """A shot that is done, and would be a new step at another place: it would be fired again."""
        done = {
            (path, goal.sent.means)
            for path, tries in self.run.history.past.goals.items()
            for goal in tries.values()
            if path not in self._seen and goal.sent.effect == "once" and _may_have_happened(goal)
        }
        for new in self._comparison.differences:
            if new.was is not None or new.effect != "once":
                continue
            for path, means in done:
                if means == new.means and path.startswith(f"{new.within}/"):
                    moved = replace(new, path=path, instead_of=new.label, label=new.path)
                    self._comparison.undone.append(moved)

    def found(self, finished: set[str]) -> Comparison:
        """The comparison; `finished` are the paths of iterations that had ended."""
        self._find_moved()
        reopened: dict[str, None] = {}
        for difference in self._comparison.differences:
            path = difference.path
            while path:
                path = path.rpartition("/")[0]
                if path in finished:
                    reopened[path] = None
        self._comparison.reopened = list(reopened)
        return self._comparison


def _is_once(request: Request, past: PastGoal) -> bool:
    return "once" in (request.action.effect, past.sent.effect)


def _may_have_happened(past: PastGoal) -> bool:
    if past.ended is None or past.succeeded:
        return True
    return past.ended.error is None or past.ended.error.happened != "no"
