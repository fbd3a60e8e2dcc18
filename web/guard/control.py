"""Control of the bench: one holder with a name, renewed by use, free after five idle minutes."""

import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

from ..models.control import ControlState, ControlTaken
from .refusal import Refusal

IDLE_S = 300.0


@dataclass(slots=True)
class Holder:
    """Who has control; `lease` is the secret that proves it."""

    name: str
    lease: str
    since: float
    used: float


class Control:
    """One holder at a time; `changed` is called with the state that everybody sees.

    `armed` says whether a hazard is armed, since control does not change hands then.
    """

    def __init__(
        self, changed: Callable[[], None], armed: Callable[[], bool], tell: Callable[[str], None],
        idle_s: float = IDLE_S,
    ) -> None:  # fmt: skip
        self._holder: Holder | None = None
        self._changed = changed
        self._armed = armed
        self._tell = tell
        self._idle_s = idle_s

    @property
    def holder(self) -> Holder | None:
        """Whoever has control now; one who was idle for too long has lost it."""
        if self._holder is not None and time.time() - self._holder.used > self._idle_s:
            self._tell(f"{self._holder.name} was idle; control is free")
            self._holder = None
            self._changed()
        return self._holder

    def state(self) -> ControlState:
        """What everybody sees."""
        holder = self.holder
        if holder is None:
            return ControlState(armed=self._armed())
        return ControlState(
            holder=holder.name, since=_iso(holder.since),
            ends_at=_iso(holder.used + self._idle_s), armed=self._armed(),
        )  # fmt: skip

    def used_by(self, lease: str | None) -> str:
        """The holder's name, if the lease is theirs; raises Refusal (423) otherwise."""
        holder = self.holder
        if holder is None or lease is None or not _same(lease, holder.lease):
            raise _no_control(holder)
        holder.used = time.time()
        self._changed()
        return holder.name

    def take(self, name: str, reason: str, lease: str | None) -> ControlTaken:
        """Take control; from somebody else only with a reason, and never while something is armed.

        The holder's own lease is renewed and stays the same.
        """
        holder, name = self.holder, " ".join(name.split())
        if not name:
            raise Refusal(422, "INVALID", "a name is needed: it stands in the log of what is done")
        ours = holder is not None and lease is not None and _same(lease, holder.lease)
        if holder is not None and not ours:
            if not reason.strip():
                raise _no_control(holder)
            if self._armed():
                raise Refusal(
                    409, "ARMED", f"{holder.name} has something armed; control stays until then"
                )
            self._tell(f"{name} took control over from {holder.name}: {reason.strip()}")
        now = time.time()
        if holder is not None and ours:  # what is under way with this lease stays theirs
            self._holder = Holder(name, holder.lease, holder.since, now)
        else:
            self._holder = Holder(name, secrets.token_urlsafe(24), now, now)
        self._changed()
        return ControlTaken(lease=self._holder.lease, control=self.state())

    def release(self, lease: str | None) -> None:
        """Give control back; a lease that is over already does no harm."""
        holder = self._holder
        if holder is not None and lease is not None and _same(lease, holder.lease):
            self._holder = None
            self._changed()

    def ask(self, name: str) -> str:
        """Let the holder know that somebody wants it; a sentence."""
        holder = self.holder
        if holder is None:
            return "nobody has control: take it"
        self._tell(f"{name} asks {holder.name} for control")
        return f"{holder.name} was asked"


def _no_control(holder: Holder | None) -> Refusal:
    if holder is None:
        return Refusal(423, "NO_CONTROL", "nobody has control of the bench", "take control first")
    return Refusal(
        423, "NO_CONTROL", f"{holder.name} has control of the bench",
        "ask for it, or take it over with a reason", details={"holder": holder.name},
    )  # fmt: skip


def _same(a: str, b: str) -> bool:
    return secrets.compare_digest(a.encode(), b.encode())


def _iso(at: float) -> str:
    return datetime.fromtimestamp(at, UTC).isoformat(timespec="milliseconds")
