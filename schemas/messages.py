"""The messages between engine and device server on the namespace `/action`."""

from hashlib import sha256
from typing import Any, Literal

from pydantic import Field

from .contract import Happened
from .model import Model

NAMESPACE = "/action"

GoalState = Literal["ACCEPTED", "EXECUTING", "CANCELING", "SUCCEEDED", "CANCELED", "ABORTED"]
ENDED: frozenset[str] = frozenset({"SUCCEEDED", "CANCELED", "ABORTED"})
Refusal = Literal[
    "HELD",
    "BUSY",
    "REJECTED",
    "STOPPED",
    "INVALID",
    "STALE_BOOT",
    "STALE_EPOCH",
    "ENDING",
    "EXCEPTION",
    "UNKNOWN_DEVICE",
]


class GoalError(Model):
    """Why a goal ended ABORTED: an error name of the contract, a message, and what is known."""

    name: str
    message: str = ""
    happened: Happened = "unknown"


class FileContent(Model):
    """A file that travels with a goal or its result; `path` is relative to the run's folder."""

    path: str
    sha256: str
    data: bytes

    @classmethod
    def of(cls, path: str, data: bytes) -> "FileContent":
        """A file as it is sent."""
        return cls(path=path, sha256=sha256(data).hexdigest(), data=data)


class BenchPlace(Model):
    """Where on the bench the edges of a picture from above are, in mm."""

    left: float
    right: float
    front: float
    back: float


class Look(Model):
    """The answer to `picture`; `place` is given for one from above."""

    file: FileContent
    place: BenchPlace | None = None


class Goal(Model):
    """A request to do one action. The same id is the same goal and never executes twice.

    The server cancels it `timeout_s` after it has accepted it, whoever still asks for it.
    """

    id: str = Field(min_length=1, max_length=1000)
    device: str
    boot: str
    epoch: int
    action: str
    params: dict[str, Any] = Field(default_factory=dict)
    timeout_s: float | None = Field(default=None, ge=0)
    files: dict[str, FileContent] = Field(default_factory=dict)


class GoalReport(Model):
    """What a server knows about one goal: in acknowledgements, answers to `query`, and `update`.

    `mark`, in answers only: the newest change in the ledger, which contains the goal by then.
    """

    id: str
    state: GoalState
    seq: int = 0
    boot: str = ""
    progress: float | None = None
    message: str = ""
    result: dict[str, Any] | None = None
    error: GoalError | None = None
    files: dict[str, FileContent] = Field(default_factory=dict)
    mark: str = ""

    @property
    def ended(self) -> bool:
        """True when nothing more will happen to the goal."""
        return self.state in ENDED


class LeaseRequest(Model):
    """A request for a device's lease: who wants it and for how long; `epoch` when renewing.

    `ask` is a new token for every lease that is wanted: repeating it, in a late copy or because the
    answer was lost, gives no second one. `again` is set when an engine retakes automatically what it
    had before: that does not end the hold after a stop, which it may not know about.
    """

    device: str
    owner: str
    ttl_s: float = Field(gt=0, le=3600)
    epoch: int | None = None
    ask: str | None = None
    again: bool = False


class DeviceDescription(Model):
    """One device as its server describes it; `stop_grace_s`: how long a stop of it may take."""

    contract: dict[str, Any]
    driver: str
    versions: dict[str, str] = Field(default_factory=dict)
    limits: dict[str, Any] = Field(default_factory=dict)
    status: dict[str, Any] = Field(default_factory=dict)
    holder: str = ""
    """Whose lease it is; empty if it is free."""
    stopped: str = ""
    """Who stopped it, and when, until its lease is taken again; empty if nobody has."""
    stop_grace_s: float = 10.0


class ServerDescription(Model):
    """What a device server serves; `boot` is new at every start, `ledger` stays.

    `mark` is the newest change in the ledger. `continues` is false if the ledger lacks the mark that
    the client has sent along: it was replaced by an older copy, or is another one.
    """

    boot: str
    ledger: str
    mark: str = ""
    continues: bool = True
    devices: dict[str, DeviceDescription]


class QueryAnswer(Model):
    """Reports on goals; null where the server has no record of the id."""

    boot: str
    ledger: str
    goals: dict[str, GoalReport | None]


def ledger_of(boot: str) -> str:
    """The id of the ledger that a boot was made for: the part before its dot."""
    return boot.partition(".")[0]
