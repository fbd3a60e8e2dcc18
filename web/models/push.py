"""What the server tells by itself, on the Socket.IO namespace `/ui`.

The page asks `watch {run}` for a run's patches and `snapshot {}` for the whole again; both are
acknowledged with the snapshot. `seq` counts up by one for each stream: after a gap, ask again.
"""

from typing import Literal

from pydantic import Field

from .control import ControlState
from .devices import DeviceState, GoalState, JogState
from .runs import LaunchState, LogLine, NodeState, PointState, RunDetail, RunHead, RunSummary
from .told import Told


class Snapshot(Told):
    """Event `snapshot`: everything but the runs' insides."""

    seq: int
    server_time_ms: float
    bench: str
    devices: dict[str, DeviceState]
    runs: dict[str, RunSummary]
    control: ControlState
    goals: dict[str, GoalState]
    jogs: dict[str, JogState]
    launches: dict[str, LaunchState]


class Patch(Told):
    """Event `patch`: what has changed, each entry whole; null for one that is gone."""

    seq: int
    server_time_ms: float
    devices: dict[str, DeviceState | None] = Field(default_factory=dict)
    runs: dict[str, RunSummary | None] = Field(default_factory=dict)
    goals: dict[str, GoalState | None] = Field(default_factory=dict)
    jogs: dict[str, JogState | None] = Field(default_factory=dict)
    launches: dict[str, LaunchState | None] = Field(default_factory=dict)
    control: ControlState | None = Field(default=None, description="Null: unchanged.")


class RunPatch(Told):
    """Event `run_patch`: of a run that is watched, ten times a second at most."""

    run: str
    seq: int
    head: RunHead
    nodes: dict[str, NodeState] = Field(default_factory=dict)
    points: list[PointState] = Field(default_factory=list)


class RunLog(Told):
    """Event `log`: new lines of a run that is watched."""

    run: str
    lines: list[LogLine]


class Notice(Told):
    """Event `notice`: something for a person to know."""

    level: Literal["info", "problem"]
    text: str
    run: str | None = None
    device: str | None = None


class Watched(Told):
    """The acknowledgement of `watch`: the run as it is now, or why not."""

    ok: bool
    text: str = ""
    run: RunDetail | None = None
