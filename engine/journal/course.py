"""The course of a run: what every reader of its journal knows, whatever else it looks for.

What the engine remembers, a report, the page's picture and torture's account are each a course that
learns more of its own. Such a reader looks at a record while the course still says what was before it.
"""

from dataclasses import dataclass, field
from typing import Any

from ...schemas import journal as j

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


@dataclass(slots=True)
class Course:
    """How far a run is, as of the last record that was taken.

    `session`: the number of the present engine session. `resumes`: how often `on_resume` was due.
    `failed`: the paths of the holes; `_within`: by path, those that are or were below it.
    `under_way`, `open_questions`: by the goal's id, and by path. `last_at`: when an engine wrote a
    record last.
    """

    started: j.Started | None = None
    finished: j.Finished | None = None
    changes: list[j.Changed] = field(default_factory=list)
    redone: list[j.Redo] = field(default_factory=list)
    session: int = 1
    resumes: int = 0
    phase: str = ""
    paused: bool = False
    aborted_by: str = ""
    under_way: dict[str, Goal] = field(default_factory=dict)
    open_questions: dict[str, j.Asked] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)
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
            case j.GoalEnded():
                self.under_way.pop(record.id, None)
            case j.IterationEnded():
                self._take_end(f"{record.loop}/{record.key}", record.fate)
            case j.Marked() | j.StepEnded():
                pass
            case j.Started():
                self.started = record
            case j.Resumed():
                self.session, self.resumes = self.session + 1, record.count
                self.finished, self.paused, self.aborted_by = None, False, ""
                self.open_questions.clear()
            case j.Changed():
                self.changes.append(record)
                self.open_questions.clear()
                self.failed.difference_update(record.reopened)
            case j.Redo():
                self.redone.append(record)
                self.finished = None
                for path in record.iterations:
                    self._forget_holes(path)
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
            case j.Finished():
                self.finished, self.paused = record, False
                self.open_questions.clear()
            case _:
                pass
        self.last_n, self.last_hash = record.n, record.hash
        if type(record) not in BY_COMMANDS:
            self.last_at = record.at

    def _take_end(self, place: str, fate: str) -> None:
        """Of an iteration that failed with holes inside, only itself is a hole."""
        if fate == "failed" and place.startswith(MAIN):
            self._forget_holes(place)
            self.failed.add(place)
            for end in (i for i, character in enumerate(place) if character == "/"):
                self._within.setdefault(place[:end], set()).add(place)
        else:
            self.failed.discard(place)

    def _forget_holes(self, path: str) -> None:
        self.failed.discard(path)
        self.failed -= self._within.pop(path, set())

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
    def hole_count(self) -> int:
        """How many iterations are left out."""
        return len(self.failed)


def split_goal_id(goal_id: str) -> tuple[str, int]:
    """`run/main/scan/0,0/shoot/2` -> its path without the run, and the attempt."""
    path, _, attempt = goal_id.partition("/")[2].rpartition("/")
    return path, int(attempt)
