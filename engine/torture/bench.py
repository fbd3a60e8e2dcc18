"""A lab for torture: device servers that belong to no run, each behind a bad wire."""

import asyncio
import os
import signal
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...drivers.client.launch import RunningServer, start_server
from ...drivers.simulated.twins.bad_network import FaultyWire, WireFaults
from ...system.tasks import end, spawn
from ..dispatch.connect import server_config
from ..lab.lab import LoadedLab
from .lab_file import config, write_lab

LOOK_S = 0.1


@dataclass(slots=True)
class Bench:
    """Servers as another machine would serve them; `lab_file` leads to them over the bad wires."""

    lab: LoadedLab
    devices: list[str]
    folder: Path
    faults: WireFaults
    servers: dict[str, RunningServer] = field(default_factory=dict)
    wires: dict[str, FaultyWire] = field(default_factory=dict)
    _keepers: list[asyncio.Task[None]] = field(default_factory=list)
    _starting: set[str] = field(default_factory=set)

    @property
    def lab_file(self) -> Path:
        """The lab file that a run uses."""
        return self.folder / "lab.yaml"

    async def open(self) -> None:
        """Start every server and its wire, and write the lab file."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for name in self.devices:
            settings = self._settings(name)
            self.servers[name] = await start_server(settings, self.folder / name)
            self.wires[name] = FaultyWire(self.servers[name].url, self.faults)
            await self.wires[name].open()
            self._keepers.append(spawn(f"keep the server of {name}", self._keep(name, settings)))
        urls = {name: wire.url for name, wire in self.wires.items()}
        write_lab(self.lab, self.devices, self.lab_file, urls)

    async def close(self) -> None:
        """End wires and servers."""
        await end(*self._keepers)
        await asyncio.gather(*(wire.close() for wire in self.wires.values()))
        await asyncio.gather(*(server.stop() for server in self.servers.values()))

    async def back(self) -> None:
        """Wait until the servers that have ended are there again."""
        while self._starting:  # noqa: ASYNC110 - as long as that takes, on a busy machine
            await asyncio.sleep(LOOK_S)

    def kill(self, names: list[str], by: signal.Signals = signal.SIGKILL) -> None:
        """Send these servers a signal; one that ends is restarted at its address, as a service would be."""
        for name in names:
            try:
                os.kill(self.servers[name].pid, by)
            except ProcessLookupError:
                continue  # it is being restarted

    def _settings(self, name: str) -> dict[str, Any]:
        device = self.lab.lab.devices[name]
        slowed = device.model_copy(update={"config": config(self.lab, name)})
        settings = server_config({name: slowed}, self.lab, self.folder)
        return {**settings, "own_token": False, "owner_pid": os.getpid(), "idle_exit_s": 90.0}

    async def _keep(self, name: str, settings: dict[str, Any]) -> None:
        port = int(self.servers[name].url.rpartition(":")[2])
        while True:
            await self.servers[name].ended()
            self._starting.add(name)
            try:
                server = await start_server({**settings, "port": port}, self.folder / name)
            finally:
                self._starting.discard(name)
            self.servers[name] = server
