"""Assemble a lab's offers, open its devices, and close them again."""

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from ...engine.lab.lab import LoadedLab
from ...engine.run.folder import FolderFault, FolderLock
from ...system.tasks import end, keep
from ..local.lab_here import lab_here
from .aliases.add import add_aliases
from .interfaces.fault import RosFault
from .interfaces.names import topic_token
from .interfaces.of_contract import ContractKinds
from .interfaces.own_kinds import run_protocol
from .interfaces.values import to_ros
from .offers.device import Device
from .offers.device_action import DeviceAction
from .offers.device_service import DeviceService
from .offers.goals import Goals
from .offers.offer import Offers, Topic
from .offers.offered_lab import Folders, OfferedLab, contract_kinds, tokens_of
from .offers.run_protocol import RunProtocol


@asynccontextmanager
async def opened(
    lab: LoadedLab,
    package: str,
    folders: Folders,
    check: Callable[[Offers], None] = lambda offers: None,
) -> AsyncIterator[OfferedLab]:
    """The offered lab, while the block runs.

    `check` may raise before any device is reached. Raises RosFault, and OSError if a folder cannot be
    written.
    """
    for folder in (folders.files, folders.state):
        folder.mkdir(parents=True, exist_ok=True)
    lock = FolderLock(folders.state)
    try:
        lock.take()
    except FolderFault as fault:
        words = "another `labrun ros` uses it; stop that one, or give this one a different --state"
        raise RosFault(f"{folders.state}: {words}") from fault
    try:
        async with _offered(lab, package, folders, check) as offered:
            yield offered
    finally:
        lock.release()


@asynccontextmanager
async def _offered(
    lab: LoadedLab, package: str, folders: Folders, check: Callable[[Offers], None]
) -> AsyncIterator[OfferedLab]:
    offered = OfferedLab(
        lab_here(lab, folders.state), package, f"ros-{secrets.token_hex(4)}", folders,
        Goals(lab.lab.start_timeout_s),
    )  # fmt: skip
    offered.tokens = tokens_of(offered.lab)
    kinds = contract_kinds(offered.lab, package)
    for name in offered.lab.lab.devices:
        _add_device(offered, name, kinds[offered.lab.lab.devices[name].contract])
    run = RunProtocol(
        run_protocol(package), folders.protocols, folders.runs, folders.state / "lab.yaml",
        folders.state, offered.free, f"ROS ({offered.owner})",
    )  # fmt: skip
    offered.offers.actions[run.name] = run
    paper = add_aliases(offered, lab)
    check(offered.offers)
    telling: asyncio.Task[None] | None = None
    try:
        await asyncio.gather(*(device.open() for device in offered.devices.values()))
        telling = keep("the paper's topics", paper.tell_often)
        yield offered
    finally:
        await end(telling)
        await offered.goals.close()
        await asyncio.gather(*(device.close() for device in offered.devices.values()))


def _add_device(offered: OfferedLab, name: str, kinds: ContractKinds) -> None:
    token = offered.tokens[name]
    topic = Topic(f"/{token}/status", kinds.status)
    offered.on_status(name, lambda status: topic.publish(to_ros(kinds.status, status)))
    device = Device(
        name,
        offered.lab,
        offered.folders.state / "servers",
        offered.owner,
        lambda s: offered.hear(name, s),
    )
    offered.devices[name] = device
    offered.offers.topics[topic.name] = topic
    for action, kind in kinds.actions.items():
        full = f"/{token}/{topic_token(action)}"
        made = DeviceAction(full, kind, device, action, offered.folders.files)
        offered.offers.actions[full] = made
        if action in kinds.services:
            service = DeviceService(full, kinds.services[action], made, offered.goals)
            offered.offers.services[full] = service
