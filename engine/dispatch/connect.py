"""Reach every device that a run uses: start the servers that belong to it, connect, take leases."""

import asyncio
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...drivers.client.client import DeviceClient, LeaseHeld, ServerUnreachable
from ...drivers.client.launch import RunningServer, ServerFailed, keep_running, start_patiently
from ...schemas.lab import LabDevice
from ...system.tasks import end, in_time, spawn
from ..lab.bind import BoundRole
from ..lab.lab import LoadedLab
from .served_lab import named_at, served_at, started_by

IDLE_EXIT_S = 90.0
"""Servers that a run started end when its engine has been gone for this long."""


LOOK_S = 2.0
"""How often a run that waits for a device looks whether it is free."""
START_LOOK_S = 0.1


class NotReached(Exception):
    """A device or its server could not be reached; the text names device, address and reason."""


class Held(NotReached):
    """A device that another client holds."""

    def __init__(self, device: str, holder: str, text: str) -> None:
        super().__init__(text)
        self.device, self.holder = device, holder


@dataclass(slots=True)
class Connections:
    """The clients by device, and the servers that this run started or found again."""

    folder: Path
    clients: dict[str, DeviceClient] = field(default_factory=dict)
    started: dict[str, RunningServer] = field(default_factory=dict)
    leased: list[str] = field(default_factory=list)
    marks: Mapping[str, str] = field(default_factory=dict)
    found: Mapping[str, str] = field(default_factory=dict)
    keeping: list[asyncio.Task[None]] = field(default_factory=list)
    say: Callable[[str], None] = lambda text: None

    async def close(self) -> None:
        """Give the leases back, disconnect, and end the servers that belong to the run."""
        await end(*self.keeping)
        await asyncio.gather(*(self.clients[device].release(device) for device in self.leased))
        await asyncio.gather(*(c.close() for c in set(self.clients.values())))
        await asyncio.gather(*(server.stop() for server in self.started.values()))


def servers_folder(run_folder: Path) -> Path:
    """Where the run's own servers keep ledgers, logs and the simulated world."""
    return run_folder / "servers"


async def connect(
    roles: dict[str, BoundRole], lab: LoadedLab, run_folder: Path, owner: str,
    marks: Mapping[str, str] | None = None, say: Callable[[str], None] = lambda text: None,
    wait_s: float = 0.0, found: Mapping[str, str] | None = None,
) -> Connections:  # fmt: skip
    """Clients for every device that plays a role, leases taken; raises NotReached.

    `wait_s`: how long devices that others hold are waited for.
    `found`: the addresses of devices that another command serves now.
    `marks`: what the run has seen of each device's ledger, for the server to say whether it has it.
    `say` hears what is waited for, and later which server has died.
    """
    connections = Connections(
        servers_folder(run_folder), marks=marks or {}, say=say, found=found or {}
    )
    devices = sorted({role.device for role in roles.values()})
    try:
        reached = await asyncio.gather(
            *(_reach(name, lab, connections) for name in devices), return_exceptions=True
        )
        for fault in reached:
            if isinstance(fault, BaseException):
                raise fault
        for role in roles.values():
            _check_contract(role, connections.clients[role.device])
        await _lease_all(devices, connections, owner, wait_s)
    except BaseException:  # a cancel as well
        await connections.close()
        raise
    return connections


async def _reach(name: str, lab: LoadedLab, connections: Connections) -> None:
    device = lab.lab.devices[name]
    await in_time(_while_starting(name, lab, connections), lab.lab.start_timeout_s)
    if (url := named_at(device)) is not None:
        await _open(name, url, device.token, lab, connections)
    elif (connections.folder / name).exists():
        # What a run's own server has done lies in its own ledger, and is asked there.
        await _start(name, device, lab, connections)
    elif (url := served_at(lab, name)) is not None:
        connections.say(f"{name} is served at {url} by another command")
        await _open(name, url, device.token, lab, connections)
    elif (url := connections.found.get(name)) is not None:
        await _open(name, url, device.token, lab, connections)
    else:
        try:
            await _start(name, device, lab, connections)
        except NotReached:
            if (url := served_at(lab, name)) is None:
                raise
            await _open(name, url, device.token, lab, connections)  # it came in between


async def _while_starting(name: str, lab: LoadedLab, connections: Connections) -> None:
    """Wait until a `labrun serve` that is starting a device serves it: its instrument has one server."""
    told = False
    while (process := started_by(lab, name)) is not None:
        if named_at(lab.lab.devices[name]) or served_at(lab, name):
            return
        if not told:
            connections.say(f"waiting for `labrun serve` (process {process}), which starts {name}")
            told = True
        await asyncio.sleep(START_LOOK_S)


async def _open(
    name: str, url: str, token: str | None, lab: LoadedLab, connections: Connections
) -> None:
    client = DeviceClient(url, token, mark=connections.marks.get(name, ""))
    try:
        await client.open(lab.lab.start_timeout_s)
    except ServerUnreachable as fault:
        await client.close()
        raise NotReached(f"device {name!r} at {url}: {fault}") from fault
    if name not in client.devices:
        await client.close()
        served = ", ".join(client.devices) or "nothing"
        raise NotReached(f"the server at {url} does not serve {name!r}; it serves {served}")
    connections.clients[name] = client


async def _start(name: str, device: LabDevice, lab: LoadedLab, connections: Connections) -> None:
    config = server_config({name: device}, lab, connections.folder)
    config["port"] = device.port or 0
    config["idle_exit_s"] = IDLE_EXIT_S
    config["owner_pid"] = os.getpid()
    folder, timeout_s = connections.folder / name, lab.lab.start_timeout_s
    try:
        server = await start_patiently(
            config, folder, timeout_s=timeout_s, say=lambda text: connections.say(text)
        )
    except ServerFailed as fault:
        raise NotReached(f"device {name!r} ({device.driver}): {fault}") from fault
    connections.started[name] = server
    await _open(name, server.url, None, lab, connections)
    keeping = keep_running(server, config, folder, timeout_s=timeout_s)
    connections.keeping.append(spawn(f"keep the server of {name}", keeping))


def server_config(devices: dict[str, LabDevice], lab: LoadedLab, folder: Path) -> dict[str, Any]:
    """The configuration of a server process: its devices with their contracts, and its folders."""
    first = next(iter(devices))
    return {
        "devices": {
            name: {
                "contract": lab.contracts[device.contract].model_dump(mode="json"),
                "driver": device.driver,
                "config": device.config,
                "limits": {k: v.model_dump(mode="json") for k, v in device.limits.items()},
            }
            for name, device in devices.items()
        },
        "folder": str(folder / (first if len(devices) == 1 else "served")),
        "world": str(folder / "world"),
        "base": base_of(lab),
        "host": "127.0.0.1",
        "python": python_of(devices[first], lab),
        "own_token": True,
        "stop_grace_s": lab.lab.stop_grace_s,
    }


def base_of(lab: LoadedLab) -> str:
    """The folder that paths in a lab start from."""
    return str(lab.path.parent.resolve()) if lab.path is not None else "."


def python_of(device: LabDevice, lab: LoadedLab) -> str | None:
    """The interpreter of a device's server, if the lab names one; its path is relative to the lab's.

    A link stays a link: it is by its own place that an interpreter finds its environment.
    """
    if device.python is None or lab.path is None or Path(device.python).name == device.python:
        return device.python
    return str((lab.path.parent / Path(device.python).expanduser()).absolute())


def _check_contract(role: BoundRole, client: DeviceClient) -> None:
    contract = client.devices[role.device].contract
    served = contract.get("type")
    if role.contract.type not in (served, *contract.get("also", ())):
        raise NotReached(
            f"device {role.device!r} at {client.url} keeps {served}, "
            f"but the protocol needs {role.contract.type} for {role.role!r}"
        )


async def _lease_all(
    devices: list[str], connections: Connections, owner: str, wait_s: float
) -> None:
    """All leases or none: whoever waits for one device keeps no other from anybody."""
    loop, told = asyncio.get_running_loop(), ""
    until = loop.time() + wait_s
    while True:
        try:
            for device in devices:
                await _lease(device, connections, owner)
            return
        except Held as held:
            if loop.time() >= until:
                raise
            taken, connections.leased = connections.leased, []
            await asyncio.gather(*(connections.clients[name].release(name) for name in taken))
            who = f"waiting for {held.device}, which {held.holder} holds"
            if who != told:
                connections.say(f"{who}; Ctrl-C ends the wait")
                told = who
        await asyncio.sleep(min(LOOK_S, max(0.0, until - loop.time())))


async def _lease(device: str, connections: Connections, owner: str) -> None:
    client = connections.clients[device]
    try:
        await client.take_lease(device, owner)
    except LeaseHeld as fault:
        raise Held(
            device, fault.holder,
            f"device {device!r} at {client.url} is held by {fault.holder}; "
            "`labrun run --wait` waits until it is free, `labrun abort` ends a run, and "
            f"`labrun stop {device}` stops the device at once",
        ) from fault  # fmt: skip
    except ServerUnreachable as fault:
        raise NotReached(f"device {device!r} at {client.url}: {fault.reason}") from fault
    connections.leased.append(device)
