"""Injected faults: an action that fails, a device that is not well, a server that dies or falls silent."""

import os
import signal
from pathlib import Path
from typing import Any

from ...system import WINDOWS
from ..devices.device_link import DeviceLink
from ..devices.devices import DeviceLinks
from ..local.refusal import Refusal
from ..models.demo import DeviceFaults, FaultKind, OrderedFault, OrderFault
from .demo import TWINS
from .orders import clear, order, ordered

SIGNALS = {"kill": "SIGKILL", "freeze": "SIGSTOP", "thaw": "SIGCONT"}
LASTING = {
    "interlock": "the enclosure of {} is open",
    "stop": "{} does not confirm a stop",
    "slow": "{} is 20 times as slow as usual",
}
FROZEN = "the server of {} is silent"


class Trouble:
    """Injects faults into the demonstration's bench; `world` is what its twins share."""

    def __init__(self, device_links: DeviceLinks, world: Path) -> None:
        self._device_links = device_links
        self._world = world
        self._frozen: set[int] = set()

    def of(self, device: str) -> DeviceFaults:
        """What can be requested of a device, and what was."""
        device_link = self._device_links.device_link(device)
        actions = device_link.contract.actions
        errors = {name: list(action.errors) for name, action in actions.items() if action.errors}
        told = [_told(device_link.name, one) for one in ordered(self._world, device_link.name)]
        if device_link.server_pid in self._frozen:
            told.append(OrderedFault(kind="freeze", text=FROZEN.format(device_link.name)))
        return DeviceFaults(kinds=_kinds(device_link), errors=errors, ordered=told)

    async def order(self, asked: OrderFault) -> str:
        """Inject the fault; returns a sentence."""
        device_link = self._device_links.device_link(asked.device)
        name = device_link.name
        if asked.kind == "clear":
            clear(self._world, name)
            if device_link.server_pid in self._frozen:
                self._signal(device_link, "thaw")
            return f"no more faults are injected into {name}"
        if asked.kind in SIGNALS:
            return self._signal(device_link, asked.kind)
        if asked.kind in LASTING:
            if asked.kind not in _kinds(device_link):
                raise Refusal(422, "PARAMS", f"{name} has nothing to which this can happen")
            order(self._world, name, asked.kind)
            return LASTING[asked.kind].format(name)
        if asked.action is None or asked.action not in device_link.contract.actions:
            known = ", ".join(device_link.contract.actions)
            raise Refusal(422, "PARAMS", f"{name} has no action {asked.action!r}: {known}")
        errors = device_link.contract.actions[asked.action].errors
        if not errors or (asked.error is not None and asked.error not in errors):
            known = ", ".join(errors) or "none"
            raise Refusal(422, "PARAMS", f"errors of {name}.{asked.action}: {known}")
        order(self._world, name, "error", asked.action, asked.error, asked.count)
        return f"the next {asked.count} of {name}.{asked.action} will fail"

    def _signal(self, device_link: DeviceLink, kind: str) -> str:
        pid = device_link.server_pid
        if pid is None or WINDOWS:
            raise Refusal(409, "NO_SERVER", f"{device_link.name} has no server here to {kind}")
        try:
            os.kill(pid, getattr(signal, SIGNALS[kind]))
        except ProcessLookupError:
            raise Refusal(409, "NO_SERVER", f"the server of {device_link.name} is gone") from None
        self._frozen.discard(pid)
        if kind == "freeze":
            self._frozen.add(pid)
        return f"{kind}: the server of {device_link.name} (process {pid})"


def _kinds(device_link: DeviceLink) -> list[FaultKind]:
    """Those that the device's twin knows."""
    kinds: list[FaultKind] = [] if WINDOWS else ["freeze", "kill"]
    if not (device_link.device.driver or "").endswith(tuple(f":{twin}" for twin in TWINS.values())):
        return kinds
    if "interlock" in device_link.contract.status.get("properties", {}):
        kinds.append("interlock")
    if device_link.contract.safe_state:
        kinds.append("stop")
    return [*kinds, "slow"]


def _told(device: str, one: dict[str, Any]) -> OrderedFault:
    if one["kind"] in LASTING:
        return OrderedFault(kind=one["kind"], text=LASTING[one["kind"]].format(device))
    error = f" with {one['error']}" if one["error"] else ""
    return OrderedFault(
        kind="error", text=f"the next {one['left']} of {device}.{one['action']} fail{error}"
    )
