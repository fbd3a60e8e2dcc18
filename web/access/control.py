"""Control of the bench: one named holder, renewed by use, released after five idle minutes."""

import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from ..local.clock import iso, now_iso
from ..local.refusal import Refusal
from ..models.control import ControlState, ControlTaken

IDLE_S = 300.0
Level = Literal["info", "problem"]


@dataclass(slots=True)
class Holder:
    """Who has control; `lease` is the secret that proves it, `used_s` a monotonic time."""

    name: str
    lease: str
    since: str
    used_s: float


class Control:
    """One holder at a time; `changed` is called with the public state.

    `armed` tells whether a hazard is armed: control does not change hands then.
    """

    def __init__(
        self, changed: Callable[[], None], armed: Callable[[], bool], tell: Callable[[str, Level], None],
        idle_s: float = IDLE_S,
    ) -> None:  # fmt: skip
        self._holder: Holder | None = None
        self._changed = changed
        self._armed = armed
        self._tell = tell
        self._idle_s = idle_s

    @property
    def holder(self) -> Holder | None:
        """The current holder; one who was idle for too long has lost control."""
        if self._holder is not None and time.monotonic() - self._holder.used_s > self._idle_s:
            self._tell(f"{self._holder.name} was idle; control is free", "info")
            self._holder = None
            self._changed()
        return self._holder

    def state(self) -> ControlState:
        """The public state."""
        holder = self.holder
        if holder is None:
            return ControlState(armed=self._armed())
        left_s = self._idle_s - (time.monotonic() - holder.used_s)
        return ControlState(
            holder=holder.name, since=holder.since, ends_at=iso(time.time() + left_s),
            armed=self._armed(),
        )  # fmt: skip

    def used_by(self, lease: str | None) -> str:
        """The holder's name if the lease is theirs; otherwise raises Refusal (423)."""
        holder = self.holder
        if holder is None or lease is None or not _same(lease, holder.lease):
            raise _no_control(holder)
        holder.used_s = time.monotonic()
        self._changed()
        return holder.name

    def take(self, name: str, reason: str, lease: str | None) -> ControlTaken:
        """Take control; from another holder only with a reason, and never while something is armed.

        The holder's own lease is renewed and stays the same. The same person in another browser
        needs no reason.
        """
        holder, name = self.holder, " ".join(name.split())
        if not name:
            raise Refusal(422, "INVALID", "a name is required: it is logged with every command")
        ours = holder is not None and lease is not None and _same(lease, holder.lease)
        if holder is not None and not ours:
            same_person = name.casefold() == holder.name.casefold()
            if not reason.strip() and not same_person:
                raise _no_control(holder)
            if self._armed():
                raise Refusal(
                    409,
                    "ARMED",
                    f"{holder.name} has armed an action; control cannot change hands until that is over",
                )
            if same_person:
                self._tell(f"{name} has control in another browser now", "info")
            else:
                words = f"{name} took control over from {holder.name}: {reason.strip()}"
                self._tell(words, "problem")
        now_s = time.monotonic()
        if holder is not None and ours:  # commands under way with this lease stay theirs
            self._holder = Holder(name, holder.lease, holder.since, now_s)
        else:
            self._holder = Holder(name, secrets.token_urlsafe(24), now_iso(), now_s)
        self._changed()
        return ControlTaken(lease=self._holder.lease, control=self.state())

    def release(self, lease: str | None) -> None:
        """Give control back; an expired lease is ignored."""
        holder = self._holder
        if holder is not None and lease is not None and _same(lease, holder.lease):
            self._holder = None
            self._changed()

    def ask(self, name: str) -> str:
        """Notify the holder that somebody wants control; returns a sentence."""
        holder = self.holder
        if holder is None:
            return "control is free: take it"
        self._tell(f"{name} asks {holder.name} for control", "problem")
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
