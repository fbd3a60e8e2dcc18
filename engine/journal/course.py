"""The course of a run: what every reader of its journal knows, whatever else it looks for.

What the engine remembers, a report, the page's picture and torture's account are each a course that
learns more of its own. Such a reader looks at a record while the course still says what was before it.
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

from ...schemas import journal as j
from .past import PASS

MAIN = "main/"
"""Goals elsewhere (in `on_resume` and `finally`) move devices outside the protocol's own order."""
BY_COMMANDS = (j.Changed, j.Redo)
"""What a command writes, not an engine."""


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal that has not ended; `session`: the number of the engine session that sent it."""

    record: j.GoalSent
    path: str
    attempt: int
    session: int


@dataclass(frozen=True, slots=True)
class Hole:
    """One iteration that failed; `key` is that of its row (`A/0,0` within another iteration).

    Outside any loop, one step and its own path without `main/`.
    """

    path: str
    key: str
    message: str


@dataclass(slots=True)
class Course:
    """How far a run is, as of the last record that was taken.

    `session`: the number of the present engine session. `resumes`: how often `on_resume` was due.
    `failed`: by path, the iterations that failed and were left out; `_within`: by path, those that
    are or were below it. `stands`: by path, the iteration (or the step outside any) at which the run
    failed by a `once` action that had happened: a plain resume fails there again. `_happened`,
    `_stopped_at`: such actions, by path, and the iterations in which the loops around them have ended.
    `over`: it has ended, or is about to say so. `under_way`, `open_questions`: by the goal's id, and by
    path. `last_at`: when an engine wrote a record last.
    """

    started: j.Started | None = None
    finished: j.Finished | None = None
    over: bool = False
    changes: list[j.Changed] = field(default_factory=list)
    redone: list[j.Redo] = field(default_factory=list)
    session: int = 1
    resumes: int = 0
    phase: str = ""
    paused: bool = False
    aborted_by: str = ""
    under_way: dict[str, Goal] = field(default_factory=dict)
    open_questions: dict[str, j.Asked] = field(default_factory=dict)
    failed: dict[str, Hole] = field(default_factory=dict)
    stands: dict[str, Hole] = field(default_factory=dict)
    _happened: dict[str, str] = field(default_factory=dict)
    _stopped_at: dict[str, Hole] = field(default_factory=dict)
    _within: dict[str, set[str]] = field(default_factory=dict)
    last_n: int = 0
    last_hash: str = ""
    last_at: str = ""

    def take(self, record: j.Record) -> None:
        """Learn what one record says, after all those before it."""
        match record:  # the frequent ones first, as in `History`
            case j.GoalSent():
                path, attempt = split_goal_id(record.id)
                self.under_way[record.id] = Goal(record, path, attempt, self.session)
                self._happened.pop(path, None)
            case j.GoalEnded():
                self._take_outcome(self.under_way.pop(record.id, None), record)
            case j.IterationEnded():
                self._take_end(f"{record.loop}/{record.key}", record)
            case j.Marked() | j.StepEnded():
                pass
            case j.Started():
                self.started = record
            case j.Resumed():
                self.session, self.resumes = self.session + 1, record.count
                self.finished, self.paused, self.aborted_by, self.over = None, False, "", False
                self.open_questions.clear()
            case j.Changed():
                self.changes.append(record)
                self.open_questions.clear()
                for path in record.reopened:
                    self.failed.pop(path, None)
                self.stands.clear()
            case j.Redo():
                self.redone.append(record)
                self.finished, self.over = None, False
                for path in record.iterations:
                    self._forget_holes(path)
                    self._leave(path)
            case j.Phase():
                self.phase = record.phase
                name, _, number = record.phase.partition(":")
                if name == "resume":
                    self.resumes = max(self.resumes, int(number))
            case j.Asked():
                self.open_questions[record.path] = record
            case j.Answered():
                self.open_questions.pop(record.path, None)
            case j.Control():
                self.paused = record.verb == "pause"
                if record.verb.startswith("abort"):
                    self.aborted_by = record.by
            case j.LoopEnded():
                self._take_loop(record)
            case j.Finished():
                self.finished, self.paused = record, False
                self.open_questions.clear()
                self.end(record.fate, record.detail)
                self._stopped_at.clear()
            case _:
                pass
        self.last_n, self.last_hash = record.n, record.hash
        if type(record) not in BY_COMMANDS:
            self.last_at = record.at

    def end(self, fate: j.RunFate, detail: str) -> None:
        """The run ends like this: where it stands is counted, in its last record, too."""
        self.over = True
        if fate == "failed":
            self._take_failure(detail)

    def _take_outcome(self, goal: Goal | None, record: j.GoalEnded) -> None:
        if goal is None or record.error is None or record.error.happened != "yes":
            return
        if goal.record.effect == "once" and goal.path.startswith(MAIN):
            self._happened[goal.path] = record.error.message

    def _take_loop(self, record: j.LoopEnded) -> None:
        if record.fate != "failed":
            return
        for path, message in self._happened.items():
            if path.startswith(f"{record.loop}/"):
                key = path.removeprefix(f"{record.loop}/").partition("/")[0]
                self._stopped_at.setdefault(path, Hole(f"{record.loop}/{key}", key, message))

    def _take_failure(self, detail: str) -> None:
        for path, message in self._happened.items():
            if detail.startswith(f"{path}: "):
                hole = self._stopped_at.get(path) or _step(path, message)
                self.stands[hole.path] = hole

    def _take_end(self, place: str, record: j.IterationEnded) -> None:
        """Of an iteration that failed with holes inside, only itself is a hole."""
        self._leave(place)
        if record.fate == "failed" and place.startswith(MAIN):
            self._forget_holes(place)
            self.failed[place] = Hole(place, record.row_key, record.message)
            for end in (i for i, character in enumerate(place) if character == "/"):
                self._within.setdefault(place[:end], set()).add(place)
        else:
            self.failed.pop(place, None)

    def _forget_holes(self, path: str) -> None:
        for inner in (path, *self._within.pop(path, ())):
            self.failed.pop(inner, None)

    def _leave(self, path: str) -> None:
        """An iteration is over, or entered anew: what failed in it no longer counts."""
        for known in (self._happened, self.stands):
            for inner in [one for one in known if f"{one}/".startswith(f"{path}/")]:
                del known[inner]

    @property
    def inputs(self) -> j.Started | j.Changed | None:
        """The newest record of what the run is made from: parameters, roles, files."""
        return self.changes[-1] if self.changes else self.started

    @property
    def params(self) -> dict[str, Any]:
        """The parameters that the run has now."""
        return self.inputs.params if self.inputs is not None else {}

    @property
    def roles(self) -> dict[str, str]:
        """Role -> device."""
        return self.inputs.roles if self.inputs is not None else {}

    @property
    def holes_by_path(self) -> dict[str, Hole]:
        """The iterations that can be measured again, in the order in which they failed."""
        return self.failed | self.stands

    @property
    def hole_count(self) -> int:
        """How many iterations can be measured again."""
        return len(self.failed) + len(self.stands)

    def stood(self, loops: Collection[str]) -> int:
        """At how many iterations of these loops the run stands, now that it has ended."""
        return sum(path.rpartition("/")[0] in loops for path in self.stands) if self.over else 0


def _step(path: str, message: str) -> Hole:
    """The step of an action, whichever pass it was."""
    step = path.partition(f"/{PASS}")[0]
    return Hole(step, step.removeprefix(MAIN), message)


def split_goal_id(goal_id: str) -> tuple[str, int]:
    """`run/main/scan/0,0/shoot/2` -> its path without the run, and the attempt."""
    path, _, attempt = goal_id.partition("/")[2].rpartition("/")
    return path, int(attempt)
