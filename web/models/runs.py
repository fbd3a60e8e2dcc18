"""Runs, live or finished: their heads, outlines, points, logs, and the commands to them."""

from typing import Annotated, Any, Literal

from pydantic import Field

from .base import ApiModel
from .protocols import Words

Fate = Literal[
    "starting", "running", "paused", "succeeded", "failed", "aborted", "interrupted", "unreadable"
]
Status = Literal[
    "waiting", "running", "ok", "retrying", "skipped", "failed", "cancelled", "unknown"
]


class RunSummary(ApiModel):
    """One run in the list."""

    id: str
    protocol: str = Field(description="The protocol's name.")
    file: str = Field(description="The file it was started from.")
    fate: Fate
    word: str = Field(default="", description="The fate in words: `succeeded with 8 holes`.")
    reason: str = ""
    live: bool
    began_at: str
    ended_at: str | None = None
    done: int = Field(description="Iterations of the outermost loops that have ended.")
    measured: int = Field(default=0, description="Those of them that have succeeded.")
    failed: int = 0
    left: int | None = Field(default=None, description="total = measured + failed + left.")
    total: int | None = Field(default=None, description="How many the plan has, if that is known.")
    holes: int = 0
    resumes: int = 0
    operator: str = ""
    questions: int = 0
    now: str = ""
    eta: tuple[str, str] | None = Field(
        default=None, description="It will end between these times (20th to 80th percentile)."
    )


class Loop(ApiModel):
    """Progress of one loop; `x_mm`, `y_mm` if its items have coordinates."""

    path: str = Field(description="Pattern with `*` for the keys of loops around it.")
    title: str
    total: int | None
    done: int
    succeeded: int
    failed: int
    skipped: int
    current: str | None = Field(default=None, description="Key of the latest iteration under way.")
    placed: bool = Field(description="True if `points` gives x and y.")


class Now(ApiModel):
    """An action under way."""

    id: str
    path: str
    node: str
    loop: str | None
    key: str | None
    device: str
    action: str
    attempt: int
    since: str
    usual_s: tuple[float, float] | None = None
    progress: float | None = None
    message: str = ""


class Question(ApiModel):
    """An open question to the operator."""

    path: str
    id: str
    text: str
    choices: list[str]
    wants: dict[str, Any] = Field(
        default_factory=dict, description="JSON schema of the values that go with `happened`."
    )


class Launch(ApiModel):
    """Information from the person who started the run."""

    operator: str = ""
    note: str = ""
    checklist: list[str] = Field(default_factory=list)
    at: str = ""


class NeedsYou(ApiModel):
    """The next question to the operator, and when to expect it."""

    text: str
    low: str
    high: str


class RunHead(RunSummary):
    """Current state of a run; small, and sent whole with each patch."""

    phase: str = ""
    pausing: bool = Field(default=False, description="True if it will pause after this point.")
    loops: list[Loop] = Field(default_factory=list)
    under_way: list[Now] = Field(default_factory=list)
    open_questions: list[Question] = Field(default_factory=list)
    needs_you: NeedsYou | None = None
    per_minute: float | None = Field(default=None, description="Iterations of the first loop.")
    retries: int = 0
    lines: int = Field(default=0, description="Log lines so far.")
    stands: bool = Field(
        default=False,
        description="To resume it would fail again where it failed: that point has to be measured again.",
    )


class OutlineNode(ApiModel):
    """A step of the protocol; `path` is a pattern with `*` for the keys of loops."""

    path: str
    parent: str | None
    depth: int
    kind: str
    id: str | None
    title: str
    role: str | None = None
    action: str | None = None
    danger: str | None = None
    loop: bool = False
    line: int | None = Field(default=None, description="In the run's own copy of the protocol.")
    pointer: str | None = None


class NodeState(ApiModel):
    """The state of a step, over all the points of its loops."""

    status: Status
    running: int = 0
    ok: int = 0
    failed: int = 0
    skipped: int = 0
    unknown: int = 0
    retries: int = 0
    last_s: float | None = None
    message: str = ""


class RunDetail(RunHead):
    """A run with everything that does not change while it runs, and the states of its steps."""

    outline: list[OutlineNode]
    nodes: dict[str, NodeState]
    params: dict[str, Any]
    roles: dict[str, str]
    outputs: dict[str, Any]
    launch: Launch
    protocol_text: str
    changes: int = Field(description="How often it was resumed with a changed protocol.")
    seq: int = Field(description="Number of the last patch included.")


class Points(ApiModel):
    """A window of a loop's iterations, as columns of one length; includes waiting ones."""

    loop: str
    total: int | None
    offset: int
    index: list[int]
    key: list[str | None] = Field(description="Null for one that has not begun.")
    status: list[Status]
    x_mm: list[float | None]
    y_mm: list[float | None]
    seconds: list[float | None]
    tries: list[int] = Field(description="Goals that were sent again.")
    message: list[str]


class PointState(ApiModel):
    """One iteration, as in patches."""

    loop: str
    within: str = Field(description="Keys of the iterations around it, separated by slashes.")
    index: int
    key: str
    status: Status
    seconds: float | None = None
    tries: int = 0
    message: str = ""


class ActionTold(ApiModel):
    """One attempt at one action, from the journal."""

    id: str
    node: str
    line: int | None
    device: str
    action: str
    attempt: int
    params: dict[str, Any]
    state: str
    result: dict[str, Any] | None
    error: dict[str, Any] | None
    sent_at: str
    ended_at: str | None
    seconds: float | None
    files: list[str]


class LogLine(ApiModel):
    """One line of the log; `n` is the number of its journal record."""

    n: int
    at: str
    level: Literal["info", "problem"]
    kind: str
    text: str
    device: str | None = None
    path: str = ""
    node: str | None = None
    loop: str | None = None
    key: str | None = None
    line: int | None = None


class PointDetail(ApiModel):
    """Everything about one iteration: actions with their attempts, the row, the log."""

    point: PointState
    x_mm: float | None
    y_mm: float | None
    row: dict[str, Any] | None
    actions: list[ActionTold]
    log: list[LogLine]
    spectra: list[str]


class LogWindow(ApiModel):
    """Lines in order; get more with `before` the first or `after` the last."""

    lines: list[LogLine]
    total: int
    more_before: bool


class ToRelease(ApiModel):
    """What a person reads before a release: the copy that would be run, with its values and devices."""

    id: str
    words: Words


class GiveRelease(ApiModel):
    """Who releases."""

    by: str = Field(min_length=1, max_length=80)


class Released(ApiModel):
    """What a program may start, once; `sha256` is of the protocol's text."""

    id: str
    file: str
    protocol: str
    sha256: str
    params: dict[str, str]
    by: str
    at: str


class StartRun(ApiModel):
    """Start a protocol; `checklist`: the points that the operator has ticked."""

    protocol: str
    revision: str | None = Field(
        default=None, description="Refused if the file has another revision by now."
    )
    params: dict[str, Any] = Field(default_factory=dict)
    bind: dict[str, str] = Field(default_factory=dict)
    operator: str = Field(default="", max_length=80)
    note: str = Field(default="", max_length=2000)
    checklist: list[str] = Field(default_factory=list, max_length=50)
    answers: dict[str, str] = Field(default_factory=dict)


class LaunchState(ApiModel):
    """A started engine; `run` is null until it has reported its run's id."""

    id: str
    run: str | None
    state: Literal["starting", "running", "failed", "ended"]
    message: str = ""


class PauseRun(ApiModel):
    """`now`: pause once the actions under way end. `after_point`: when this iteration ends."""

    when: Literal["now", "after_point"] = "now"


class AnswerQuestion(ApiModel):
    """One of the choices; with `happened`, what the action returned, as typed."""

    choice: str
    result: dict[str, str] = Field(default_factory=dict, max_length=50)


class HoleAt(ApiModel):
    """An iteration that failed: of which loop, with the keys around it."""

    loop: str = Field(description="Pattern with `*` for the keys of loops around it.")
    within: str = ""
    key: str


class ResumeRun(ApiModel):
    """Resume; with a changed `protocol` (or -p parameters) if the finished work fits it."""

    holes: Annotated[list[HoleAt], Field(max_length=5000)] | Literal["all"] = Field(
        default=[], description="Iterations that failed, to be measured again."
    )
    protocol: str | None = Field(default=None, description="Name of the changed protocol.")
    params: dict[str, Any] = Field(default_factory=dict)
    yes: bool = Field(default=False, description="Keep work that was done after a changed step.")
    answers: dict[str, str] = Field(default_factory=dict)
    checklist: list[str] = Field(default_factory=list, max_length=50)


class Changes(ApiModel):
    """Differences between a run's own protocol and one with which it could be resumed."""

    same_text: bool
    diff: list[str] = Field(description="A unified diff, line by line.")
    can_resume: bool
    agreeing: int = 0
    different: list[str] = Field(default_factory=list)
    in_the_way: list[str] = Field(
        default_factory=list,
        description="`once` actions that were done and now differ: resuming is refused.",
    )
    doubtful: list[str] = Field(default_factory=list, description="Kept only with `yes`.")
    reopened: int = Field(default=0, description="Finished iterations in which something is added.")
