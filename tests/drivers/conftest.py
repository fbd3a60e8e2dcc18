"""A bench for the wire: real servers on loopback, real clients, one scripted device."""

import asyncio
import copy
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from labrun.drivers.client.client import DeviceClient
from labrun.drivers.find import find_driver
from labrun.drivers.server.serve import serving
from labrun.drivers.server.server import DeviceServer
from labrun.drivers.server.settings import ServerSettings
from labrun.schemas.messages import Goal

from .window_program.bench import gui, recorded, screen, seen_at

__all__ = ["gui", "recorded", "screen", "seen_at"]
HERE = Path(__file__).parent
SCRIPTED = f"{HERE / 'scripted.py'}:Scripted"


class Bench:
    """One folder with a server in it, and what its device really did."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._goals = 0

    def contract(self, **changes: Any) -> dict[str, Any]:
        import sys

        module = sys.modules[find_driver(SCRIPTED, HERE).__module__]
        return {**copy.deepcopy(module.CONTRACT), **changes}

    def settings(
        self, *, config: dict[str, Any] | None = None, contract: dict[str, Any] | None = None,
        limits: dict[str, Any] | None = None, **more: Any,
    ) -> dict[str, Any]:  # fmt: skip
        device = {
            "contract": self.contract(**(contract or {})),
            "driver": SCRIPTED,
            "config": config or {},
            "limits": limits or {},
        }
        folders = {"folder": str(self.folder / "server"), "world": str(self.folder / "world")}
        return {"devices": {"arm": device}, **folders, **more}

    @asynccontextmanager
    async def serving(self, **settings: Any) -> AsyncIterator[tuple[DeviceServer, str]]:
        model = ServerSettings.model_validate(self.settings(**settings))
        async with serving(model) as served:
            yield served

    @asynccontextmanager
    async def client(
        self, url: str, *, lease: bool = True, owner: str = "run-1", **options: Any
    ) -> AsyncIterator[DeviceClient]:
        client = DeviceClient(url, **options)
        await client.open()
        try:
            if lease:
                await client.take_lease("arm", owner)
            yield client
        finally:
            await client.close()

    @asynccontextmanager
    async def connected(self, **settings: Any) -> AsyncIterator[DeviceClient]:
        async with self.serving(**settings) as (_, url), self.client(url) as client:
            yield client

    @asynccontextmanager
    async def raw(self, url: str, token: str | None = None) -> AsyncIterator["Raw"]:
        """A bare Socket.IO client, for what a DeviceClient would never say."""
        raw = Raw()
        await raw.sio.connect(
            url,
            auth=None if token is None else {"token": token},
            transports=["websocket"],
            namespaces=["/action"],
        )
        try:
            yield raw
        finally:
            await raw.sio.disconnect()

    def goal(self, client: DeviceClient, action: str, **more: Any) -> Goal:
        self._goals += 1
        named = {"id", "boot", "epoch", "files"}
        fields = {name: more.pop(name) for name in named & more.keys()}
        held = "arm" in client._lease_keeper._leases
        known = {
            "id": f"run-1/main/{self._goals}/1",
            "boot": client.boot,
            "epoch": client.epoch("arm") if held else 0,
        }
        return Goal.model_validate(
            {**known, **fields, "device": "arm", "action": action, "params": more}
        )

    def tasks(self) -> list[str]:
        """What still runs beside the test; python-engineio's last ping sleeps out its 2 s alone."""
        others = asyncio.all_tasks() - {asyncio.current_task()}
        return [name for task in others if "_send_ping" not in (name := repr(task))]

    def deeds(self) -> list[str]:
        """What the device did since it was opened, in order."""
        path = self.folder / "world" / "deeds.txt"
        lines = path.read_text().splitlines() if path.exists() else []
        return [line for line in lines if not line.endswith(" open")]

    async def until(self, deed: str) -> None:
        async with asyncio.timeout(500):
            while f"arm {deed}" not in self.deeds():  # noqa: ASYNC110 - the deeds are a file
                await asyncio.sleep(0.01)


class Raw:
    """Events as they travel."""

    def __init__(self) -> None:
        import socketio

        self.sio = socketio.AsyncClient(reconnection=False, handle_sigint=False)
        self.events: list[tuple[str, dict[str, Any]]] = []
        for event in ("update", "status"):
            self.sio.on(event, self._note(event), namespace="/action")

    def _note(self, event: str) -> Any:
        return lambda data: self.events.append((event, data))

    async def call(self, event: str, **data: Any) -> dict[str, Any]:
        return await self.sio.call(event, data, namespace="/action", timeout=500)

    async def leased(self, **goal: Any) -> dict[str, Any]:
        """A complete goal payload under a lease taken now; what is given replaces its parts."""
        lease = await self.call("lease", device="arm", owner="raw", ttl_s=30.0)
        known = {"id": "g1", "device": "arm", "action": "go", "params": {"x": 1}}
        return {**known, "boot": lease["boot"], "epoch": lease["epoch"], **goal}

    async def update(self, goal_id: str, state: str) -> dict[str, Any]:
        """The first update that says so."""
        async with asyncio.timeout(500):
            while True:
                for event, data in self.events:
                    if event == "update" and (data["id"], data["state"]) == (goal_id, state):
                        return data
                await asyncio.sleep(0.01)

    async def status(self) -> dict[str, Any]:
        """The next status that arrives."""
        self.events.clear()
        async with asyncio.timeout(500):
            while True:
                for event, data in self.events:
                    if event == "status":
                        return data
                await asyncio.sleep(0.01)


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)
