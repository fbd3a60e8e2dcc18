"""The records of a journal: one JSON object per line, each chained to the previous one by a hash.

Every record has `n` (its number), `at` (UTC), `kind`, and `hash`. The outcome of a goal or a step is
given by the fates of DESIGN section 7.
"""

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from .contract import Effect
from .messages import GoalError
from .model import Model

FORMAT = 3
"""Version of the journal's format, raised where it gains kinds or fields; a newer one is refused."""

StepFate = Literal["succeeded", "failed", "skipped", "cancelled", "unknown"]
RunFate = Literal["succeeded", "failed", "aborted", "paused", "interrupted"]


class Record(Model):
    """The fields of every record; filled in by the journal."""

    n: int = 0
    at: str = ""
    hash: str = ""


class Started(Record):
    """The run began: first record of every journal."""

    kind: Literal["started"] = "started"
    format: int = FORMAT
    run: str
    protocol: str
    labrun: str
    python: str
    began: str = ""
    params: dict[str, Any] = Field(default_factory=dict)
    roles: dict[str, str] = Field(default_factory=dict)
    files: dict[str, str] = Field(default_factory=dict)


class Resumed(Record):
    """An engine resumed the run for the `count`-th time; `by`: who asked for it.

    `put_back`: the journal lacked what had been in it, so an older copy was put in its place.
    """

    kind: Literal["resumed"] = "resumed"
    count: int
    labrun: str
    torn: int = 0
    by: str = ""
    put_back: bool | None = None


class Changed(Record):
    """The run continues with another protocol or other parameters, kept in `folder` of the run.

    `reopened` are the paths of finished iterations in which something has to be done again.
    """

    kind: Literal["changed"] = "changed"
    folder: str
    files: dict[str, str] = Field(default_factory=dict)
    params: dict[str, Any] = Field(default_factory=dict)
    roles: dict[str, str] = Field(default_factory=dict)
    reopened: list[str] = Field(default_factory=list)


class Redo(Record):
    """A person has asked for holes to be measured again: in a new pass, with new goals.

    `iterations` are the paths of the holes, or of a step outside any loop at which the run failed;
    `pass_number` is the level in the ids of their new goals. `reopened` are finished iterations around
    them: their finished work stands, settings are made again.
    """

    kind: Literal["redo"] = "redo"
    by: str
    pass_number: int
    iterations: list[str]
    reopened: list[str] = Field(default_factory=list)


class Phase(Record):
    """The engine turned to `main`, `resume:n` or `finally:n`."""

    kind: Literal["phase"] = "phase"
    phase: str


class GoalSent(Record):
    """Intent: on disk before the goal leaves for its device."""

    kind: Literal["goal"] = "goal"
    id: str
    device: str
    action: str
    params: dict[str, Any] = Field(default_factory=dict)
    effect: Effect
    boot: str
    ledger: str
    epoch: int
    means: str
    timeout_s: float | None = None
    sets: str = ""
    """What of the device it sets, by its contract: set again on resume, in a later iteration too."""

    @property
    def label(self) -> str:
        """`gantry.move_to`, by the device's name in the lab."""
        return f"{self.device}.{self.action}"


class GoalEnded(Record):
    """Outcome of a goal: how it ended, what came back, which files were written."""

    kind: Literal["ended"] = "ended"
    id: str
    state: Literal["SUCCEEDED", "CANCELED", "ABORTED"]
    result: dict[str, Any] | None = None
    error: GoalError | None = None
    files: dict[str, str] = Field(default_factory=dict)


class Expired(Record):
    """A goal took longer than its timeout and is being cancelled: whatever its end is, it failed."""

    kind: Literal["expired"] = "expired"
    id: str


class StepEnded(Record):
    """A step that is not an action ended: a wait, a question, a log line, a set."""

    kind: Literal["step"] = "step"
    path: str
    fate: StepFate
    result: Any = None
    message: str = ""


class Computed(Record):
    """A value that a clock gave, where it was first computed: a resumed run computes with it again."""

    kind: Literal["computed"] = "computed"
    path: str
    value: Any = None


class Turned(Record):
    """A retried group, a fallback or a repeated question started its next attempt."""

    kind: Literal["turn"] = "turn"
    path: str
    turn: int
    error: dict[str, Any] | None = None


class Asked(Record):
    """A person is asked; the run waits at this path for one of the choices."""

    kind: Literal["asked"] = "asked"
    path: str
    id: str
    text: str
    choices: list[str]
    wants: dict[str, Any] = Field(default_factory=dict)
    """JSON schema of the values that go with the choice `happened`."""


class Answered(Record):
    """Who chose what; `result`: what the action returned, as far as the person knows."""

    kind: Literal["answered"] = "answered"
    path: str
    choice: str
    by: str
    result: dict[str, Any] | None = None


class IterationEnded(Record):
    """One iteration of a loop is over, including its background actions."""

    kind: Literal["iteration"] = "iteration"
    loop: str
    index: int
    key: str
    within: str = ""
    """The keys of the iterations around it, outermost first, separated by slashes."""
    fate: StepFate
    row: dict[str, Any] | None = None
    file: str = ""
    sets: dict[str, Any] = Field(default_factory=dict)
    message: str = ""
    ahead: bool = False
    """Others before it are not over: its row waits for theirs."""

    @property
    def row_key(self) -> str:
        """The key of its row: `A/0,0` for the point 0,0 of the sample A."""
        return f"{self.within}/{self.key}" if self.within else self.key


class Planned(Record):
    """A loop that is in no other one begins: how many iterations it will have, if that is known."""

    kind: Literal["planned"] = "planned"
    loop: str
    total: int | None = None


class LoopEnded(Record):
    """A loop is over, with its counts."""

    kind: Literal["loop"] = "loop"
    loop: str
    fate: StepFate
    total: int
    succeeded: int
    failed: int
    skipped: int


class Control(Record):
    """A person or a signal paused, continued or aborted the run."""

    kind: Literal["control"] = "control"
    verb: Literal["pause", "continue", "abort", "abort-now"]
    by: str


class SafeState(Record):
    """A device was sent into its safe state, and whether it confirmed."""

    kind: Literal["safe"] = "safe"
    device: str
    confirmed: bool
    message: str = ""


class Again(Record):
    """A person continued the run after a failed step: the step is tried again."""

    kind: Literal["again"] = "again"
    by: str = ""


class Leased(Record):
    """The engine holds a device with this epoch, at this boot of its server.

    `mark` is the newest change in the server's ledger. `continues` is false if the ledger lacked the
    mark before this one: it is another ledger, or an older copy of it.
    """

    kind: Literal["leased"] = "leased"
    device: str
    epoch: int
    boot: str
    mark: str = ""
    continues: bool = True


class Marked(Record):
    """A device server has a `once` goal in its ledger, whose newest change is `mark`."""

    kind: Literal["marked"] = "marked"
    device: str
    mark: str


class Touched(Record):
    """A device whose state may be lost: its server was restarted, or had put it into its safe state."""

    kind: Literal["touched"] = "touched"
    device: str
    reason: str


class Points(Model):
    """A run in four numbers: the iterations of its outermost loops, as far as they have begun.

    `plan`, `left`: None where a loop's length is not known. plan = measured + failed + left.
    """

    plan: int | None = None
    measured: int = 0
    failed: int = 0
    left: int | None = None

    def words(self, holes: int = 0) -> str:
        """`7 of 35 measured, 2 failed, 26 left`; nothing for a run without loops.

        Of `holes`, those that are not whole iterations lie within them: `2 of 2 measured, 3 holes
        within`.
        """
        if not (self.plan or self.measured or self.failed):
            return ""
        of = "" if self.plan is None else f" of {self.plan:,}"
        failed = f", {self.failed:,} failed" if self.failed else ""
        left = f", {self.left:,} left" if self.left else ""
        inner = max(0, holes - self.failed)
        within = f", {inner:,} hole{'s' if inner > 1 else ''} within" if inner else ""
        return f"{self.measured:,}{of} measured{failed}{left}{within}"


def ended_as(fate: str, holes: int) -> str:
    """How a run ended, in its own words: `succeeded with 8 holes` is not `succeeded`."""
    with_holes = f" with {holes:,} hole{'s' if holes > 1 else ''}"
    return f"{fate}{with_holes}" if holes and fate == "succeeded" else fate


class Finished(Record):
    """The last record of a run that ended."""

    kind: Literal["finished"] = "finished"
    fate: RunFate
    reason: str = ""
    detail: str = ""
    """The paths and error names behind the reason."""
    holes: int = 0
    points: Points | None = None
    outputs: dict[str, Any] = Field(default_factory=dict)


JournalRecord = Annotated[
    Started
    | Resumed
    | Changed
    | Redo
    | Phase
    | GoalSent
    | GoalEnded
    | Expired
    | StepEnded
    | Computed
    | Turned
    | Asked
    | Answered
    | IterationEnded
    | Planned
    | LoopEnded
    | Control
    | SafeState
    | Again
    | Leased
    | Marked
    | Touched
    | Finished,
    Field(discriminator="kind"),
]

RECORD: TypeAdapter[JournalRecord] = TypeAdapter(JournalRecord)
