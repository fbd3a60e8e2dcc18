"""Everything that a lab offers to ROS, put together and kept for as long as it is served."""

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...engine.lab import LoadedLab
from ...schemas.contract import Contract
from .aliases import add_aliases
from .device import Device
from .device_action import DeviceAction
from .device_service import DeviceService
from .goals import Goals
from .kinds import Message
from .lab_here import lab_here
from .names import topic_token
from .of_contract import ContractKinds, kinds_of
from .offer import Offers, Topic
from .own_kinds import run_protocol
from .run_protocol import RunProtocol
from .values import to_ros


@dataclass(frozen=True, slots=True)
class Folders:
    """Where protocols, runs, files of actions and our own state lie."""

    protocols: Path
    runs: Path
    files: Path
    state: Path


@dataclass(slots=True)
class Site:
    """The lab on offer."""

    lab: LoadedLab
    package: str
    owner: str
    folders: Folders
    goals: Goals = field(default_factory=Goals)
    offers: Offers = field(default_factory=Offers)
    devices: dict[str, Device] = field(default_factory=dict)
    tokens: dict[str, str] = field(default_factory=dict)
    """Device -> the name that it has in topics."""

    async def free(self) -> None:
        """Give back the leases that nobody uses at the moment."""
        await asyncio.gather(*(device.free() for device in self.devices.values()))


def tokens_of(lab: LoadedLab) -> dict[str, str]:
    """Device -> the name that it has in topics; valid in ROS, and each its own."""
    found: dict[str, str] = {}
    for name in lab.lab.devices:
        found[name] = topic_token(name, [*found.values(), "labrun", "rosapi"])
    return found


def contract_kinds(lab: LoadedLab, package: str) -> dict[str, ContractKinds]:
    """Contract -> its interfaces, for those that the lab's devices keep."""
    used = sorted({device.contract for device in lab.lab.devices.values()})
    return {name: kinds_of(_contract(lab, name), package) for name in used}


def _contract(lab: LoadedLab, name: str) -> Contract:
    return lab.contracts[name]


@asynccontextmanager
async def opened(lab: LoadedLab, package: str, folders: Folders) -> AsyncIterator[Site]:
    """The lab on offer for as long as the block lasts; raises OSError where a folder cannot be written."""
    folders.files.mkdir(parents=True, exist_ok=True)
    site = Site(lab_here(lab, folders.state), package, f"ros-{secrets.token_hex(4)}", folders)
    site.tokens = tokens_of(site.lab)
    kinds = contract_kinds(site.lab, package)
    for name in site.lab.lab.devices:
        _add_device(site, name, kinds[site.lab.lab.devices[name].contract])
    run = RunProtocol(
        run_protocol(package), folders.protocols, folders.runs, folders.state / "lab.yaml",
        folders.state, site.free, f"ROS ({site.owner})",
    )  # fmt: skip
    site.offers.actions[run.name] = run
    add_aliases(site, lab)
    try:
        await asyncio.gather(*(device.open() for device in site.devices.values()))
        yield site
    finally:
        await site.goals.close()
        await asyncio.gather(*(device.close() for device in site.devices.values()))


def _add_device(site: Site, name: str, kinds: ContractKinds) -> None:
    token = site.tokens[name]
    topic = Topic(f"/{token}/status", kinds.status)
    device = Device(name, site.lab, site.folders.state / "servers", site.owner, _publisher(topic))
    site.devices[name] = device
    site.offers.topics[topic.name] = topic
    for action, kind in kinds.actions.items():
        full = f"/{token}/{topic_token(action)}"
        offered = DeviceAction(full, kind, device, action, site.folders.files)
        site.offers.actions[full] = offered
        if action in kinds.services:
            service = DeviceService(full, kinds.services[action], offered, site.goals)
            site.offers.services[full] = service


def _publisher(topic: Topic) -> Callable[[dict[str, Any]], None]:
    kind: Message = topic.kind
    return lambda status: topic.publish(to_ros(kind, status))
