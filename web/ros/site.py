"""Everything that a lab offers to ROS, put together and kept for as long as it is served."""

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ...engine.lab import LoadedLab
from ...engine.run_folder import FolderFault, FolderLock
from ...schemas.contract import Contract
from ..lab_here import lab_here
from .aliases import add_aliases
from .device import Device
from .device_action import DeviceAction
from .device_service import DeviceService
from .fault import RosFault
from .goals import Goals
from .names import topic_token
from .of_contract import ContractKinds, kinds_of
from .offer import Offers, Topic, Values
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
    statuses: dict[str, Values] = field(default_factory=dict)
    """Device -> what it said last, as its contract has it."""
    _heard: dict[str, list[Callable[[Values], None]]] = field(default_factory=dict)

    def actions_of(self, device: str) -> dict[str, DeviceAction]:
        """The actions of a device under its own names, not those of aliases."""
        first = f"/{self.tokens[device]}/"
        found = self.offers.actions.items()
        own = [a for name, a in found if isinstance(a, DeviceAction) and name.startswith(first)]
        return {action.action: action for action in own if action.device.name == device}

    def on_status(self, device: str, listener: Callable[[Values], None]) -> None:
        """Be told whenever a device says how it is."""
        self._heard.setdefault(device, []).append(listener)

    def told(self, device: str, status: Values) -> None:
        """A device has said how it is."""
        self.statuses[device] = status
        for listener in self._heard.get(device, ()):
            listener(status)

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
async def opened(
    lab: LoadedLab,
    package: str,
    folders: Folders,
    check: Callable[[Offers], None] = lambda offers: None,
) -> AsyncIterator[Site]:
    """The lab on offer for as long as the block lasts.

    `check` may raise before any device is reached. Raises RosFault, and OSError where a folder cannot
    be written.
    """
    for folder in (folders.files, folders.state):
        folder.mkdir(parents=True, exist_ok=True)
    lock = FolderLock(folders.state)
    try:
        lock.take()
    except FolderFault as fault:
        words = "another `labrun ros` serves from it; end it, or give this one a --state of its own"
        raise RosFault(f"{folders.state}: {words}") from fault
    try:
        async with _offered(lab, package, folders, check) as site:
            yield site
    finally:
        lock.release()


@asynccontextmanager
async def _offered(
    lab: LoadedLab, package: str, folders: Folders, check: Callable[[Offers], None]
) -> AsyncIterator[Site]:
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
    check(site.offers)
    try:
        await asyncio.gather(*(device.open() for device in site.devices.values()))
        yield site
    finally:
        await site.goals.close()
        await asyncio.gather(*(device.close() for device in site.devices.values()))


def _add_device(site: Site, name: str, kinds: ContractKinds) -> None:
    token = site.tokens[name]
    topic = Topic(f"/{token}/status", kinds.status)
    site.on_status(name, lambda status: topic.publish(to_ros(kinds.status, status)))
    device = Device(
        name, site.lab, site.folders.state / "servers", site.owner, lambda s: site.told(name, s)
    )
    site.devices[name] = device
    site.offers.topics[topic.name] = topic
    for action, kind in kinds.actions.items():
        full = f"/{token}/{topic_token(action)}"
        offered = DeviceAction(full, kind, device, action, site.folders.files)
        site.offers.actions[full] = offered
        if action in kinds.services:
            service = DeviceService(full, kinds.services[action], offered, site.goals)
            site.offers.services[full] = service
