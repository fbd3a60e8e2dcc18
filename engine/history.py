"""What a journal says has happened: the memory from which a run goes on."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..schemas import journal as j
from ..schemas.contract import Effect
from .journal import JournalFault

RESTARTED = "its server was started anew"
STRANGER = "somebody else had held or stopped it in between"
LAPSED = "no engine was heard of for as long as its lease: its server put it into its safe state"
ORDER_KEPT = 1000
REFUSALS = ("no", "stop")
TOUCHING_PHASES = ("resume:", "finally:")


@dataclass(slots=True)
class PastGoal:
    """One goal of an earlier life of the engine; `ended` is None while its fate is not known."""

    sent: j.GoalSent
    ended: j.GoalEnded | None = None
    ended_n: int = 0
    spent: bool = False

    @property
    def is_unknown(self) -> bool:
        """True where it ended, and its device did not say whether it had happened."""
        error = self.ended.error if self.ended is not None else None
        return error is not None and error.happened == "unknown"

    def was_under_way(self, n: int) -> bool:
        """True where it had been sent before record `n`, and its outcome came after it."""
        known_n = (
            self.ended.n if self.ended is not None else 0
        )  # none: it was asked after on resume
        return self.sent.n < n and not 0 < known_n < n


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
    begun_anew: bool = False
    spent_n: int = 0
    changed: j.Changed | None = None
    comparing: bool = False
    visited: set[str] = field(default_factory=set)
    gone_through: list[str] = field(default_factory=list)
    order: dict[str, deque[str]] = field(default_factory=dict)
    epochs: dict[str, set[int]] = field(default_factory=dict)
    touched: dict[str, int] = field(default_factory=dict)
    boots: dict[str, str] = field(default_factory=dict)

    def goal(self, path: str, attempt: int) -> PastGoal | None:
        """What is known of one attempt at one path."""
        return self.goals.get(path, {}).get(attempt)

    def newest_success(self, path: str) -> PastGoal | None:
        """The last attempt at a path that succeeded."""
        ended = (past for past in reversed(self.goals.get(path, {}).values()) if past.ended)
        return next((p for p in ended if p.ended and p.ended.state == "SUCCEEDED"), None)

    def knows_nothing_of(self, path: str) -> bool:
        """True where a comparison finds nothing to compare under this path."""
        return self.comparing and path not in self._visited()

    def _visited(self) -> set[str]:
        if not self.visited:
            known = (*self.goals, *self.steps, *self.gone_through)
            self.visited = {p for path in known for p in _above(path)}
        return self.visited

    def remember_order(self, device: str, goal_id: str, effect: Effect) -> None:
        """Keep in which order a device was asked for what happens once; the newest of them."""
        if effect == "once":
            self.order.setdefault(device, deque(maxlen=ORDER_KEPT)).append(goal_id)

    def was_before(self, device: str, goal_id: str, other: str) -> bool:
        """True where it is sure that the device was asked for `goal_id` before `other`."""
        order = self.order.get(device, deque())
        if other not in order:
            return False
        return goal_id not in order or order.index(goal_id) < order.index(other)

    def held_since(self, device: str, epoch: int) -> bool:
        """True where nobody but this run has held a device since that epoch."""
        ours = self.epochs.get(device, set())
        return epoch in ours and all(e in ours for e in range(epoch, max(ours) + 1))

    def somebody_was_there(self, device: str, epoch: int) -> bool:
        """True where a new lease does not follow this run's last one on a device."""
        ours = self.epochs.get(device)
        return bool(ours) and epoch not in (max(ours or {0}), max(ours or {0}) + 1)

    def touch(self, device: str, n: int) -> None:
        """A device was moved or set outside the protocol's own order, at record `n`."""
        self.touched[device] = n

    def is_over(self, turned: j.Turned) -> bool:
        """True where the run has come to an end since, and tries anew what had failed then."""
        return turned.n <= self.spent_n

    def is_before_change(self, turned: j.Turned) -> bool:
        """True where another protocol holds now than the one under which a way was chosen."""
        return self.comparing or (self.changed is not None and turned.n < self.changed.n)

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

    def forget_under_way(self, above: str, n: int) -> None:
        """Drop goals at a path that were under way at record `n`: nobody waited for them after it."""
        for path in [path for path in self.goals if f"{path}/".startswith(f"{above}/")]:
            tries = self.goals.pop(path)
            kept = {a: past for a, past in tries.items() if not past.was_under_way(n)}
            self.goals |= {path: kept} if kept else {}

    def spend(self) -> None:
        """Its failures are over, and what failed has all its tries again.

        Which way a retried group or a fallback had gone is kept: what was done there is done. So
        is what a person has said, unless it was to stop.
        """
        self.begun_anew, self.spent_n = True, self.last_n
        for device in self._tidied():
            self.touch(device, self.last_n + 1)
        self.answers = {p: a for p, a in self.answers.items() if a.choice not in REFUSALS}
        for tries in self.goals.values():
            for past in tries.values():
                past.spent = past.ended is not None and past.ended.state != "SUCCEEDED"
        for path in [path for path, step in self.steps.items() if step.fate != "succeeded"]:
            del self.steps[path]

    def _tidied(self) -> set[str]:
        """Devices on which the `finally` of a used protocol that had failed did something."""
        used = [path[:-1] + "finally:" for path in self.turns if path.endswith("/e")]
        return {
            past.sent.device
            for path, tries in self.goals.items()
            if path.startswith(tuple(used))
            for past in tries.values()
        }

    def unknown_fates(self) -> list[PastGoal]:
        """`once` goals that are over, of which nobody knows whether they happened."""
        newest = (tries[max(tries)] for tries in self.goals.values())
        return [past for past in newest if past.sent.effect == "once" and past.is_unknown]

    def open_goals(self) -> list[PastGoal]:
        """Goals that were sent and whose outcome is not in the journal."""
        return [g for tries in self.goals.values() for g in tries.values() if g.ended is None]


def _above(path: str) -> Iterator[str]:
    """Every path that this one lies in."""
    while path:
        yield path
        path = path.rpartition("/")[0]


def _drop(table: dict[str, Any], prefix: str) -> None:
    for path in [path for path in table if path.startswith(prefix)]:
        del table[path]


def split_goal_id(goal_id: str) -> tuple[str, int]:
    """`run/main/scan/0,0/shoot/2` -> its path without the run, and the attempt."""
    path, _, attempt = goal_id.partition("/")[2].rpartition("/")
    return path, int(attempt)


def read_history(records: Sequence[j.JournalRecord], *, comparing: bool = False) -> History:
    """Read a journal's records into a history.

    `comparing` keeps what lies in finished iterations, so that all of it can be gone through again.
    """
    history = History(comparing=comparing)
    again = reopened(records)
    for record in records:
        is_end = isinstance(record, j.IterationEnded)
        if is_end and comparing:
            history.gone_through.append(f"{record.loop}/{record.key}")
        if is_end and (comparing or record.n < again.get(f"{record.loop}/{record.key}", 0)):
            continue
        _read(history, record)
        history.last_n = record.n
        if not isinstance(record, j.Changed):  # written by whoever resumes, not by an engine
            history.last_at = record.at
    if history.started is None:
        raise JournalFault("the journal holds no start of a run: there is nothing to go on with")
    return history


def reopened(records: Sequence[j.JournalRecord]) -> dict[str, int]:
    """Iterations that a change took up again -> the record since which they are unfinished."""
    return {
        path: record.n
        for record in records
        if isinstance(record, j.Changed)
        for path in record.reopened
    }


def _read(history: History, record: j.JournalRecord) -> None:
    match record:
        case j.Started():
            history.started = record
        case j.Resumed():
            history.resumes, history.resumed_n = record.count, record.n
            if history.finished is not None:
                history.spend()
            history.finished = None
        case j.Again():
            history.spend()
        case j.Changed():
            history.changed = record
        case j.Phase():
            history.phase = record.phase
            name, _, number = record.phase.partition(":")
            if name == "resume":
                history.resumes = max(history.resumes, int(number))
            if record.phase.startswith("finally:"):
                history.finals += 1
        case j.GoalSent():
            path, attempt = split_goal_id(record.id)
            history.goals.setdefault(path, {})[attempt] = PastGoal(record)
            history.remember_order(record.device, record.id, record.effect)
            if history.phase.startswith(TOUCHING_PHASES):
                history.touch(record.device, record.n)
            history.boots[record.device] = record.boot
        case j.GoalEnded():
            path, attempt = split_goal_id(record.id)
            past = history.goal(path, attempt)
            if past is None:  # it outlived its iteration, which is over and forgotten
                return
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
        case j.Leased():
            history.epochs.setdefault(record.device, set()).add(record.epoch)
        case j.SafeState() | j.Touched():
            history.touch(record.device, record.n)
        case j.Finished():
            history.finished = record
        case _:
            return
