"""A lease says who may send goals to a device, until when, and under which epoch."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from ...schemas.messages import LeaseRequest, Refusal
from .ledger import Ledger

ASKS_KEPT = 100
"""How many lease requests are remembered, to recognise late copies."""


class Refused(Exception):
    """A refused request, as it goes over the wire."""

    def __init__(self, code: Refusal, message: str, **more: object) -> None:
        super().__init__(message)
        self.code: Refusal = code
        self.message = message
        self.more = more

    def answer(self) -> dict[str, object]:
        """The acknowledgement with the refusal."""
        return {"ok": False, "code": self.code, "message": self.message, **self.more}


@dataclass(slots=True)
class Holder:
    """The holder of a lease and its connection."""

    owner: str
    epoch: int
    session: str
    timer: asyncio.TimerHandle


class Lease:
    """The lease of one device; epochs only grow, across restarts too."""

    def __init__(self, device: str, ledger: Ledger, lapsed: Callable[[int], None]) -> None:
        self.device = device
        self._ledger = ledger
        self._lapsed = lapsed
        self.holder: Holder | None = None
        self._given: dict[str, int] = {}
        self._closed = False
        self._writing = asyncio.Lock()

    @property
    def is_free(self) -> bool:
        """Nobody holds it, and nobody is being granted it."""
        return self.holder is None and not self._writing.locked()

    async def take(self, request: LeaseRequest, session: str) -> int:
        """Grant the lease, or renew it if the request names the epoch; return the current epoch."""
        if request.epoch is not None:
            self._check_free(request.owner)
            return self._renew(request, request.epoch, session)
        async with self._writing:
            self._check_free(request.owner)
            if request.ask is not None and request.ask in self._given:
                return self._renew(request, self._given[request.ask], session)
            epoch = await self._ledger.queued(self._ledger.lease, self.device, request.owner)
            self._check_open()
            self._stop_clock()
            self.holder = Holder(request.owner, epoch, session, self._clock(request.ttl_s))
            self._remember(request.ask, epoch)
            return epoch

    def _check_free(self, owner: str) -> None:
        self._check_open()
        if self.holder is not None and self.holder.owner != owner:
            raise Refused(
                "HELD", f"{self.device} is held by {self.holder.owner}", holder=self.holder.owner
            )

    def _check_open(self) -> None:
        if self._closed:
            raise Refused("ENDING", f"the device server of {self.device} is shutting down")

    def _remember(self, ask: str | None, epoch: int) -> None:
        """A token requests one lease only, so that a late copy of it fences no one."""
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
        """Raise Refused unless `epoch` is that of the current lease."""
        self._check_open()
        if self.holder is None:
            raise Refused(
                "STALE_EPOCH", f"no lease on {self.device} has epoch {epoch}; take its lease"
            )
        if epoch != self.holder.epoch:
            raise Refused(
                "STALE_EPOCH",
                f"{self.device}: epoch {epoch} is over, {self.holder.owner} holds it now",
                holder=self.holder.owner,
            )

    async def release(self, owner: str, epoch: int | None) -> int | None:
        """End the lease if it is this owner's, and return its epoch; None if it is not."""
        async with self._writing:
            holder = self.holder
            if holder is None or holder.owner != owner or epoch not in (None, holder.epoch):
                return None
            self._stop_clock()
            self.holder = None
            return holder.epoch

    def _clock(self, ttl_s: float) -> asyncio.TimerHandle:
        return asyncio.get_running_loop().call_later(ttl_s, self._lapse)

    def _stop_clock(self) -> None:
        if self.holder is not None:
            self.holder.timer.cancel()

    def _lapse(self) -> None:
        holder, self.holder = self.holder, None
        if holder is not None:
            self._lapsed(holder.epoch)

    def close(self) -> None:
        """Let no timer outlive the server, and grant it to nobody any more."""
        self._closed = True
        self._stop_clock()
        self.holder = None
