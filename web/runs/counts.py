"""The state of each step and each iteration, counted as records arrive."""

from array import array
from collections import deque
from dataclasses import dataclass, field
from typing import Any, Literal

from ..models.runs import NodeState, PointState, Status

FATES: dict[str, Status] = {
    "succeeded": "ok", "failed": "failed", "skipped": "skipped", "cancelled": "cancelled",
    "unknown": "unknown",
}  # fmt: skip
STATUSES: tuple[Status, ...] = (
    "waiting",
    "running",
    "ok",
    "retrying",
    "skipped",
    "failed",
    "cancelled",
    "unknown",
)
CODE = {status: index for index, status in enumerate(STATUSES)}
PACE = 30
"""The pace is computed from this many of the last iterations."""


End = Literal["", "ok", "failed", "skipped", "cancelled", "unknown"]
ENDS: tuple[End, ...] = ("failed", "unknown", "cancelled")
"""States of a group by its worst member, the worst first."""


@dataclass(slots=True)
class NodeCount:
    """One step over all its iterations."""

    running: int = 0
    retrying: int = 0
    ok: int = 0
    failed: int = 0
    skipped: int = 0
    unknown: int = 0
    retries: int = 0
    last_s: float | None = None
    message: str = ""
    last: End = ""

    def end(
        self, status: Status, seconds: float | None, message: str, *, instead_of: str = ""
    ) -> str:
        """One more iteration has ended, or the same one anew; returns as what it is counted."""
        if instead_of:
            setattr(self, instead_of, getattr(self, instead_of) - 1)
        self.last_s = seconds
        self.last = status if status in ("ok", "failed", "skipped", "cancelled") else "unknown"
        counted = status if status in ("ok", "skipped", "unknown") else "failed"
        setattr(self, counted, getattr(self, counted) + 1)
        self.message = message or self.message
        return counted

    def state(self) -> NodeState:
        """As sent to the page."""
        status: Status = self.last or "waiting"
        if self.running:
            status = "retrying" if self.retrying else "running"
        return NodeState.of(self, status=status)


@dataclass(slots=True)
class Table:
    """The iterations of one loop, within one iteration of the loops around it: columns of arrays.

    `first` and `last` are the offsets in the journal between which the records of each lie; `counted`
    is how the loop's own end is counted in its step.
    """

    loop: str
    within: str
    slots: dict[str, int] = field(default_factory=dict)
    by_index: dict[int, int] = field(default_factory=dict)
    keys: list[str] = field(default_factory=list)
    index: array = field(default_factory=lambda: array("q"))
    status: bytearray = field(default_factory=bytearray)
    tries: array = field(default_factory=lambda: array("l"))
    began: array = field(default_factory=lambda: array("d"))
    ended: array = field(default_factory=lambda: array("d"))
    first: array = field(default_factory=lambda: array("q"))
    last: array = field(default_factory=lambda: array("q"))
    messages: dict[int, str] = field(default_factory=dict)
    total: int | None = None
    counted: str = ""
    counts: dict[Status, int] = field(default_factory=dict)
    current: int | None = None
    paces: deque[float] = field(default_factory=lambda: deque(maxlen=PACE))
    ended_at: float | None = None

    def touch(self, key: str, offset: int, at: float) -> int:
        """The slot of an iteration in which something happens; a new one is running."""
        slot = self.slots.get(key)
        if slot is None:
            slot = len(self.keys)
            self.slots[key] = slot
            self.keys.append(key)
            self.by_index[slot] = slot
            self.index.append(slot)
            self.status.append(CODE["running"])
            self.tries.append(0)
            self.began.append(at)
            self.ended.append(0.0)
            self.first.append(offset)
            self.last.append(offset)
        elif not self.ended[slot]:
            self.last[slot] = offset
            if self.status[slot] in (CODE["waiting"], CODE["cancelled"]):
                self.status[slot], self.began[slot] = CODE["running"], at
        if not self.ended[slot]:
            self.current = slot
        return slot

    def is_running(self, key: str) -> bool:
        """True between the beginning of an iteration and its end."""
        slot = self.slots.get(key)
        return slot is not None and self.status[slot] == CODE["running"]

    def reopen(self, slot: int) -> None:
        """A finished iteration is entered again."""
        if self.ended[slot]:
            status = STATUSES[self.status[slot]]
            self.counts[status] = self.counts.get(status, 0) - 1
            self.ended[slot], self.status[slot] = 0.0, CODE["waiting"]
            self.messages.pop(slot, None)

    def under_way(self) -> list[int]:
        """Iterations that have begun and not ended."""
        running = CODE["running"]
        return [slot for slot, status in enumerate(self.status) if status == running]

    def end(self, slot: int, index: int, status: Status, at: float, message: str) -> None:
        """An iteration has ended."""
        self.by_index[index] = slot
        self.index[slot] = index
        self.status[slot] = CODE[status]
        self.ended[slot] = at
        self.counts[status] = self.counts.get(status, 0) + 1
        if message:
            self.messages[slot] = message
        if self.ended_at is not None and at >= self.ended_at:
            self.paces.append(at - self.ended_at)
        self.ended_at = at
        if self.current == slot:
            self.current = None

    def cut(self) -> None:
        """The engine is gone, or the run is paused: the pace is measured anew."""
        self.ended_at = None

    @property
    def done(self) -> int:
        """Iterations that have ended."""
        return sum(self.counts.values())

    def columns(self, window: range) -> dict[str, list[Any]]:
        """Iterations by their indexes, also those that have not begun, as columns."""
        slots = [self.by_index.get(index) for index in window]
        return {
            "key": [None if at is None else self.keys[at] for at in slots],
            "status": [STATUSES[0 if at is None else self.status[at]] for at in slots],
            "seconds": [None if at is None else self._seconds(at) for at in slots],
            "tries": [0 if at is None else self.tries[at] for at in slots],
            "message": ["" if at is None else self.messages.get(at, "") for at in slots],
        }

    def _seconds(self, slot: int) -> float | None:
        ended = self.ended[slot]
        return round(ended - self.began[slot], 3) if ended else None

    def point(self, slot: int) -> PointState:
        """One iteration as sent to the page."""
        return PointState(
            loop=self.loop, within=self.within, index=self.index[slot], key=self.keys[slot],
            status=STATUSES[self.status[slot]],
            seconds=self._seconds(slot),
            tries=self.tries[slot], message=self.messages.get(slot, ""),
        )  # fmt: skip


def worst_of(ends: list[End]) -> End:
    """The state of a group from those of its steps."""
    worst: End = ends[-1]
    for end in reversed(ENDS):
        worst = end if end in ends else worst
    return worst
