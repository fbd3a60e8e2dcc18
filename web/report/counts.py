"""What a report keeps of a journal: counts, questions, holes, and the engine sessions."""

from collections.abc import Callable
from dataclasses import dataclass, field

from ...engine.journal.course import Course
from ...engine.journal.gantt import Gantt
from ...schemas import journal as j
from .outcomes import Outcomes
from .rows_hash import RowsHash
from .spans import Spans

KEPT = 200
"""At most this many log lines, questions and so on are kept; the rest are only counted."""


@dataclass(slots=True)
class Deed:
    """How often one action of one device was sent, and its outcomes."""

    sent: int = 0
    again: int = 0
    succeeded: int = 0
    failed: int = 0
    cancelled: int = 0
    timed: int = 0
    seconds: float = 0.0
    longest_s: float = 0.0

    @property
    def mean_s(self) -> float:
        """Average time from sending to the end."""
        return self.seconds / self.timed if self.timed else 0.0

    @property
    def ended(self) -> int:
        """Goals whose end is in the journal."""
        return self.succeeded + self.failed + self.cancelled


@dataclass(slots=True)
class Counted:
    """How the iterations of one loop ended; loops inside a loop are counted together."""

    succeeded: int = 0
    failed: int = 0
    skipped: int = 0

    @property
    def total(self) -> int:
        """Iterations that have ended."""
        return self.succeeded + self.failed + self.skipped


@dataclass(slots=True)
class Asking:
    """A question to the operator, and who answered what."""

    at: str
    path: str
    text: str
    choices: list[str]
    choice: str = ""
    by: str = ""
    answered_at: str = ""


@dataclass(slots=True)
class Holes:
    """Iterations that were left out for one reason."""

    message: str
    count: int = 0
    places: list[str] = field(default_factory=list)


@dataclass(slots=True)
class Boot:
    """One start of a device's server, as recorded in its goals."""

    boot: str
    ledger: str
    at: str


@dataclass(slots=True)
class JournalDigest(Course):
    """Contents of a journal, collected for a reader. `damage`: where it becomes unreadable."""

    damage: str = ""
    spans: Spans = field(default_factory=Spans)
    outcomes: Outcomes = field(init=False)
    deeds: dict[str, Deed] = field(default_factory=dict)
    gantt: Gantt = field(default_factory=Gantt)
    loops: dict[str, Counted] = field(default_factory=dict)
    holes: dict[str, Holes] = field(default_factory=dict)
    asked: list[Asking] = field(default_factory=list)
    unheard: dict[str, Asking] = field(default_factory=dict)
    plans: dict[str, int | None] = field(default_factory=dict)
    """The outermost loops of the protocol that have begun -> how many iterations they have."""
    superseded: Callable[[j.IterationEnded], bool] = lambda ended: False
    """Whether an iteration's end no longer counts."""
    controls: list[j.Control] = field(default_factory=list)
    safe: list[j.SafeState] = field(default_factory=list)
    touched: list[j.Touched] = field(default_factory=list)
    logged: list[j.StepEnded] = field(default_factory=list)
    log_lines: int = 0
    questions: int = 0
    boots: dict[str, list[Boot]] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)
    writers: dict[str, str] = field(default_factory=dict)
    tables: dict[str, RowsHash] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.outcomes = Outcomes(self)

    @property
    def began(self) -> str:
        """When the run began."""
        return self.spans.lives[0].began if self.spans.lives else ""

    @property
    def ended(self) -> str:
        """When the last record was written."""
        return self.spans.lives[-1].ended if self.spans.lives else ""

    @property
    def points(self) -> j.Points | None:
        """Plan, measured, failed, left; as the last record has them where no plan was recorded."""
        if not self.plans:
            return self.finished.points if self.finished is not None else None
        loops = [self.loops.get(loop, Counted()) for loop in self.plans]
        totals = list(self.plans.values())
        plan = None if None in totals else sum(total or 0 for total in totals)
        stood = self.stood(self.plans)
        ended = sum(loop.total for loop in loops) + stood
        return j.Points(
            plan=plan, measured=sum(loop.succeeded for loop in loops),
            failed=sum(loop.failed for loop in loops) + stood,
            left=None if plan is None else max(0, plan - ended),
        )  # fmt: skip

    def total(self, what: str) -> int:
        """Over all actions: `sent`, `again`, `succeeded`, `failed` or `cancelled`."""
        return sum(getattr(deed, what) for deed in self.deeds.values())
