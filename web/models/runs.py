"""Runs, live or finished: their heads, outlines, points, logs, and what a person may do to them."""

from typing import Any, Literal

from pydantic import Field

from .told import Told

Fate = Literal[
    "starting", "running", "paused", "succeeded", "failed", "aborted", "interrupted", "unreadable"
]
Status = Literal[
    "waiting", "running", "ok", "retrying", "skipped", "failed", "cancelled", "unknown"
]


class RunSummary(Told):
    """One run in the list."""

    id: str
    protocol: str = Field(description="The protocol's own name.")
    file: str = Field(description="The file it was started from.")
    fate: Fate
    reason: str = ""
    live: bool
    began_at: str
    ended_at: str | None = None
    done: int = Field(description="Iterations of the outermost loops that are over.")
    failed: int = 0
    total: int | None = None
    holes: int = 0
    resumes: int = 0
    operator: str = ""
    questions: int = 0
    now: str = ""
    eta: tuple[str, str] | None = Field(
        default=None, description="Between these times (20th to 80th percentile) it will be over."
    )


class Loop(Told):
    """One loop: how far it is; `x_mm`, `y_mm` where its items have places."""

    path: str = Field(description="Pattern with `*` for the keys of loops around it.")
    title: str
    total: int | None
    done: int
    succeeded: int
    failed: int
    skipped: int
    current: str | None = Field(default=None, description="Key of the newest that is under way.")
    placed: bool = Field(description="True where `points` gives x and y.")


class Now(Told):
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


class Question(Told):
    """A person is asked."""

    path: str
    id: str
    text: str
    choices: list[str]
    asked_at: str


class Launch(Told):
    """What the person who started it said."""

    operator: str = ""
    note: str = ""
    checklist: list[str] = Field(default_factory=list)
    at: str = ""


class NeedsYou(Told):
    """The next step that asks a person: between which times."""

    text: str
    low: str
    high: str


class RunHead(RunSummary):
    """A run as it is now; small, and sent whole with each patch."""

    phase: str = ""
    pausing: bool = Field(default=False, description="It will pause after this point.")
    loops: list[Loop] = Field(default_factory=list)
    under_way: list[Now] = Field(default_factory=list)
    open_questions: list[Question] = Field(default_factory=list)
    needs_you: NeedsYou | None = None
    per_minute: float | None = Field(default=None, description="Iterations of the first loop.")
    retries: int = 0
    lines: int = Field(default=0, description="Lines of its log so far.")


class OutlineNode(Told):
    """A step of the protocol; `path` is a pattern, `*` stands for the keys of loops."""

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


class NodeState(Told):
    """What has become of a step, over all the points of its loops."""

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
    """A run with everything that does not change while it lives, and the states of its steps."""

    outline: list[OutlineNode]
    nodes: dict[str, NodeState]
    params: dict[str, Any]
    roles: dict[str, str]
    outputs: dict[str, Any]
    launch: Launch
    protocol_text: str
    changes: int = Field(description="How often it went on with a changed protocol.")
    seq: int = Field(description="Of the last patch that is in this.")


class Points(Told):
    """A window of a loop's iterations, as columns of one length; waiting ones are told, too."""

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


class PointState(Told):
    """One iteration, as patches tell it."""

    loop: str
    within: str = Field(description="Keys of the iterations around it, separated by slashes.")
    index: int
    key: str
    status: Status
    seconds: float | None = None
    tries: int = 0
    message: str = ""


class ActionTold(Told):
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


class LogLine(Told):
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


class PointDetail(Told):
    """Everything about one iteration: actions with their attempts, the row, the log."""

    point: PointState
    x_mm: float | None
    y_mm: float | None
    row: dict[str, Any] | None
    actions: list[ActionTold]
    log: list[LogLine]
    spectra: list[str]


class LogWindow(Told):
    """Lines in order; ask with `before` the first or `after` the last for more."""

    lines: list[LogLine]
    total: int
    more_before: bool
    more_after: bool


class StartRun(Told):
    """Start a protocol; `checklist` are the points that a person has ticked."""

    protocol: str
    revision: str | None = Field(default=None, description="Refused where it is another by now.")
    params: dict[str, Any] = Field(default_factory=dict)
    bind: dict[str, str] = Field(default_factory=dict)
    operator: str = Field(default="", max_length=80)
    note: str = Field(default="", max_length=2000)
    checklist: list[str] = Field(default_factory=list, max_length=50)
    answers: dict[str, str] = Field(default_factory=dict)


class LaunchState(Told):
    """An engine that was started; `run` is null until it has told its run's id."""

    id: str
    run: str | None
    state: Literal["starting", "running", "failed", "ended"]
    message: str = ""


class PauseRun(Told):
    """`now`: what runs is finished, then it holds. `after_point`: when this iteration is over."""

    when: Literal["now", "after_point"] = "now"


class AnswerQuestion(Told):
    """One of the choices."""

    choice: str


class ResumeRun(Told):
    """Go on; with `protocol` (or -p parameters) that have changed, where finished work fits."""

    protocol: str | None = Field(default=None, description="Name of the changed protocol.")
    params: dict[str, Any] = Field(default_factory=dict)
    yes: bool = Field(default=False, description="Keep work that was done after a changed step.")
    answers: dict[str, str] = Field(default_factory=dict)
    checklist: list[str] = Field(default_factory=list, max_length=50)


class Changes(Told):
    """What is different between a run's own protocol and one with which it could go on."""

    same_text: bool
    diff: list[str] = Field(description="A unified diff, line by line.")
    can_resume: bool
    agreeing: int = 0
    different: list[str] = Field(default_factory=list)
    in_the_way: list[str] = Field(
        default_factory=list, description="Done once, wanted otherwise: it cannot go on so."
    )
    doubtful: list[str] = Field(default_factory=list, description="Kept only with `yes`.")
    reopened: int = Field(default=0, description="Finished iterations that get something new.")
