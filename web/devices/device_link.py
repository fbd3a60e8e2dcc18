"""One device of the bench: its server started or found, its link kept, its current state."""

import asyncio
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...drivers.client.client import DeviceClient, ServerUnreachable
from ...drivers.client.launch import RunningServer, ServerFailed
from ...engine.lab.lab import LoadedLab
from ...schemas.contract import Contract
from ...schemas.lab import LabDevice
from ...system.tasks import end, in_time, keep
from ..local.clock import now_iso
from ..local.device_server import greet, serve_here
from ..local.refusal import Refusal
from ..models.devices import DeviceState, Reach

AGAIN_S = 2.0
SILENT_S = 4.0
"""A device server reports its status each second: after this long without one, it is lost."""


class DeviceLink:
    """Keeps the link to one device until it is closed; `changed` is called with its name."""

    def __init__(
        self, name: str, lab: LoadedLab, folder: Path, changed: Callable[[str], None]
    ) -> None:
        self.name = name
        self.device: LabDevice = lab.lab.devices[name]
        self.contract: Contract = lab.contracts[self.device.contract]
        self._is_camera = self.contract.look() is not None
        self.status: dict[str, Any] = {}
        self.client: DeviceClient | None = None
        self.goal: str | None = None
        self.result: dict[str, Any] = {}
        """From the last manual action: newer than any status for a moment."""
        self.busy = False
        """True during a manual action: one at a time."""
        self._leaving = False
        """Its action is over, and its lease is being released."""
        self._turn_over = asyncio.Event()
        self._status_at: str | None = None
        self._status_s = self._result_s = -math.inf
        self._lab = lab
        self._folder = folder
        self._changed = changed
        self._reach: Reach = "starting"
        self._reason = ""
        self._since = now_iso()
        self._up = False
        self._server: RunningServer | None = None
        self._now = asyncio.Event()
        self._keeping: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Start keeping the link."""
        self._keeping = keep(f"keep the link to {self.name}", self._keep)

    async def close(self, *, stop_server: bool) -> None:
        """Close the link; a server that was started here stops unless somebody else uses it."""
        await end(self._keeping)
        stop_server = stop_server and not await self._held()
        await self._drop()
        if stop_server and self._server is not None:
            await self._server.stop()

    async def _held(self) -> bool:
        """Whether a run that is not of this page has its lease: its server ends by itself, later."""
        if self.client is None or not self._up:
            return False
        try:
            return bool((await self.client.describe())[self.name].holder)
        except (ServerUnreachable, KeyError):
            return False

    def look_again(self) -> None:
        """Try to reach it at once, unless it is connected."""
        self._now.set()

    @property
    def server_pid(self) -> int | None:
        """Its server process, if it was started here."""
        return self._server.pid if self._server is not None else None

    @property
    def online(self) -> bool:
        """True if it answers."""
        return self.client is not None and self._up and self.reach == "online"

    @property
    def reach(self) -> Reach:
        """Its connection state; silent for too long counts as lost."""
        silent = self._reach == "online" and self.status_age_s > SILENT_S
        return "lost" if silent else self._reach

    @property
    def status_age_s(self) -> float:
        """How old its last status is; infinite if there is none yet."""
        return time.monotonic() - self._status_s

    @property
    def result_age_s(self) -> float:
        """How old the result of the last manual action is."""
        return time.monotonic() - self._result_s

    def check_turn(self) -> None:
        """Raise Refusal (409) during a manual action."""
        if self.busy and not self._leaving:
            raise Refusal(409, "BUSY", f"{self.name} is busy with another action by hand")

    async def until_free(self) -> None:
        """Wait for a lease that is being released; raises Refusal (409) during a manual action."""
        self.check_turn()
        while self.busy:
            await self._turn_over.wait()
            self.check_turn()

    async def take_turn(self) -> None:
        """Be `busy` until `end_turn`, after `until_free`."""
        await self.until_free()
        self.busy = True
        self._turn_over.clear()

    def leave_turn(self) -> None:
        """The action is over, as everybody is told; its lease is still to be released."""
        self.goal, self._leaving = None, True

    def end_turn(self) -> None:
        """The next may have its turn."""
        self.busy = self._leaving = False
        self._turn_over.set()

    def reachable_client(self) -> DeviceClient:
        """Its client; raises Refusal (503) if it cannot be reached."""
        if self.client is None or not self.online:
            state = self.state(None, None)
            raise Refusal(
                503, "LOST", f"{self.name} cannot be reached: {state.reason or state.reach}"
            )
        return self.client

    def take_result(self, result: dict[str, Any] | None) -> None:
        """Remember the result of the last manual action."""
        self.result, self._result_s = result or {}, time.monotonic()

    def state(self, used_by: str | None, armed: str | None) -> DeviceState:
        """As sent to the page."""
        reach, reason = self.reach, self._reason
        if reach == "lost" and not reason:
            reason = f"no status since {self._status_at}"
        return DeviceState(
            name=self.name, contract=self.contract.type, driver=self.device.driver,
            url=self.client.url if self.client is not None else self.device.url,
            reach=reach, word=self._word(reach, used_by), reason=reason,
            status=self.status, status_at=self._status_at,
            changed_at=self._since, used_by=used_by, goal=self.goal, armed=armed,
            camera=self._is_camera,
        )  # fmt: skip

    def _word(self, reach: Reach, used_by: str | None) -> str:
        if reach != "online":
            return reach
        if self.status.get("fault"):
            return "fault"
        if isinstance(self.status.get("state"), str):
            return self.status["state"]
        if self.status.get("armed") is True:
            return "ARMED"
        return "busy" if self.goal or used_by else "ready"

    async def _keep(self) -> None:
        while True:
            try:
                await self._connect()
                await self._until_gone()
            except (ServerUnreachable, ServerFailed, OSError) as fault:
                self._set("lost" if self._status_at else "failed", str(fault))
            except Exception as fault:  # ours: the page shows it, the log has its traceback
                self._set("failed", f"an internal error: {type(fault).__name__}: {fault}")
                raise
            finally:
                await self._drop()
            await in_time(self._now.wait(), AGAIN_S)
            self._now.clear()

    async def _connect(self) -> None:
        url = self.device.url
        if url is None:
            url, self._server = await serve_here(self.name, self._lab, self._folder)
        client = DeviceClient(
            url, self.device.token, on_status=self._on_status, on_link=self._on_link
        )
        described = await greet(
            client, url, self.name, self.contract.type, self._lab.lab.start_timeout_s
        )
        self.client = client
        self._on_status(self.name, described.devices[self.name].status)
        self._set("online", "")

    async def _until_gone(self) -> None:
        """Wait for the end of our own server; another's loss shows on the link, which reconnects."""
        if self._server is None:
            await asyncio.get_running_loop().create_future()
        else:
            await self._server.ended()
            self._server = None
            raise OSError(f"the server of {self.name} ended; restarting it")

    async def _drop(self) -> None:
        client, self.client, self._up = self.client, None, False
        if client is not None:
            await client.close()

    def _on_status(self, device: str, status: dict[str, Any]) -> None:
        if device == self.name:
            self.status, self._status_at, self._status_s = status, now_iso(), time.monotonic()
            self._changed(self.name)

    def _on_link(self, up: bool) -> None:
        self._up = up
        self._set("online" if up else "lost", "" if up else "the connection to its server broke")

    def _set(self, reach: Reach, reason: str) -> None:
        if reach != self._reach:
            self._since = now_iso()
        self._reach, self._reason = reach, reason
        self._changed(self.name)
