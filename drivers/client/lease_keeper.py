"""The leases that a client holds: taken, renewed automatically, taken again after a restart."""

import asyncio
import contextlib
import secrets
from dataclasses import dataclass, field
from typing import Any

from ...system.tasks import end, keep
from .link import Link, LinkDown, ServerUnreachable, accepted


class LeaseHeld(Exception):
    """The device is held by another client."""

    def __init__(self, device: str, holder: str) -> None:
        super().__init__(f"{device} is held by {holder}")
        self.device = device
        self.holder = holder


AGAIN_S = 0.05
RELEASE_S = 5.0
"""How long a release is repeated over a connection that breaks, before the lease is left to lapse."""


def _new_word() -> str:
    return secrets.token_hex(8)


@dataclass(slots=True)
class _Lease:
    device: str
    owner: str
    ttl_s: float
    epoch: int = 0
    lapsed: int = 0
    ask: str = field(default_factory=_new_word)
    task: asyncio.Task[None] | None = None


class LeaseKeeper:
    """Every lease of one client on one server."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._leases: dict[str, _Lease] = {}

    def epoch(self, device: str) -> int:
        """The epoch of the lease on a device; KeyError if none is held."""
        return self._leases[device].epoch

    def lapsed(self, device: str) -> int:
        """The epoch of the newest lease of a device that had lapsed when ours was taken, or 0."""
        return self._leases[device].lapsed

    async def take(self, device: str, owner: str, ttl_s: float) -> int:
        """Take a lease, which is renewed until it is released, and return its epoch. Raises LeaseHeld.

        Retries until there is an answer, however often the connection breaks: limit the wait.
        """
        await self._forget(device)
        lease = _Lease(device, owner, ttl_s)
        while True:
            await self._link.up.wait()
            with contextlib.suppress(LinkDown):
                await self._ask_anew(lease)
                break
            await asyncio.sleep(AGAIN_S)
        name = f"renewing the lease on {device}"
        lease.task = keep(name, lambda: self._keep(lease), again_s=0)
        self._leases[device] = lease
        return lease.epoch

    async def release(self, device: str, within_s: float = RELEASE_S) -> None:
        """Release the lease, until the server has answered; one out of reach lets it lapse."""
        lease = await self._forget(device)
        if lease is None:
            return
        request = {"device": device, "owner": lease.owner, "epoch": lease.epoch}
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                while True:
                    await self._link.up.wait()
                    with contextlib.suppress(LinkDown):
                        await self._link.call("release", request)
                        return
                    await asyncio.sleep(AGAIN_S)

    async def confirm(self, *, restarted: bool) -> None:
        """On a new connection, take leases again that the server forgot or saw lapse."""
        for lease in list(self._leases.values()):
            with contextlib.suppress(LeaseHeld, ServerUnreachable):
                if restarted:
                    await self._ask_anew(lease, again=True)
                else:
                    await self._renew(lease)

    async def close(self) -> None:
        """Stop renewing; leases that were not released lapse on their own."""
        for device in list(self._leases):
            await self._forget(device)

    async def _renew(self, lease: _Lease) -> None:
        """Renew a lease; one that lapsed meanwhile is taken again, with a higher epoch."""
        if not await self._ask(lease, epoch=lease.epoch):
            # This is automatic: a stop that came meanwhile must keep its hold.
            await self._ask_anew(lease, again=True)

    async def _ask_anew(self, lease: _Lease, **more: Any) -> None:
        """Use one token until it is answered, so that a late copy changes nothing."""
        while not await self._ask(lease, ask=lease.ask, **more):
            lease.ask = _new_word()  # the lease given for this token is already over
        lease.ask = _new_word()

    async def _ask(self, lease: _Lease, **more: Any) -> bool:
        """False where a lease that should be renewed is over."""
        request = {"device": lease.device, "owner": lease.owner, "ttl_s": lease.ttl_s, **more}
        answer = await self._link.call("lease", request)
        if answer.get("code") == "HELD":
            raise LeaseHeld(lease.device, str(answer.get("holder")))
        if answer.get("code") == "STALE_EPOCH":
            return False
        given = accepted(answer, self._link.url)
        lease.epoch, lease.lapsed = given["epoch"], given.get("lapsed", 0)
        return True

    async def _keep(self, lease: _Lease) -> None:
        while True:
            await asyncio.sleep(lease.ttl_s / 3)
            # While the link is down, `confirm` renews; a lease that another client now holds is
            # requested again, since only that client can release it.
            with contextlib.suppress(LinkDown, LeaseHeld, ServerUnreachable):
                await self._renew(lease)

    async def _forget(self, device: str) -> _Lease | None:
        lease = self._leases.pop(device, None)
        if lease is not None:
            await end(lease.task)
        return lease
