"""Messages that the server pushes, on the Socket.IO namespace `/ui`.

The page sends `watch {run}` for a run's patches and `snapshot {}` for the whole state; both are
acknowledged with the snapshot. `seq` increases by one per stream: after a gap, ask again.
"""

from typing import Literal

from pydantic import Field

from .base import ApiModel
from .control import ControlState
from .devices import DeviceState, GoalState, JogState
from .runs import LaunchState, LogLine, NodeState, PointState, RunDetail, RunHead, RunSummary


class Snapshot(ApiModel):
    """Event `snapshot`: everything except the details of runs."""

    seq: int
    server_time_ms: float
    bench: str
    devices: dict[str, DeviceState]
    runs: dict[str, RunSummary]
    control: ControlState
    goals: dict[str, GoalState]
    jogs: dict[str, JogState]
    launches: dict[str, LaunchState]


class Patch(ApiModel):
    """Event `patch`: what has changed, each entry complete; null for a removed one."""

    seq: int
    server_time_ms: float
    devices: dict[str, DeviceState | None] = Field(default_factory=dict)
    runs: dict[str, RunSummary | None] = Field(default_factory=dict)
    goals: dict[str, GoalState | None] = Field(default_factory=dict)
    jogs: dict[str, JogState | None] = Field(default_factory=dict)
    launches: dict[str, LaunchState | None] = Field(default_factory=dict)
    control: ControlState | None = Field(default=None, description="Null: unchanged.")


class RunPatch(ApiModel):
    """Event `run_patch`: changes of a watched run, at most ten times a second."""

    run: str
    seq: int
    head: RunHead
    nodes: dict[str, NodeState] = Field(default_factory=dict)
    points: list[PointState] = Field(default_factory=list)


class RunLog(ApiModel):
    """Event `log`: new lines of a watched run."""

    run: str
    lines: list[LogLine]


class Notice(ApiModel):
    """Event `notice`: a message for the user."""

    level: Literal["info", "problem"]
    text: str
    run: str | None = None
    device: str | None = None


class WatchedRun(ApiModel):
    """The acknowledgement of `watch`: the run's current state, or why it is refused."""

    ok: bool
    text: str = ""
    run: RunDetail | None = None
