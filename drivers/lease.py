"""A lease says who may send goals to a device, until when, and under which epoch."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from ..schemas.messages import LeaseRequest, Refusal
from .ledger import Ledger

ASKS_KEPT = 100
"""Of how many requests for a lease a late copy is still known."""


class Refused(Exception):
    """A request that is turned down, as it goes over the wire."""

    def __init__(self, code: Refusal, message: str, **more: object) -> None:
        super().__init__(message)
        self.code: Refusal = code
        self.message = message
        self.more = more

    def answer(self) -> dict[str, object]:
        """The acknowledgement that says so."""
        return {"ok": False, "code": self.code, "message": self.message, **self.more}


@dataclass(slots=True)
class Holder:
    """Who holds a lease, through which connection."""

    owner: str
    epoch: int
    session: str
    timer: asyncio.TimerHandle


class Lease:
    """The lease of one device; epochs only grow, over restarts too."""

    def __init__(self, device: str, ledger: Ledger, lapsed: Callable[[], None]) -> None:
        self.device = device
        self._ledger = ledger
        self._lapsed = lapsed
        self.holder: Holder | None = None
        self._given: dict[str, int] = {}

    def take(self, request: LeaseRequest, session: str) -> int:
        """Give the lease, or prolong it where the request names the epoch; the epoch it has now."""
        if self.holder is not None and self.holder.owner != request.owner:
            raise self._held(self.holder)
        if request.epoch is not None:
            return self._renew(request, request.epoch, session)
        if request.ask is not None and request.ask in self._given:
            return self._renew(request, self._given[request.ask], session)
        epoch = self._ledger.lease(self.device, request.owner)
        self._stop_clock()
        self.holder = Holder(request.owner, epoch, session, self._clock(request.ttl_s))
        self._remember(request.ask, epoch)
        return epoch

    def _remember(self, ask: str | None, epoch: int) -> None:
        """A word asks for one lease only, so that a late copy of it fences nobody."""
        if ask is not None:
            self._given[ask] = epoch
            if len(self._given) > ASKS_KEPT:
                del self._given[next(iter(self._given))]

    def _renew(self, request: LeaseRequest, epoch: int, session: str) -> int:
        holder = self.holder
        if holder is None or holder.epoch != epoch:
            raise Refused(
                "STALE_EPOCH",
                f"the lease of {self.device} under epoch {epoch} is over; take it again",
            )
        holder.timer.cancel()
        holder.timer = self._clock(request.ttl_s)
        holder.session = session
        return holder.epoch

    def check(self, epoch: int) -> None:
        """Raise Refused unless `epoch` is that of the lease which holds now."""
        if self.holder is None:
            raise Refused(
                "STALE_EPOCH", f"nobody holds {self.device} under epoch {epoch}; take its lease"
            )
        if epoch != self.holder.epoch:
            raise Refused(
                "STALE_EPOCH",
                f"{self.device}: epoch {epoch} is over, {self.holder.owner} holds it now",
                holder=self.holder.owner,
            )

    def release(self, owner: str, epoch: int | None) -> bool:
        """End the lease if it is this owner's; False where it was not."""
        holder = self.holder
        if holder is None or holder.owner != owner or epoch not in (None, holder.epoch):
            return False
        self._stop_clock()
        self.holder = None
        return True

    def _held(self, holder: Holder) -> Refused:
        return Refused("HELD", f"{self.device} is held by {holder.owner}", holder=holder.owner)

    def _clock(self, ttl_s: float) -> asyncio.TimerHandle:
        return asyncio.get_running_loop().call_later(ttl_s, self._lapse)

    def _stop_clock(self) -> None:
        if self.holder is not None:
            self.holder.timer.cancel()

    def _lapse(self) -> None:
        self.holder = None
        self._lapsed()

    def close(self) -> None:
        """Let no timer outlive the server."""
        self._stop_clock()
        self.holder = None
