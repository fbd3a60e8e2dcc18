"""The engine's side of the wire: hold leases, follow goals, never guess how a goal ended."""

import asyncio
import contextlib
import math
from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from ...schemas.messages import (
    ENDED,
    DeviceDescription,
    Goal,
    GoalReport,
    Look,
    QueryAnswer,
    ServerDescription,
)
from ...schemas.model import first_fault
from ..server.arguments import odd_value
from .goal_watch import GoalWatch
from .lease_keeper import LeaseHeld, LeaseKeeper
from .link import ANSWER_S, Answer, Link, LinkDown, ServerUnreachable, accepted
from .outcome import Outcome, refused

__all__ = ["DeviceClient", "LeaseHeld", "NoPicture", "Outcome", "ServerUnreachable"]

MAX_FILES_BYTES = 60_000_000
LINK_S = 5.0
DESCRIBE_S = 10.0
"""A server on a busy machine is slow to describe itself; another kind of server never does."""
STOPS = 4
"""How often a stop is sent within its time, as long as nobody answers."""
AGAIN_S = 0.05


class NoPicture(Exception):
    """A device that gives no picture now, with the reason."""


class DeviceClient:
    """One device server, as the engine uses it; it reconnects by itself.

    `mark` is the newest change in the server's ledger that this client, or whoever made it, has seen.
    `continues` becomes false when a ledger answers that lacks it; who has noted that sets it again.
    """

    def __init__(
        self,
        url: str,
        token: str | None = None,
        *,
        lost_after_s: float = 60.0,
        mark: str = "",
        on_status: Callable[[str, dict[str, Any]], None] | None = None,
        on_link: Callable[[bool], None] | None = None,
        link: type[Link] = Link,
    ) -> None:
        self.url = url.rstrip("/")
        self.boot = ""
        self.ledger = ""
        self.mark = mark
        self.continues = True
        self.devices: dict[str, DeviceDescription] = {}
        self.status: dict[str, dict[str, Any]] = {}
        self._told: dict[str, tuple[dict[str, Any], float]] = {}
        self.on_told: Callable[[], None] | None = None
        """Called when a device has told its status."""
        self._on_status = on_status
        self._on_link = on_link
        events = {
            "update": self._update, "status": self._status, "stopped": self._stopped,
            "ending": self._ends,
        }  # fmt: skip
        self._server_ends = False
        self.on_touch: Callable[[], None] | None = None
        """Called when `in_touch` may have changed."""
        self.on_stopped: Callable[[str, str], None] | None = None
        """Called with a device and who stopped it, when another client has."""
        self._link = link(self.url, token, events, self._link_up, self._link_down)
        self._lease_keeper = LeaseKeeper(self._link)
        self._goal_watch = GoalWatch(self._link, lost_after_s)

    @property
    def in_touch(self) -> bool:
        """Whether the server is there and stays: if not, its devices may lose what was set on them."""
        return self._link.up.is_set() and not self._server_ends

    async def open(self, timeout_s: float = 60.0) -> ServerDescription:
        """Connect and learn what the server serves; raises ServerUnreachable.

        `timeout_s` is for a server that is there and slow; one that refuses is given up sooner.
        """
        await self._link.open(timeout_s)
        self._goal_watch.open()
        return ServerDescription(boot=self.boot, ledger=self.ledger, devices=self.devices)

    async def close(self) -> None:
        """Disconnect; leases that were not released lapse on their own."""
        await self._lease_keeper.close()
        await self._link.close()
        await self._goal_watch.close()

    async def take_lease(self, device: str, owner: str, ttl_s: float = 30.0) -> int:
        """Take a lease and return its epoch; it is renewed until released. Raises LeaseHeld.

        If the connection breaks meanwhile, waits up to LINK_S for it.
        """
        try:
            async with asyncio.timeout(LINK_S):
                return await self._lease_keeper.take(device, owner, ttl_s)
        except TimeoutError:
            raise ServerUnreachable(self.url, self._link.refusal or "no answer") from None

    async def release(self, device: str) -> None:
        """Release the lease, within some seconds; if the server is out of reach, it lapses."""
        await self._lease_keeper.release(device)

    def newest_status(self, device: str) -> tuple[dict[str, Any], float]:
        """A device's status as its driver last gave it, and when by the event loop; -inf for never."""
        return self._told.get(device, ({}, -math.inf))

    def _hear(self, device: str, status: dict[str, Any]) -> None:
        """Keep a status, unless its driver did not answer: then the server repeats the last one."""
        if "fault" not in status:
            self._told[device] = status, asyncio.get_running_loop().time()
        if self.on_told is not None:
            self.on_told()

    def epoch(self, device: str) -> int:
        """The epoch of the lease held on a device; KeyError if there is none."""
        return self._lease_keeper.epoch(device)

    def lapsed(self, device: str) -> int:
        """The epoch of the newest lease after which the server made the device safe; 0 if none."""
        return self._lease_keeper.lapsed(device)

    async def follow(
        self,
        goal: Goal,
        on_report: Callable[[GoalReport], None] = lambda report: None,
        *,
        send: bool = True,
    ) -> Outcome:
        """Send a goal and wait for its end, whatever happens to the connection and server meanwhile.

        Without `send` the goal is only queried; one that never arrived gets a tombstone, so that
        no late copy of it can start. A goal from an earlier boot is never sent either.
        Cancelling the wait does not affect the goal; call `cancel` to end it.
        """
        size = sum(len(file.data) for file in goal.files.values())
        if size > MAX_FILES_BYTES:
            return refused("INVALID", f"{size} bytes of files are too many for one goal", self.boot)
        odd = odd_value(goal.params, f"{goal.device}.{goal.action}")
        if odd is not None:  # a NaN is no JSON: a server in another language drops the connection
            return refused("INVALID", odd, self.boot)
        return await self._goal_watch.follow(goal, self._marked(on_report), send=send)

    def _marked(self, on_report: Callable[[GoalReport], None]) -> Callable[[GoalReport], None]:
        def reported(report: GoalReport) -> None:
            self.mark = report.mark or self.mark
            on_report(report)

        return reported

    async def keep(self, goal: Goal) -> bool:
        """Resend a goal, which holds a jog; False once it has ended.

        It starts nothing twice: the same id is the same goal. While the connection is down nothing
        is queued, and no goal from an earlier boot is sent. Raises ServerUnreachable.
        """
        try:
            answer = await self._link.call("goal", goal.model_dump(exclude_defaults=True))
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault
        return bool(answer.get("ok")) and answer.get("state") not in ENDED

    async def cancel(self, goal_id: str) -> None:
        """Ask the server to end a goal; for a goal that is being followed, repeat until it worked."""
        try:
            await self._goal_watch.cancel(goal_id)
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault

    async def describe(self) -> dict[str, DeviceDescription]:
        """What the server says of its devices now; raises ServerUnreachable."""
        try:
            answer = accepted(await self._link.call("describe", {}), self.url)
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault
        return ServerDescription.model_validate(answer).devices

    async def look(self, device: str, above: bool, within_s: float) -> Look:
        """What a camera sees now; no goal, so nobody has to hold it and nothing is kept.

        `within_s`: how long its server may take, which is its contract's `look_s`.

        Raises NoPicture where it gives none, also while somebody uses it, and ServerUnreachable.
        """
        try:
            asked = {"device": device, **({"above": True} if above else {})}
            answer = await self._link.call("picture", asked, within_s + ANSWER_S)
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault
        if not answer.get("ok"):
            raise NoPicture(str(answer.get("message", "no reason given")))
        try:
            look = Look.model_validate({part: answer.get(part) for part in Look.model_fields})
        except ValidationError as fault:
            raise NoPicture(f"{device} gives no picture: {first_fault(fault)}") from fault
        if above and look.place is None:
            raise NoPicture(f"the server of {device} is older: it gives no picture from above")
        return look

    async def query(self, ids: list[str]) -> QueryAnswer:
        """What the server knows about goals; raises ServerUnreachable."""
        try:
            return await self._goal_watch.query(ids)
        except LinkDown as fault:
            raise ServerUnreachable(self.url, str(fault)) from fault

    async def knows(self, goal_id: str) -> bool:
        """Whether the server ever had a goal; raises ServerUnreachable."""
        return (await self.query([goal_id])).goals.get(goal_id) is not None

    async def stop(
        self, device: str | None = None, timeout_s: float | None = None, *, by: str = ""
    ) -> dict[str, tuple[bool, str]]:
        """Bring one device or all into the safe state; device -> (confirmed, message).

        `by` says who does it, and how: everybody who uses the device is told. Waits for as long as
        the lab allows its devices, and a little longer for the server's words.
        """
        names = [device] if device is not None else list(self.devices)
        graces = [self.devices[name].stop_grace_s for name in names if name in self.devices]
        timeout_s = timeout_s or max(graces, default=10.0) / 0.9
        again_s = max(timeout_s / STOPS, ANSWER_S)
        request: Answer = {"timeout_s": 0.9 * timeout_s, "by": by}
        if device is not None:
            request["device"] = device
        words = f"no response from {self.url} within {timeout_s:g} s"
        answer: Answer | None = None
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                while answer is None:  # a server that ends meanwhile is back within that time
                    await self._link.up.wait()
                    try:
                        answer = await self._link.call("stop", request, timeout_s, again_s)
                    except LinkDown as fault:
                        words = str(fault)
                        await asyncio.sleep(AGAIN_S)
        if answer is None:
            return dict.fromkeys(names, (False, words))
        if not answer.get("ok"):
            return dict.fromkeys(names, (False, str(answer.get("message"))))
        return {name: (told["safe"], told["message"]) for name, told in answer["devices"].items()}

    async def _link_up(self) -> None:
        """On every new connection: check which server it is and that our leases are still ours."""
        answer = await self._link.call("describe", {"mark": self.mark}, DESCRIBE_S)
        answer = accepted(answer, self.url)
        try:
            described = ServerDescription.model_validate(answer)
        except ValidationError as fault:
            raise ServerUnreachable(
                self.url, "it runs an incompatible version of labrun"
            ) from fault
        restarted = described.boot != self.boot
        self._server_ends = self._server_ends and not restarted
        self.mark = described.mark
        if not described.continues:
            self.continues = False
            self._goal_watch.lose_memory()
        self.boot = self._goal_watch.boot = described.boot
        self.ledger, self.devices = described.ledger, described.devices
        self.status = {name: device.status for name, device in described.devices.items()}
        for name, status in self.status.items():
            self._hear(name, status)
        await self._lease_keeper.confirm(restarted=restarted)
        self._goal_watch.doubt_all()
        for name, device in described.devices.items():
            if device.stopped and not restarted:
                self._stopped({"device": name, "message": device.stopped})
        if self._on_link is not None:
            self._on_link(True)
        self._touch()

    def _link_down(self) -> None:
        self._goal_watch.doubt_all()
        if self._on_link is not None:
            self._on_link(False)
        self._touch()

    def _touch(self) -> None:
        if self.on_touch is not None:
            self.on_touch()

    def _ends(self, data: Answer) -> None:
        self._server_ends = True
        self._touch()

    def _update(self, data: Answer) -> None:
        self._goal_watch.update(data)

    def _stopped(self, data: Answer) -> None:
        if self.on_stopped is not None:
            self.on_stopped(str(data.get("device", "")), str(data.get("message", "")))

    def _status(self, data: Answer) -> None:
        status = dict(data)
        device = str(status.pop("device", ""))
        self.status[device] = status
        self._hear(device, status)
        if self._on_status is not None:
            self._on_status(device, status)
