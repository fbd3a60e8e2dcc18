"""The result of a rehearsal: how long, how far, how often, and what would go wrong."""

from collections import Counter, defaultdict
from dataclasses import asdict, dataclass, field
from typing import Any

from ...schemas import journal as j
from ..journal.course import split_goal_id
from ..journal.gantt import Gantt

COLUMNS = 120
"""Of the Gantt chart."""


@dataclass(slots=True)
class Part:
    """One step of the protocol's top level: when it starts, how long it takes."""

    name: str
    begins_s: float
    ends_s: float
    goals: int = 0
    iterations: int = 0

    @property
    def takes_s(self) -> float:
        """Seconds from its first goal to its last."""
        return self.ends_s - self.begins_s


@dataclass(slots=True)
class Trouble:
    """Failures of one kind: which action, how often, where first, and the message."""

    action: str
    error: str
    count: int
    first_at_s: float
    first_path: str
    message: str


@dataclass(slots=True)
class Totals:
    """A rehearsal in figures.

    `gantt`: by action, the share of each of `COLUMNS` columns of time in which it was under way; they divide
    `shown_s`, a part of the rehearsed time from its beginning. `unreached`: actions that were to fail, and
    that nothing asked for.
    """

    fate: str = ""
    reason: str = ""
    lasts_s: float = 0.0
    parts: list[Part] = field(default_factory=list)
    actions: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    once: dict[str, int] = field(default_factory=dict)
    path_mm: dict[str, float] = field(default_factory=dict)
    troubles: list[Trouble] = field(default_factory=list)
    slow: dict[str, tuple[float, float]] = field(default_factory=dict)
    sent_again: int = 0
    holes: int = 0
    points: j.Points = field(default_factory=j.Points)
    questions: list[str] = field(default_factory=list)
    players: dict[str, str] = field(default_factory=dict)
    gantt: dict[str, list[float]] = field(default_factory=dict)
    shown_s: tuple[float, float] = (0.0, 0.0)
    unreached: list[str] = field(default_factory=list)

    def as_dict(self) -> dict[str, Any]:
        """All of it as plain data."""
        return {**asdict(self), "points": self.points.model_dump()}


class Counting:
    """Listens to a rehearsed run's records, each with its virtual time."""

    def __init__(self, names: list[str], gantt: Gantt) -> None:
        self.totals = Totals()
        self._names = names
        self._gantt = gantt
        self._parts: dict[str, Part] = {}
        self._sent: dict[str, tuple[j.GoalSent, float]] = {}
        self._busy: dict[str, float] = defaultdict(float)
        self._counts: Counter[str] = Counter()
        self._once: Counter[str] = Counter()
        self._paths: set[str] = set()
        self._planned: set[str] = set()
        self._expired: set[str] = set()
        self._troubles: dict[tuple[str, str], Trouble] = {}

    def record(self, record: j.Record, at_s: float) -> None:
        """Take note of one record of the journal."""
        match record:
            case j.GoalSent():
                self._goal(record, at_s)
            case j.Expired():
                self._expired.add(record.id)
            case j.GoalEnded():
                self._ended(record, at_s)
            case j.Planned():
                self._planned.add(record.loop)
                self._part(record.loop, at_s)
            case j.IterationEnded():  # a turn of a loop inside is part of a point, not one
                self._part(record.loop, at_s).iterations += record.loop in self._planned
            case j.Asked():
                self.totals.questions.append(record.text)
            case _:
                return

    @property
    def goals(self) -> int:
        """Goals sent so far."""
        return self._counts.total()

    def close(self, lasts_s: float, finished: j.Finished) -> Totals:
        """Return the totals."""
        totals = self.totals
        totals.fate, totals.reason, totals.holes = finished.fate, finished.reason, finished.holes
        totals.points = finished.points or totals.points
        totals.lasts_s = lasts_s
        totals.gantt = self._gantt.rows(COLUMNS, lasts_s)
        totals.shown_s = (self._gantt.from_s, self._gantt.from_s + self._gantt.span_s(lasts_s))
        totals.parts = list(self._parts.values())
        totals.actions = dict(self._counts.most_common())
        totals.seconds = {label: self._busy[label] for label in totals.actions}
        totals.once = dict(self._once.most_common())
        totals.troubles = sorted(self._troubles.values(), key=lambda t: t.first_at_s)
        return totals

    def _goal(self, sent: j.GoalSent, at_s: float) -> None:
        path, _ = split_goal_id(sent.id)
        self._sent[sent.id] = (sent, at_s)
        self._counts[sent.label] += 1
        self._once[sent.label] += sent.effect == "once"
        self.totals.sent_again += path in self._paths
        self._paths.add(path)
        self._part(path, at_s).goals += 1

    def _ended(self, ended: j.GoalEnded, at_s: float) -> None:
        sent, began = self._sent.pop(ended.id)
        label, took = sent.label, at_s - began
        self._busy[label] += took
        self._gantt.add(label, began, at_s)
        path, _ = split_goal_id(ended.id)
        self._part(path, at_s)
        if sent.timeout_s and took > self.totals.slow.get(label, (sent.timeout_s / 2, 0))[0]:
            self.totals.slow[label] = (took, sent.timeout_s)
        name, message = "", ""
        if ended.id in self._expired:
            self._expired.remove(ended.id)
            name, message = "Timeout", f"longer than {sent.timeout_s:g} s"
        elif ended.error is not None:
            name, message = ended.error.name, ended.error.message
        if name:
            new = Trouble(label, name, 0, at_s, path, message)
            self._troubles.setdefault((label, name), new).count += 1

    def _part(self, path: str, at_s: float) -> Part:
        phase, _, rest = path.partition("/")
        segment = rest.partition("/")[0]
        name = segment if phase == "main" else phase.partition(":")[0]
        if name.isdigit() and int(name) < len(self._names):
            name = self._names[int(name)]
        part = self._parts.setdefault(name, Part(name, at_s, at_s))
        part.ends_s = max(part.ends_s, at_s)
        return part
