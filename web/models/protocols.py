"""Protocols in the library: listed, read, saved with a revision, versioned, deleted."""

from typing import Any

from pydantic import Field

from .base import ApiModel, Fault, FoundProblem
from .devices import KeepOut

LARGEST_TEXT = 2_000_000


class ProtocolSummary(ApiModel):
    """One protocol in the list; `errors` and `warnings` are null until it has been checked."""

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
    median_s: float | None = Field(
        default=None, description="Median duration of its runs that succeeded."
    )


class ProtocolText(ApiModel):
    """A protocol's text; `revision` is the sha256 of its bytes, in hex."""

    name: str
    text: str
    revision: str
    modified: str


class SaveProtocol(ApiModel):
    """Save over `base`, the revision that was read; null only for a file that does not exist yet."""

    text: str = Field(max_length=LARGEST_TEXT)
    base: str | None = None


class SavedProtocol(ApiModel):
    """Saved; the revision before it is kept as a version."""

    name: str
    revision: str
    modified: str


class SaveConflict(Fault):
    """409: somebody else saved meanwhile. `base` is null if that version is not kept."""

    mine: str
    theirs: str
    theirs_revision: str
    base: str | None


class Version(ApiModel):
    """An earlier text of a protocol."""

    revision: str
    saved_at: str
    size: int
    current: bool


class NewProtocol(ApiModel):
    """A new protocol: from a template, a text, another protocol, or the protocol of a past run."""

    name: str = Field(max_length=200)
    template: str | None = None
    text: str | None = Field(default=None, max_length=LARGEST_TEXT)
    copy_of: str | None = Field(default=None, description="The name of another protocol.")
    run: str | None = Field(default=None, description="The id of a run.")


class Template(ApiModel):
    """A template for a new protocol."""

    name: str
    summary: str


class CsvTable(ApiModel):
    """A CSV file that a protocol may name; `name` is relative to the protocol's folder."""

    name: str
    rows: int
    columns: list[str] = Field(description="Names, as `row.NAME` in an expression.")
    kinds: list[str] = Field(
        default_factory=list,
        description="Of each column: its unit, or integer, number, boolean or text.",
    )
    fault: str | None = Field(default=None, description="Why it cannot be used as it is.")


class NewCsvTable(ApiModel):
    """A CSV file to put beside a protocol."""

    protocol: str = Field(max_length=200)
    name: str = Field(max_length=200)
    text: str = Field(max_length=LARGEST_TEXT)


class Thrown(ApiModel):
    """A protocol in the trash, from which it can be restored."""

    id: str
    name: str
    thrown_at: str
    size: int


class CheckText(ApiModel):
    """A text from the editor to examine; `name` tells where `use` and `csv` look for files."""

    text: str = Field(max_length=LARGEST_TEXT)
    name: str = Field(default="protocol.yaml", max_length=200)
    params: dict[str, Any] = Field(default_factory=dict, description="Texts or values.")
    bind: dict[str, str] = Field(default_factory=dict, description="Role -> device.")


class ParamForm(ApiModel):
    """One parameter in the form before a run."""

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


class RoleForm(ApiModel):
    """A role, the device bound to it, and the devices that could be."""

    role: str
    contract: str
    device: str | None
    choices: list[str]


class Hazard(ApiModel):
    """An action of the protocol that its contract calls dangerous."""

    danger: str
    device: str
    action: str
    pointer: str


class CheckedText(ApiModel):
    """The checker's result; `ok` if the protocol can run."""

    ok: bool
    revision: str
    title: str | None
    summary: str = ""
    problems: list[FoundProblem]
    params: list[ParamForm] = Field(default_factory=list)
    roles: list[RoleForm] = Field(default_factory=list)
    hazards: list[Hazard] = Field(default_factory=list)
    questions: list[str] = Field(default_factory=list)
    no_room: str = Field(default="", description="Why the disk takes no run; empty if it does.")


class WordItem(ApiModel):
    """A sentence, the steps inside it, and the text after them."""

    text: str
    below: list["WordItem"] = Field(default_factory=list)
    after: str = ""
    numbered: bool = True


class WordTerm(ApiModel):
    """A name and its meaning."""

    name: str
    meaning: str


class WordSection(ApiModel):
    """A part of the protocol in plain words."""

    title: str
    text: str = ""
    items: list[WordItem] = Field(default_factory=list)
    terms: list[WordTerm] = Field(default_factory=list)


class Words(ApiModel):
    """The protocol as plain sentences, and as Markdown for the lab book."""

    sections: list[WordSection]
    markdown: str


class Explained(ApiModel):
    """The protocol as P = [A1, ..., AT], line by line."""

    lines: list[str]


class Area(ApiModel):
    """A rectangle in mm; an edge is null if unbounded."""

    x0: float | None
    x1: float | None
    y0: float | None
    y1: float | None


class Track(ApiModel):
    """The points of one device in their order; equal indexes belong together."""

    device: str
    contract: str
    area: Area = Field(description="Where it may go on this bench.")
    allowed: Area = Field(description="What its contract allows.")
    x_mm: list[float]
    y_mm: list[float]
    track: list[int] = Field(description="Index into `tracks`.")
    joined: list[bool] = Field(description="Whether the path leads here from the point before.")
    outside: list[int] = Field(description="Indexes of points outside the area.")
    keep_out: list[KeepOut] = Field(description="Boxes that it does not enter, in mm.")
    tracks: list[str]
    unknown: int = Field(description="Points that are known only during the run.")
    length_mm: float


class SpanS(ApiModel):
    """Seconds: the 20th and 80th percentile, and how many runs they were measured on."""

    low: float
    high: float
    runs: int = Field(description="0: from the typical durations in the contracts.")
    real_s: float | None = Field(
        default=None, description="With real devices, where the bench's are simulated and quicker."
    )


class Preview(ApiModel):
    """The path of a protocol, its actions and its duration, before anything moves."""

    tracks: list[Track]
    notes: list[str]
    full: bool = Field(description="True if there are more points than are given.")
    actions: dict[str, int | None] = Field(description="device.action -> times; null: unknown.")
    actions_text: str
    shots: int | None = Field(description="Actions with a laser; null if unknown.")
    needs_you: list[str] = Field(description="Questions to the operator, in order.")
    time_s: SpanS | None


class RehearseText(CheckText):
    """A text to rehearse on a virtual clock, with injected faults."""

    fail: list[str] = Field(
        default_factory=list, max_length=50, description="`libs.measure:0.05`, as on the shell."
    )
    seed: int | None = None


class Rehearsed(ApiModel):
    """The result of a rehearsal."""

    fate: str
    reason: str
    lasts_s: float
    lines: list[str] = Field(description="The result as text for people.")
    gantt: dict[str, list[float]] = Field(
        description="By action (`gantry.move_to`), the share of each of 120 columns of time, which divide "
        "`lasts_s`, for which it was under way; actions of one device stand together."
    )
