"""The engine's side of the wire: hold leases, follow goals, and never guess how one ended."""

import asyncio
from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from ..schemas.messages import (
    ENDED,
    DeviceDescription,
    Goal,
    GoalReport,
    QueryAnswer,
    ServerDescription,
)
from .holding import Holding, LeaseHeld
from .link import Answer, Link, LinkDown, ServerUnreachable, accepted
from .lookout import Lookout
from .outcome import Outcome, refused

__all__ = ["DeviceClient", "LeaseHeld", "Outcome", "ServerUnreachable"]

MAX_FILES_BYTES = 60_000_000
LINK_S = 5.0


class DeviceClient:
    """One device server, as the engine uses it; the connection comes back by itself."""

    def __init__(
        self,
        url: str,
        token: str | None = None,
        *,
        lost_after_s: float = 60.0,
        on_status: Callable[[str, dict[str, Any]], None] | None = None,
        on_link: Callable[[bool], None] | None = None,
    ) -> None:
        self.url = url.rstrip("/")
        self.boot = ""
        self.ledger = ""
        self.devices: dict[str, DeviceDescription] = {}
        self._on_status = on_status
        self._on_link = on_link
        events = {"update": self._update, "status": self._status}
        self._link = Link(self.url, token, events, self._link_up, self._link_down)
        self._holding = Holding(self._link)
        self._lookout = Lookout(self._link, lost_after_s)

    async def open(self, timeout_s: float = 5.0) -> ServerDescription:
        """Connect and learn what the server serves; raises ServerUnreachable."""
        await self._link.open(timeout_s)
        self._lookout.open()
        return ServerDescription(boot=self.boot, ledger=self.ledger, devices=self.devices)

    async def close(self) -> None:
        """Disconnect; leases that were not released lapse by themselves."""
        await self._holding.close()
        await self._link.close()
        await self._lookout.close()

    async def take_lease(self, device: str, owner: str, ttl_s: float = 30.0) -> int:
        """The lease's epoch; it is renewed until it is released. Raises LeaseHeld.

        A connection that breaks meanwhile is waited for, up to LINK_S.
        """
        try:
            async with asyncio.timeout(LINK_S):
                return await self._holding.take(device, owner, ttl_s)
        except TimeoutError:
            raise ServerUnreachable(self.url, self._link.refusal or "no answer") from None

    async def release(self, device: str) -> None:
        """Give the lease back; where the server is away it lapses by itself."""
        await self._holding.release(device)

    def epoch(self, device: str) -> int:
        """The epoch of the lease that is held on a device; KeyError where none is."""
        return self._holding.epoch(device)

    async def follow(
        self,
        goal: Goal,
        on_report: Callable[[GoalReport], None] = lambda report: None,
        *,
        send: bool = True,
    ) -> Outcome:
        """Send a goal and wait for its end, whatever happens to connection and server meanwhile.

        Without `send` it is only asked what became of it; one that never arrived is buried, so
        that no late copy of it can start. A goal that bears an earlier boot is never sent, either.
        Cancelling the wait leaves the goal alone; call `cancel` to end it.
        """
        size = sum(len(file.data) for file in goal.files.values())
        if size > MAX_FILES_BYTES:
            return refused("INVALID", f"{size} bytes of files are too much for one goal", self.boot)
        return await self._lookout.follow(goal, on_report, send=send)

    async def keep(self, goal: Goal) -> bool:
        """Send a goal again that has been sent, which holds a jog; False once it has ended.

        It starts nothing twice: the same id is the same goal. Nothing is kept for later where the
        connection is down, and none that bears an earlier boot is sent. Raises ServerUnreachable.
        """
        try:
            answer = await self._link.call("goal", goal.model_dump(exclude_defaults=True))
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault
        return bool(answer.get("ok")) and answer.get("state") not in ENDED

    async def cancel(self, goal_id: str) -> None:
        """Ask the server to end a goal; a goal that is followed is asked about until it worked."""
        try:
            await self._lookout.cancel(goal_id)
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault

    async def query(self, ids: list[str]) -> QueryAnswer:
        """What the server knows of goals; raises ServerUnreachable."""
        try:
            return await self._lookout.query(ids)
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault

    async def stop(
        self, device: str | None = None, timeout_s: float = 10.0
    ) -> dict[str, tuple[bool, str]]:
        """Bring one device or all into the safe state; device -> (confirmed, in words)."""
        # The server gives up a little earlier than we do, so that its own words arrive.
        request: Answer = {"timeout_s": 0.9 * timeout_s}
        if device is not None:
            request["device"] = device
        names = [device] if device is not None else list(self.devices)
        try:
            async with asyncio.timeout(timeout_s):
                await self._link.up.wait()
                answer = await self._link.call("stop", request, timeout_s)
        except (LinkDown, TimeoutError) as fault:
            words = str(fault) or f"no answer from {self.url} within {timeout_s:g} s"
            return dict.fromkeys(names, (False, words))
        if not answer.get("ok"):
            return dict.fromkeys(names, (False, str(answer.get("message"))))
        return {name: (told["safe"], told["message"]) for name, told in answer["devices"].items()}

    async def _link_up(self) -> None:
        """On every new connection: who is it, and are our leases still ours?"""
        answer = accepted(await self._link.call("describe", {}), self.url)
        try:
            described = ServerDescription.model_validate(answer)
        except ValidationError as fault:
            raise ServerUnreachable(self.url, "it speaks another version of labrun") from fault
        restarted = described.boot != self.boot
        self.boot = self._lookout.boot = described.boot
        self.ledger, self.devices = described.ledger, described.devices
        await self._holding.confirm(restarted=restarted)
        self._lookout.doubt_all()
        if self._on_link is not None:
            self._on_link(True)

    def _link_down(self) -> None:
        self._lookout.doubt_all()
        if self._on_link is not None:
            self._on_link(False)

    def _update(self, data: Answer) -> None:
        self._lookout.update(data)

    def _status(self, data: Answer) -> None:
        if self._on_status is not None:
            status = dict(data)
            self._on_status(str(status.pop("device", "")), status)
