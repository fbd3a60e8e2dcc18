"""Devices: their state, what they can do, manual actions, jogging, and the stop."""

from typing import Any, Literal

from pydantic import Field

from .base import ApiModel

DEAD_MAN_MS = 300
BEAT_MS = 100

Reach = Literal["starting", "online", "lost", "failed"]
Axis = Literal["x", "y", "z"]


class DeviceState(ApiModel):
    """A device's state."""

    name: str
    contract: str
    driver: str | None
    url: str | None
    reach: Reach
    word: str = Field(description="idle, moving, busy, SAFE ...: one word from its status.")
    reason: str = Field(default="", description="Why it is lost or failed.")
    status: dict[str, Any] = Field(default_factory=dict)
    status_at: str | None = None
    changed_at: str = Field(description="When `reach` last changed.")
    used_by: str | None = Field(default=None, description="The run that holds it.")
    goal: str | None = Field(default=None, description="The manual goal that is under way.")
    armed: str | None = Field(default=None, description="Who has armed a dangerous action of it.")
    camera: bool = Field(default=False, description="Whether `picture` gives what it sees.")


class ActionForm(ApiModel):
    """An action as a form: `params` is its JSON Schema with this bench's limits."""

    name: str
    summary: str
    params: dict[str, Any]
    returns: dict[str, Any]
    errors: dict[str, str] = Field(description="Error name -> its summary.")
    effect: Literal["pure", "idempotent", "once"]
    danger: str | None
    level: Literal[0, 1, 2, 3] = Field(
        description="0 reads, 1 is reversible, 2 moves (control and limits), 3 is a hazard "
        "(arm, then hold)."
    )
    cancel: bool
    duration_s: float | None
    interlock: dict[str, Any] = Field(default_factory=dict)


class KeepOut(ApiModel):
    """A box that a machine does not enter, in mm; null where it is unbounded along an axis."""

    name: str
    x0: float | None
    x1: float | None
    y0: float | None
    y1: float | None
    z0: float | None
    z1: float | None


class DeviceDetail(DeviceState):
    """A device with its contract."""

    summary: str
    versions: dict[str, str]
    status_schema: dict[str, Any]
    safe_state: list[str]
    actions: list[ActionForm]
    axes: list[Axis] = Field(description="Axes that can be jogged; empty if there are none.")
    ranges_mm: dict[str, tuple[float, float]] = Field(
        description="Range of each axis, on this bench; without one only the device knows it."
    )
    keep_out: list[KeepOut] = Field(description="Boxes on the bench that it does not enter, in mm.")


class HistoryValue(ApiModel):
    """A number of a status over the time asked for, in the unit of the contract's status."""

    name: str
    first: float
    last: float
    low: float
    high: float


class Trouble(ApiModel):
    """When a device was lost, had a fault, or was well again; seconds since 1970."""

    at_s: float
    text: str


class Series(ApiModel):
    """Lowest and highest value of each part of the time that has any; seconds since 1970."""

    name: str
    part_s: float
    at_s: list[float]
    low: list[float]
    high: list[float]


class DeviceHistory(ApiModel):
    """What a device has reported since a time, by the minute; the newest trouble first."""

    values: list[HistoryValue]
    words: dict[str, float] = Field(description="State -> its share of the status reports.")
    troubles: list[Trouble]
    series: Series | None
    bytes: int = Field(description="What the histories of all devices take.")
    largest_bytes: int = Field(description="Beyond this the oldest is dropped.")


class CallAction(ApiModel):
    """Parameters as values or texts with units; `armed` for a hazard, from `arm`."""

    params: dict[str, Any] = Field(default_factory=dict)
    armed: str | None = None


class GoalError(ApiModel):
    """Why a goal did not succeed, and whether it happened nevertheless."""

    name: str
    message: str
    happened: Literal["no", "yes", "unknown"]


class GoalState(ApiModel):
    """One manual action: under way until `ended_at` is set."""

    id: str
    device: str
    action: str
    params: dict[str, Any]
    state: Literal["ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED", "LOST"]
    progress: float | None = None
    message: str = ""
    result: dict[str, Any] | None = None
    error: GoalError | None = None
    files: list[str] = Field(default_factory=list)
    by: str
    began_at: str
    ended_at: str | None = None
    step: str = Field(description="The action as a protocol step, in YAML.")


class ArmAction(ApiModel):
    """The dangerous action to arm."""

    action: str


class Armed(ApiModel):
    """An armed action: it may be called once with this id, after `hold_s`, until `ends_at`."""

    id: str
    device: str
    action: str
    danger: str
    by: str
    ends_at: str
    hold_s: float


Along = dict[Axis, Literal[1, -1]]
"""More axes that move with the first, each as far, and their directions."""


class JogStep(ApiModel):
    """One bounded move from the position that the device reports."""

    axis: Axis
    distance_mm: float = Field(ge=-100, le=100)
    along: Along = Field(default_factory=dict)
    feed_mm_min: float | None = Field(default=None, gt=0, allow_inf_nan=False)


class JogStart(ApiModel):
    """Move for as long as keep-alives come."""

    axis: Axis
    direction: Literal[1, -1]
    along: Along = Field(default_factory=dict)
    feed_mm_min: float = Field(gt=0, allow_inf_nan=False)
    dead_man_ms: int = Field(
        default=DEAD_MAN_MS, ge=100, le=2000,
        description="The axis stops after so long without a keep-alive.",
    )  # fmt: skip


class JogState(ApiModel):
    """A hold: send `jog` {id} on the socket each `beat_ms`; none for `dead_man_ms` stops it."""

    id: str
    device: str
    axis: Axis
    direction: Literal[1, -1]
    moving: bool
    reason: str = Field(default="", description="Why it ended.")
    beat_ms: int = BEAT_MS
    dead_man_ms: int


class StoppedDevice(ApiModel):
    """Whether a device confirmed its safe state within the second."""

    device: str
    confirmed: bool
    message: str
    seconds: float


class StoppedRun(ApiModel):
    """Whether a live run was reached and aborted."""

    run: str
    told: bool
    message: str


class Stopped(ApiModel):
    """The answer to STOP ALL, within one second."""

    all_confirmed: bool
    devices: list[StoppedDevice]
    runs: list[StoppedRun]
    at: str
