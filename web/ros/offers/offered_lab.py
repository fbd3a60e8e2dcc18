"""Everything that a lab offers to ROS, assembled and kept while it is served."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from ....engine.lab.lab import LoadedLab
from ....schemas.contract import Contract
from ..interfaces.names import topic_token
from ..interfaces.of_contract import ContractKinds, kinds_of
from .device import Device
from .device_action import DeviceAction
from .goals import Goals
from .offer import Offers, Values


@dataclass(frozen=True, slots=True)
class Folders:
    """The folders of protocols, runs, action files and our own state."""

    protocols: Path
    runs: Path
    files: Path
    state: Path


@dataclass(slots=True)
class OfferedLab:
    """The offered lab."""

    lab: LoadedLab
    package: str
    owner: str
    folders: Folders
    goals: Goals = field(default_factory=Goals)
    offers: Offers = field(default_factory=Offers)
    devices: dict[str, Device] = field(default_factory=dict)
    tokens: dict[str, str] = field(default_factory=dict)
    """Device -> its name in topics."""
    statuses: dict[str, Values] = field(default_factory=dict)
    """Device -> its last status, as in its contract."""
    _heard: dict[str, list[Callable[[Values], None]]] = field(default_factory=dict)

    def actions_of(self, device: str) -> dict[str, DeviceAction]:
        """The actions of a device under its own names, not those of aliases."""
        first = f"/{self.tokens[device]}/"
        found = self.offers.actions.items()
        own = [a for name, a in found if isinstance(a, DeviceAction) and name.startswith(first)]
        return {action.action: action for action in own if action.device.name == device}

    def on_status(self, device: str, listener: Callable[[Values], None]) -> Callable[[], None]:
        """Call `listener` whenever a device reports its status; what is returned ends that."""
        listeners = self._heard.setdefault(device, [])
        listeners.append(listener)
        return lambda: listeners.remove(listener)

    def hear(self, device: str, status: Values) -> None:
        """A device has reported its status."""
        self.statuses[device] = status
        for listener in [*self._heard.get(device, ())]:
            listener(status)

    async def free(self) -> None:
        """Release the leases that are not in use."""
        await asyncio.gather(*(device.free() for device in self.devices.values()))


def tokens_of(lab: LoadedLab) -> dict[str, str]:
    """Device -> its name in topics; valid in ROS, and unique."""
    found: dict[str, str] = {}
    for name in lab.lab.devices:
        found[name] = topic_token(name, [*found.values(), "labrun", "rosapi"])
    return found


def contract_kinds(lab: LoadedLab, package: str) -> dict[str, ContractKinds]:
    """Contract -> its interfaces, for the contracts of the lab's devices."""
    used = sorted({device.contract for device in lab.lab.devices.values()})
    return {name: kinds_of(_contract(lab, name), package) for name in used}


def _contract(lab: LoadedLab, name: str) -> Contract:
    return lab.contracts[name]
