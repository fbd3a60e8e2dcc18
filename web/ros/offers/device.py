"""One device: its server started here or found elsewhere, its link, its lease while in use."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from ....drivers.client.client import DeviceClient, LeaseHeld, ServerUnreachable
from ....drivers.client.launch import RunningServer, ServerFailed
from ....engine.lab.lab import LoadedLab
from ....schemas.contract import Contract
from ....schemas.lab import LabDevice, RosNames
from ....schemas.quantity import seconds
from ....system.tasks import end, keep, spawn
from ...local.device_server import greet, serve_here
from .offer import Refused

AGAIN_S = 1.0
TTL_S = 10.0
HOLD_S = 1.0
"""How long a lease is kept for the next goal; after that others may use the device."""
LEFT_S = 60.0

Status = dict[str, Any]


class Device:
    """Keeps the link to one device until it is closed."""

    def __init__(
        self,
        name: str,
        lab: LoadedLab,
        folder: Path,
        owner: str,
        on_status: Callable[[Status], None],
    ) -> None:
        self.name = name
        self.owner = owner
        self.device: LabDevice = lab.lab.devices[name]
        self.contract: Contract = lab.contracts[self.device.contract]
        self.lost = asyncio.Event()
        """Set while the server has ended, or has been out of reach for the lab's `start_timeout`."""
        self.action_timeout_s = seconds((lab.lab.ros or RosNames()).action_timeout)
        self._lab = lab
        self._folder = folder
        self._status = on_status
        self._client: DeviceClient | None = None
        self._up = False
        self._reason = "still connecting"
        self._server: RunningServer | None = None
        self._users = 0
        self._leased = False
        self._turn = asyncio.Lock()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._losing: asyncio.TimerHandle | None = None

    async def open(self) -> None:
        """Connect, and keep trying; a device that cannot be reached now is offered nevertheless."""
        with contextlib.suppress(ServerUnreachable, ServerFailed, OSError):
            await self._connect()
        self._tasks.add(keep(f"the link to {self.name}", self._keep))

    async def close(self) -> None:
        """Close the link; a server started here stops, its device in the safe state."""
        await end(*self._tasks)
        if self._losing is not None:
            self._losing.cancel()
        await self._release()
        await self._drop()
        if self._server is not None:
            await self._server.stop()

    @property
    def online(self) -> bool:
        """True if its server answers."""
        return self._client is not None and self._up

    @property
    def reason(self) -> str:
        """Why it is not online."""
        return self._reason

    @asynccontextmanager
    async def borrowed(self) -> AsyncIterator[DeviceClient]:
        """The device's client, holding its lease during the block; raises Refused."""
        self._users += 1
        try:
            async with self._turn:
                client = await self._lease()
            yield client
        finally:
            self._users -= 1
            if self._users == 0 and self._leased:
                asyncio.get_running_loop().call_later(HOLD_S, self._release_soon)

    async def free(self) -> None:
        """Release an unused lease at once: a run is about to need it."""
        async with self._turn:
            if self._users == 0:
                await self._release()

    def bring_to_end(self, goal_id: str, following: "asyncio.Task[Any]") -> None:
        """Cancel a goal that nobody waits for any more, as soon as its server answers."""
        spawn(f"the end of {goal_id}", self._ended(goal_id, following), among=self._tasks)

    async def _lease(self) -> DeviceClient:
        client = self._client
        if client is None or not self._up:
            raise Refused(f"{self.name} cannot be reached: {self._reason}")
        if self._leased:
            return client
        try:
            await client.take_lease(self.name, self.owner, TTL_S)
        except LeaseHeld as fault:
            raise Refused(
                f"{self.name} is held by {fault.holder}; wait until that has ended"
            ) from fault
        except (ServerUnreachable, OSError) as fault:
            raise Refused(f"{self.name} cannot be reached: {fault}") from fault
        self._leased = True
        return client

    def _release_soon(self) -> None:
        if self._users == 0 and self._leased:
            spawn(f"releasing {self.name}", self.free(), among=self._tasks)

    async def _release(self) -> None:
        if self._leased and self._client is not None:
            self._leased = False
            with contextlib.suppress(ServerUnreachable, LeaseHeld, OSError, TimeoutError):
                await self._client.release(self.name)

    async def _keep(self) -> None:
        while True:
            try:
                if self._client is None:
                    await self._connect()
                if (
                    self._server is None
                ):  # another's server shows only on the link, which reconnects
                    await asyncio.get_running_loop().create_future()
                else:
                    await self._server.ended()
                    self._reason = f"the server of {self.name} ended; restarting it"
                    self.lost.set()
                    self._server = None
                    await self._serve()
            except (ServerUnreachable, ServerFailed, OSError) as fault:
                self._reason = str(fault)
            await asyncio.sleep(AGAIN_S)

    async def _connect(self) -> None:
        try:
            url = self.device.url or await self._serve()
            client = DeviceClient(
                url, self.device.token, on_status=self._on_status, on_link=self._on_link
            )
            described = await greet(
                client, url, self.name, self.contract.type, self._lab.lab.start_timeout_s
            )
        except (ServerUnreachable, ServerFailed, OSError) as fault:
            self._reason = str(fault)
            raise
        self._client, self._up = client, True
        self._on_status(self.name, described.devices[self.name].status)

    async def _serve(self) -> str:
        url, self._server = await serve_here(self.name, self._lab, self._folder)
        return url

    async def _drop(self) -> None:
        client, self._client, self._up = self._client, None, False
        if client is not None:
            await client.close()

    async def _ended(self, goal_id: str, following: "asyncio.Task[Any]") -> None:
        client = self._client
        try:
            async with asyncio.timeout(LEFT_S):
                while not following.done() and client is not None:
                    with contextlib.suppress(ServerUnreachable):
                        await client.cancel(goal_id)
                        break
                    await asyncio.wait({following}, timeout=AGAIN_S)
                await asyncio.wait({following})
        except TimeoutError:
            pass  # its server did not return; there the lease expires and the device is made safe
        finally:
            await end(following)

    def _on_status(self, device: str, status: Status) -> None:
        if device == self.name:
            self._status(status)

    def _on_link(self, up: bool) -> None:
        self._up = up
        if self._losing is not None:
            self._losing.cancel()
            self._losing = None
        if up:
            self.lost.clear()
        else:
            self._reason = "the connection to its server broke"
            patience_s = self._lab.lab.start_timeout_s  # a server that is only slow loses no goal
            self._losing = asyncio.get_running_loop().call_later(patience_s, self.lost.set)
