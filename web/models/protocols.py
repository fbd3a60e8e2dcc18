"""Protocols on the shelf: listed, read, saved with a revision, kept in versions, thrown away."""

from typing import Any

from pydantic import Field

from .devices import KeepOut
from .told import Fault, FoundProblem, Told

LARGEST_TEXT = 2_000_000


class ProtocolSummary(Told):
    """One protocol in the list; `errors` and `warnings` are null until it was checked."""

    name: str = Field(description="File name relative to the folder of protocols, with suffix.")
    title: str
    summary: str
    roles: dict[str, str] = Field(description="Role -> contract.")
    revision: str
    modified: str
    size: int
    errors: int | None = None
    warnings: int | None = None
    first_error: str | None = None
    runs: int = 0
    succeeded: int = 0
    median_s: float | None = Field(default=None, description="Of its runs that succeeded.")


class ProtocolText(Told):
    """A protocol's text; `revision` is the sha256 of its bytes, in hex."""

    name: str
    text: str
    revision: str
    modified: str


class SaveProtocol(Told):
    """Save over `base`, the revision that was read; null only for a file that is not there yet."""

    text: str = Field(max_length=LARGEST_TEXT)
    base: str | None = None


class SavedProtocol(Told):
    """Saved; the revision before it is kept as a version."""

    name: str
    revision: str
    modified: str


class SaveConflict(Fault):
    """409: somebody saved in between. `base` is null where that version is not kept."""

    mine: str
    theirs: str
    theirs_revision: str
    base: str | None


class Version(Told):
    """An earlier text of a protocol."""

    revision: str
    saved_at: str
    size: int
    current: bool


class NewProtocol(Told):
    """A new protocol: from a template, a text, another protocol, or what a past run went by."""

    name: str = Field(max_length=200)
    template: str | None = None
    text: str | None = Field(default=None, max_length=LARGEST_TEXT)
    copy_of: str | None = Field(default=None, description="The name of another protocol.")
    run: str | None = Field(default=None, description="The id of a run.")


class Template(Told):
    """What a new protocol can begin with."""

    name: str
    summary: str


class Thrown(Told):
    """A protocol in the trash, from which it can be taken back."""

    id: str
    name: str
    thrown_at: str
    size: int


class CheckText(Told):
    """A text to look at, as it stands in the editor; `name` says where `use` and `csv` look."""

    text: str = Field(max_length=LARGEST_TEXT)
    name: str = Field(default="protocol.yaml", max_length=200)
    params: dict[str, Any] = Field(default_factory=dict, description="Texts or values.")
    bind: dict[str, str] = Field(default_factory=dict, description="Role -> device.")


class ParamForm(Told):
    """One parameter, as the form before a run asks for it."""

    name: str
    type: str
    unit: str | None = None
    default: Any = None
    required: bool
    minimum: Any = None
    maximum: Any = None
    pattern: str | None = None
    enum: list[Any] | None = None
    summary: str = ""


class RoleForm(Told):
    """A role, the device that plays it, and those that could."""

    role: str
    contract: str
    device: str | None
    choices: list[str]


class Hazard(Told):
    """An action of the protocol that its contract calls dangerous."""

    danger: str
    device: str
    action: str
    pointer: str


class CheckedText(Told):
    """What the checker says; `ok` where it could run."""

    ok: bool
    revision: str
    title: str | None
    summary: str = ""
    problems: list[FoundProblem]
    params: list[ParamForm] = Field(default_factory=list)
    roles: list[RoleForm] = Field(default_factory=list)
    hazards: list[Hazard] = Field(default_factory=list)
    questions: list[str] = Field(default_factory=list)


class WordItem(Told):
    """A sentence, the steps inside it, and what is said after them."""

    text: str
    below: list["WordItem"] = Field(default_factory=list)
    after: str = ""
    numbered: bool = True


class WordTerm(Told):
    """A name and its meaning."""

    name: str
    meaning: str


class WordSection(Told):
    """A part of the protocol in plain words."""

    title: str
    text: str = ""
    items: list[WordItem] = Field(default_factory=list)
    terms: list[WordTerm] = Field(default_factory=list)


class Words(Told):
    """The protocol as plain sentences; the same as Markdown, for the lab book."""

    sections: list[WordSection]
    markdown: str


class Explained(Told):
    """The protocol as P = [A1, ..., AT], line by line."""

    lines: list[str]


class GraphNode(Told):
    """A node of the tree; `step` is the path of the step it stands for."""

    kind: str
    lines: list[str]
    edge: str = ""
    step: str | None = None
    below: list["GraphNode"] = Field(default_factory=list)


class Graph(Told):
    """The tree that the protocol becomes, as data and as text for others to draw."""

    phases: dict[str, GraphNode]
    mermaid: str
    dot: str


class Area(Told):
    """A rectangle in mm; an edge is null where nothing bounds it."""

    x0: float | None
    x1: float | None
    y0: float | None
    y1: float | None


class Track(Told):
    """The points of one device in their order; equal indexes belong together."""

    device: str
    contract: str
    area: Area = Field(description="Where it may go on this bench.")
    allowed: Area = Field(description="What its contract allows.")
    x_mm: list[float]
    y_mm: list[float]
    track: list[int] = Field(description="Index into `tracks`.")
    joined: list[bool] = Field(description="Whether it comes there from the point before.")
    outside: list[int] = Field(description="Indexes of points outside the area.")
    keep_out: list[KeepOut] = Field(description="Boxes that it does not enter, in mm.")
    tracks: list[str]
    unknown: int = Field(description="Places that are known only in the run.")
    length_mm: float


class SpanS(Told):
    """Seconds: the 20th and 80th percentile, and how many runs they were measured on."""

    low: float
    high: float
    runs: int = Field(description="0: from the typical durations in the contracts.")


class Preview(Told):
    """Where a protocol goes, how often it acts and how long it takes, before anything moves."""

    tracks: list[Track]
    notes: list[str]
    full: bool = Field(description="True where there are more points than are told.")
    actions: dict[str, int | None] = Field(description="device.action -> times; null: unknown.")
    actions_text: str
    shots: int | None = Field(description="Actions with a laser; null where not known.")
    needs_you: list[str] = Field(description="Questions to a person, in order.")
    time_s: SpanS | None


class RehearseText(CheckText):
    """A text to play through on a virtual clock, with faults to order."""

    fail: list[str] = Field(
        default_factory=list, max_length=50, description="`libs.measure:0.05`, as on the shell."
    )
    seed: int | None = None


class RehearsedPart(Told):
    """One step of the top level."""

    name: str
    begins_s: float
    ends_s: float
    goals: int
    iterations: int


class RehearsedTrouble(Told):
    """Failures of one kind."""

    action: str
    error: str
    count: int
    first_at_s: float
    first_path: str
    message: str


class Rehearsed(Told):
    """How a rehearsal came out."""

    fate: str
    reason: str
    lasts_s: float
    rehearsed_s: float
    parts: list[RehearsedPart]
    actions: dict[str, int]
    seconds: dict[str, float]
    once: dict[str, int]
    path_mm: dict[str, float]
    troubles: list[RehearsedTrouble]
    slow: dict[str, tuple[float, float]]
    sent_again: int
    holes: int
    questions: list[str]
    players: dict[str, str]
    lines: list[str] = Field(description="The same as a person reads it.")
