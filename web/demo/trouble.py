"""Injected faults: an action that fails, a server that dies or hangs."""

import os
import signal
from pathlib import Path

from ...system import WINDOWS
from ..devices.device_link import DeviceLink
from ..devices.devices import DeviceLinks
from ..local.refusal import Refusal
from ..models.demo import OrderFault
from .orders import clear, order

SIGNALS = {"kill": "SIGKILL", "freeze": "SIGSTOP", "thaw": "SIGCONT"}


class Trouble:
    """Injects faults into the demonstration's bench; `world` is what its twins share."""

    def __init__(self, device_links: DeviceLinks, world: Path) -> None:
        self._device_links = device_links
        self._world = world

    async def order(self, asked: OrderFault) -> str:
        """Inject the fault; returns a sentence."""
        device_link = self._device_links.device_link(asked.device)
        if asked.kind == "clear":
            clear(self._world, device_link.name)
            return f"no more faults are injected into {device_link.name}"
        if asked.kind != "error":
            return self._signal(device_link, asked.kind)
        if asked.action is None or asked.action not in device_link.contract.actions:
            known = ", ".join(device_link.contract.actions)
            raise Refusal(
                422, "PARAMS", f"{device_link.name} has no action {asked.action!r}: {known}"
            )
        errors = device_link.contract.actions[asked.action].errors
        if not errors or (asked.error is not None and asked.error not in errors):
            known = ", ".join(errors) or "none"
            raise Refusal(422, "PARAMS", f"errors of {device_link.name}.{asked.action}: {known}")
        order(self._world, device_link.name, asked.action, asked.error, asked.count)
        return f"the next {asked.count} of {device_link.name}.{asked.action} will fail"

    def _signal(self, device_link: DeviceLink, kind: str) -> str:
        pid = device_link.server_pid
        if pid is None or WINDOWS:
            raise Refusal(409, "NO_SERVER", f"{device_link.name} has no server here to {kind}")
        try:
            os.kill(pid, getattr(signal, SIGNALS[kind]))
        except ProcessLookupError:
            raise Refusal(409, "NO_SERVER", f"the server of {device_link.name} is gone") from None
        return f"{kind}: the server of {device_link.name} (process {pid})"
