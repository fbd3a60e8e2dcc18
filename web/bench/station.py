"""One device of the bench: its server started or found, its link kept, its state as of now."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...drivers.client import DeviceClient, ServerUnreachable
from ...drivers.launch import RunningServer, ServerFailed
from ...engine.lab import LoadedLab
from ...schemas.contract import Contract
from ...schemas.lab import LabDevice
from ..clock import iso, now_iso
from ..device_server import greet, serve_here
from ..guard.refusal import Refusal
from ..models.devices import DeviceState, Reach

AGAIN_S = 2.0
SILENT_S = 4.0
"""A device server tells its status each second: after this without one, it is lost."""


class Station:
    """Keeps the link to one device until it is closed; `changed` is called with its name."""

    def __init__(
        self, name: str, lab: LoadedLab, folder: Path, changed: Callable[[str], None]
    ) -> None:
        self.name = name
        self.device: LabDevice = lab.lab.devices[name]
        self.contract: Contract = lab.contracts[self.device.contract]
        self.status: dict[str, Any] = {}
        self.status_at = 0.0
        self.client: DeviceClient | None = None
        self.goal: str | None = None
        self.result: dict[str, Any] = {}
        """Of the last action by hand: newer than any status for a moment."""
        self.result_at = 0.0
        self.turn = asyncio.Lock()
        """Whoever does something by hand has it: one action at a time."""
        self._lab = lab
        self._folder = folder
        self._changed = changed
        self._reach: Reach = "starting"
        self._reason = ""
        self._since = now_iso()
        self._up = False
        self._server: RunningServer | None = None
        self._now = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Begin to keep the link."""
        self._task = asyncio.create_task(self._keep())

    async def close(self, *, stop_server: bool) -> None:
        """Let go; a server that was started here ends where nobody else uses it."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self._drop()
        if stop_server and self._server is not None:
            await self._server.stop()

    def look_again(self) -> None:
        """Try to reach it at once, where it is not reached."""
        self._now.set()

    @property
    def server_pid(self) -> int | None:
        """The process that serves it, where it was started here."""
        return self._server.pid if self._server is not None else None

    @property
    def online(self) -> bool:
        """True where it answers."""
        return self.client is not None and self._up and self.reach == "online"

    @property
    def reach(self) -> Reach:
        """How it is reached; silent for too long counts as lost."""
        silent = self.status_at and time.time() - self.status_at > SILENT_S
        return "lost" if self._reach == "online" and silent else self._reach

    def reached(self) -> DeviceClient:
        """Its client; raises Refusal (503) where it cannot be reached."""
        if self.client is None or not self.online:
            state = self.state(None, None)
            raise Refusal(
                503, "LOST", f"{self.name} cannot be reached: {state.reason or state.reach}"
            )
        return self.client

    def take_result(self, result: dict[str, Any] | None) -> None:
        """Remember what the last action by hand gave."""
        self.result, self.result_at = result or {}, time.time()

    def state(self, used_by: str | None, armed: str | None) -> DeviceState:
        """As the page is told."""
        reach, reason = self.reach, self._reason
        if reach == "lost" and not reason:
            reason = f"nothing was heard of it since {iso(self.status_at)}"
        return DeviceState(
            name=self.name, contract=self.contract.type, driver=self.device.driver,
            url=self.client.url if self.client is not None else self.device.url,
            reach=reach, word=self._word(reach, used_by), reason=reason,
            status=self.status, status_at=iso(self.status_at) if self.status_at else None,
            age_s=round(time.time() - self.status_at, 2) if self.status_at else None,
            changed_at=self._since, used_by=used_by, goal=self.goal, armed=armed,
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
                self._set("lost" if self.status_at else "failed", str(fault))
            finally:
                await self._drop()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(AGAIN_S):
                    await self._now.wait()
            self._now.clear()

    async def _connect(self) -> None:
        url = self.device.url
        if url is None:
            url, self._server = await serve_here(self.name, self._lab, self._folder)
        client = DeviceClient(
            url, self.device.token, on_status=self._on_status, on_link=self._on_link
        )
        described = await greet(client, url, self.name, self.contract.type)
        self.client = client
        self._on_status(self.name, described.devices[self.name].status)
        self._set("online", "")

    async def _until_gone(self) -> None:
        """Wait for the end of our server; of somebody else's only the link tells, which comes back."""
        if self._server is None:
            await asyncio.get_running_loop().create_future()
        else:
            await self._server.ended()
            self._server = None
            raise OSError(f"the server of {self.name} ended; it is started again")

    async def _drop(self) -> None:
        client, self.client, self._up = self.client, None, False
        if client is not None:
            await client.close()

    def _on_status(self, device: str, status: dict[str, Any]) -> None:
        if device == self.name:
            self.status, self.status_at = status, time.time()
            self._changed(self.name)

    def _on_link(self, up: bool) -> None:
        self._up = up
        self._set("online" if up else "lost", "" if up else "the connection to its server broke")

    def _set(self, reach: Reach, reason: str) -> None:
        if reach != self._reach:
            self._since = now_iso()
        self._reach, self._reason = reach, reason
        self._changed(self.name)
