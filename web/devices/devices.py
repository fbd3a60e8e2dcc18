"""All devices of the lab, each with its link; which run uses a device is known elsewhere."""

import asyncio
from collections.abc import Callable
from pathlib import Path

from ...engine.lab.lab import LoadedLab
from ..local.kept_out import kept_out
from ..local.refusal import not_found
from ..models.devices import DeviceDetail, DeviceState
from .device_link import DeviceLink
from .form import action_form, moving_of

SCAN_S = 3.0


class DeviceLinks:
    """`used_by` gives the live run that holds a device, `armed` who has armed an action of it."""

    def __init__(
        self, lab: LoadedLab, folder: Path, changed: Callable[[str], None],
        used_by: Callable[[str], str | None], armed: Callable[[str], str | None],
    ) -> None:  # fmt: skip
        self._lab = lab
        self.links = {name: DeviceLink(name, lab, folder, changed) for name in lab.lab.devices}
        self._used_by = used_by
        self._armed = armed

    def open(self) -> None:
        """Start connecting to every device."""
        for device_link in self.links.values():
            device_link.open()

    async def close(self) -> None:
        """Close all links; servers that a live run uses keep running."""
        await asyncio.gather(
            *(
                device_link.close(stop_server=self._used_by(name) is None)
                for name, device_link in self.links.items()
            )
        )

    def device_link(self, device: str) -> DeviceLink:
        """One device; raises Refusal (404)."""
        if device not in self.links:
            raise not_found("device", device, f"the lab has {', '.join(self.links)}")
        return self.links[device]

    def state(self, device: str) -> DeviceState:
        """The current state of one device."""
        return self.device_link(device).state(self._used_by(device), self._armed(device))

    def states(self) -> list[DeviceState]:
        """All of them, in the order of the lab."""
        return [self.state(name) for name in self.links]

    def detail(self, device: str) -> DeviceDetail:
        """One device with its contract."""
        device_link = self.device_link(device)
        contract, limits = device_link.contract, device_link.device.limits
        described = (
            device_link.client.devices.get(device) if device_link.client is not None else None
        )
        moving = moving_of(contract, limits)
        return DeviceDetail(
            **self.state(device).model_dump(),
            summary=contract.summary,
            versions=described.versions if described is not None else {},
            status_schema=contract.status, safe_state=contract.safe_state,
            actions=[action_form(name, one, limits) for name, one in contract.actions.items()],
            axes=list(moving.axes) if moving is not None else [],
            ranges_mm={**moving.ranges_mm} if moving is not None else {},
            keep_out=kept_out(self._lab, device),
        )  # fmt: skip

    async def scan(self) -> list[DeviceState]:
        """Try every device that is not connected, and give it a moment."""
        missing = [one for one in self.links.values() if not one.online]
        for device_link in missing:
            device_link.look_again()
        until = asyncio.get_running_loop().time() + SCAN_S
        while any(not one.online for one in missing):
            if asyncio.get_running_loop().time() > until:
                break
            await asyncio.sleep(0.05)
        return self.states()

    def user(self, device: str) -> str | None:
        """The live run that holds a device."""
        return self._used_by(device)
