"""The leases that a client holds: taken, renewed by themselves, taken again after a restart."""

import asyncio
import contextlib
from dataclasses import dataclass

from .link import Answer, Link, LinkDown, ServerUnreachable, accepted


class LeaseHeld(Exception):
    """A device that somebody else works with."""

    def __init__(self, device: str, holder: str) -> None:
        super().__init__(f"{device} is held by {holder}")
        self.device = device
        self.holder = holder


@dataclass(slots=True)
class _Lease:
    device: str
    owner: str
    ttl_s: float
    epoch: int = 0
    task: asyncio.Task[None] | None = None


class Holding:
    """Every lease of one client on one server."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._leases: dict[str, _Lease] = {}

    def epoch(self, device: str) -> int:
        """The epoch of the lease on a device; KeyError where none is held."""
        return self._leases[device].epoch

    async def take(self, device: str, owner: str, ttl_s: float) -> int:
        """The epoch of a new lease, which is renewed until it is released. Raises LeaseHeld."""
        await self._forget(device)
        lease = _Lease(device, owner, ttl_s)
        await self._ask(lease, anew=True)
        lease.task = asyncio.create_task(self._renew(lease))
        self._leases[device] = lease
        return lease.epoch

    async def release(self, device: str) -> None:
        """Give the lease back; where the server is away it lapses by itself."""
        lease = await self._forget(device)
        if lease is not None:
            request = {"device": device, "owner": lease.owner, "epoch": lease.epoch}
            with contextlib.suppress(LinkDown):
                await self._link.call("release", request)

    async def confirm(self, *, restarted: bool) -> None:
        """On a new connection: a lease that the server forgot or saw lapse is taken again."""
        for lease in list(self._leases.values()):
            with contextlib.suppress(LeaseHeld, ServerUnreachable):
                await self._ask(lease, anew=restarted)

    async def close(self) -> None:
        """Renew nothing any more; what was not released lapses by itself."""
        for device in list(self._leases):
            await self._forget(device)

    async def _ask(self, lease: _Lease, *, anew: bool) -> None:
        """Take or renew a lease; one that lapsed meanwhile is taken again, under a higher epoch."""
        request: Answer = {"device": lease.device, "owner": lease.owner, "ttl_s": lease.ttl_s}
        if not anew:
            request["epoch"] = lease.epoch
        answer = await self._link.call("lease", request)
        if answer.get("code") == "STALE_EPOCH" and not anew:
            await self._ask(lease, anew=True)
        elif answer.get("code") == "HELD":
            raise LeaseHeld(lease.device, str(answer.get("holder")))
        else:
            lease.epoch = accepted(answer, self._link.url)["epoch"]

    async def _renew(self, lease: _Lease) -> None:
        while True:
            await asyncio.sleep(lease.ttl_s / 3)
            # With the link down it is `confirm` that renews; one that somebody else holds by now
            # is asked for again, since nobody but they can end their turn.
            with contextlib.suppress(LinkDown, LeaseHeld, ServerUnreachable):
                await self._ask(lease, anew=False)

    async def _forget(self, device: str) -> _Lease | None:
        lease = self._leases.pop(device, None)
        if lease is not None and lease.task is not None:
            lease.task.cancel()
            await asyncio.gather(lease.task, return_exceptions=True)
        return lease
