"""What a journal says has happened: the memory from which a run goes on."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from ..schemas import journal as j
from .journal import JournalFault

TOUCHING_PHASES = ("resume:", "finally:")


@dataclass(slots=True)
class PastGoal:
    """One goal of an earlier life of the engine; `ended` is None while its fate is not known."""

    sent: j.GoalSent
    ended: j.GoalEnded | None = None
    ended_n: int = 0
    spent: bool = False


@dataclass(slots=True)
class LoopCounts:
    """How the iterations of one loop ended."""

    succeeded: int = 0
    failed: int = 0
    skipped: int = 0

    def add(self, fate: j.StepFate) -> None:
        """Count one more iteration."""
        if fate == "succeeded":
            self.succeeded += 1
        elif fate == "skipped":
            self.skipped += 1
        else:
            self.failed += 1

    @property
    def total(self) -> int:
        """Iterations that are over."""
        return self.succeeded + self.failed + self.skipped


@dataclass(slots=True)
class History:
    """Finished work by path. What lies in finished iterations is forgotten but for its count.

    `spent`: the run had come to an end (failed, aborted) and is taken up again: failures before
    that are not counted against the retries, but their attempt numbers are not used again.
    """

    started: j.Started | None = None
    finished: j.Finished | None = None
    phase: str = ""
    resumes: int = 0
    resumed_n: int = 0
    finals: int = 0
    holes: int = 0
    last_n: int = 0
    last_at: str = ""
    goals: dict[str, dict[int, PastGoal]] = field(default_factory=dict)
    iterations: dict[str, dict[str, j.StepFate]] = field(default_factory=dict)
    counts: dict[str, LoopCounts] = field(default_factory=dict)
    sets: dict[str, dict[str, Any]] = field(default_factory=dict)
    steps: dict[str, j.StepEnded] = field(default_factory=dict)
    turns: dict[str, j.Turned] = field(default_factory=dict)
    answers: dict[str, j.Answered] = field(default_factory=dict)
    touched: dict[str, int] = field(default_factory=dict)
    boots: dict[str, str] = field(default_factory=dict)

    def goal(self, path: str, attempt: int) -> PastGoal | None:
        """What is known of one attempt at one path."""
        return self.goals.get(path, {}).get(attempt)

    def last_attempt(self, path: str) -> int:
        """The highest attempt number ever used at a path."""
        return max(self.goals.get(path, {0: None}))

    def touch(self, device: str, n: int) -> None:
        """A device was moved or set outside the protocol's own order, at record `n`."""
        self.touched[device] = n

    def is_stale(self, past: PastGoal) -> bool:
        """True when the device was touched since this goal ended, so its state may be gone."""
        return self.touched.get(past.sent.device, 0) > past.ended_n

    def lost_with_an_engine(self, past: PastGoal) -> bool:
        """True for a goal that an earlier engine had sent, and that its server lost, too.

        That is no failure of the step, which is simply unfinished: what may be sent again is sent
        again, and its retries are not counted down.
        """
        error = past.ended.error if past.ended else None
        return error is not None and error.name == "Lost" and past.sent.n < self.resumed_n

    def forget(self, prefix: str) -> None:
        """Drop what lies under a finished iteration."""
        for table in (self.goals, self.iterations, self.counts, self.sets, self.steps):
            _drop(table, prefix)
        for table in (self.turns, self.answers):
            _drop(table, prefix)

    def spend(self) -> None:
        """The run had ended: its failures are over, and what failed has all its tries again."""
        self.turns.clear()
        self.answers.clear()
        for tries in self.goals.values():
            for past in tries.values():
                past.spent = past.ended is not None and past.ended.state != "SUCCEEDED"
        for path in [path for path, step in self.steps.items() if step.fate != "succeeded"]:
            del self.steps[path]

    def open_goals(self) -> list[PastGoal]:
        """Goals that were sent and whose outcome is not in the journal."""
        return [g for tries in self.goals.values() for g in tries.values() if g.ended is None]


def _drop(table: dict[str, Any], prefix: str) -> None:
    for path in [path for path in table if path.startswith(prefix)]:
        del table[path]


def split_goal_id(goal_id: str) -> tuple[str, int]:
    """`run/main/scan/0,0/shoot/2` -> its path without the run, and the attempt."""
    path, _, attempt = goal_id.partition("/")[2].rpartition("/")
    return path, int(attempt)


def read_history(records: Iterable[j.JournalRecord]) -> History:
    """Read a journal's records into a history."""
    history = History()
    for record in records:
        _read(history, record)
        history.last_n, history.last_at = record.n, record.at
    if history.started is None:
        raise JournalFault("the journal holds no start of a run: there is nothing to go on with")
    return history


def _read(history: History, record: j.JournalRecord) -> None:
    match record:
        case j.Started():
            history.started = record
        case j.Resumed():
            history.resumes, history.resumed_n = record.count, record.n
            if history.finished is not None:
                history.spend()
            history.finished = None
        case j.Phase():
            history.phase = record.phase
            if record.phase.startswith("finally:"):
                history.finals += 1
        case j.GoalSent():
            path, attempt = split_goal_id(record.id)
            history.goals.setdefault(path, {})[attempt] = PastGoal(record)
            if history.phase.startswith(TOUCHING_PHASES):
                history.touch(record.device, record.n)
            history.boots[record.device] = record.boot
        case j.GoalEnded():
            path, attempt = split_goal_id(record.id)
            past = history.goals[path][attempt]
            past.ended, past.ended_n = record, record.n
            past.spent = history.lost_with_an_engine(past)
        case j.IterationEnded():
            prefix = f"{record.loop}/{record.key}/"
            history.forget(prefix)
            history.holes += record.fate == "failed"
            history.iterations.setdefault(record.loop, {})[record.key] = record.fate
            history.counts.setdefault(record.loop, LoopCounts()).add(record.fate)
            if record.sets:
                history.sets.setdefault(record.loop, {}).update(record.sets)
        case j.StepEnded():
            history.steps[record.path] = record
        case j.Turned():
            history.turns[record.path] = record
        case j.Answered():
            history.answers[record.path] = record
        case j.SafeState():
            history.touch(record.device, record.n)
        case j.Finished():
            history.finished = record
        case _:
            return
