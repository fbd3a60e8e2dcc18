"""The leases that a client holds: taken, renewed by themselves, taken again after a restart."""

import asyncio
import contextlib
import secrets
from dataclasses import dataclass, field
from typing import Any

from .link import Link, LinkDown, ServerUnreachable, accepted


class LeaseHeld(Exception):
    """A device that somebody else works with."""

    def __init__(self, device: str, holder: str) -> None:
        super().__init__(f"{device} is held by {holder}")
        self.device = device
        self.holder = holder


AGAIN_S = 0.05


def _new_word() -> str:
    return secrets.token_hex(8)


@dataclass(slots=True)
class _Lease:
    device: str
    owner: str
    ttl_s: float
    epoch: int = 0
    ask: str = field(default_factory=_new_word)
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
        """The epoch of a new lease, which is renewed until it is released. Raises LeaseHeld.

        Asked for until there is an answer, however often the connection breaks: limit the wait.
        """
        await self._forget(device)
        lease = _Lease(device, owner, ttl_s)
        while True:
            await self._link.up.wait()
            with contextlib.suppress(LinkDown):
                await self._ask_anew(lease)
                break
            await asyncio.sleep(AGAIN_S)
        lease.task = asyncio.create_task(self._keep(lease))
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
                if restarted:
                    await self._ask_anew(lease, again=True)
                else:
                    await self._renew(lease)

    async def close(self) -> None:
        """Renew nothing any more; what was not released lapses by itself."""
        for device in list(self._leases):
            await self._forget(device)

    async def _renew(self, lease: _Lease) -> None:
        """Prolong a lease; one that lapsed meanwhile is taken again, under a higher epoch."""
        if not await self._ask(lease, epoch=lease.epoch):
            # Nobody decided on it: a stop that came meanwhile must keep its hold.
            await self._ask_anew(lease, again=True)

    async def _ask_anew(self, lease: _Lease, **more: Any) -> None:
        """By one word until it is answered, so that a copy that comes late changes nothing."""
        while not await self._ask(lease, ask=lease.ask, **more):
            lease.ask = _new_word()  # what the word was given is over already
        lease.ask = _new_word()

    async def _ask(self, lease: _Lease, **more: Any) -> bool:
        """False where a lease that should be renewed is over."""
        request = {"device": lease.device, "owner": lease.owner, "ttl_s": lease.ttl_s, **more}
        answer = await self._link.call("lease", request)
        if answer.get("code") == "HELD":
            raise LeaseHeld(lease.device, str(answer.get("holder")))
        if answer.get("code") == "STALE_EPOCH":
            return False
        lease.epoch = accepted(answer, self._link.url)["epoch"]
        return True

    async def _keep(self, lease: _Lease) -> None:
        while True:
            await asyncio.sleep(lease.ttl_s / 3)
            # With the link down it is `confirm` that renews; one that somebody else holds by now
            # is asked for again, since nobody but they can end their turn.
            with contextlib.suppress(LinkDown, LeaseHeld, ServerUnreachable):
                await self._renew(lease)

    async def _forget(self, device: str) -> _Lease | None:
        lease = self._leases.pop(device, None)
        if lease is not None and lease.task is not None:
            lease.task.cancel()
            await asyncio.gather(lease.task, return_exceptions=True)
        return lease
