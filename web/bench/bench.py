"""All devices of the lab, each kept by its station; who uses which is asked elsewhere."""

import asyncio
from collections.abc import Callable
from pathlib import Path

from ...engine.lab import LoadedLab
from ..guard.refusal import not_found
from ..kept_out import kept_out
from ..models.devices import DeviceDetail, DeviceState
from .form import action_form, moving_of
from .station import Station

SCAN_S = 3.0


class Bench:
    """`used_by` says which live run holds a device, `armed` who has armed an action of it."""

    def __init__(
        self, lab: LoadedLab, folder: Path, changed: Callable[[str], None],
        used_by: Callable[[str], str | None], armed: Callable[[str], str | None],
    ) -> None:  # fmt: skip
        self._lab = lab
        self.stations = {name: Station(name, lab, folder, changed) for name in lab.lab.devices}
        self._used_by = used_by
        self._armed = armed

    def open(self) -> None:
        """Begin to reach every device."""
        for station in self.stations.values():
            station.open()

    async def close(self) -> None:
        """Let go of all; servers that a live run uses are left alone."""
        await asyncio.gather(
            *(
                station.close(stop_server=self._used_by(name) is None)
                for name, station in self.stations.items()
            )
        )

    def station(self, device: str) -> Station:
        """One device; raises Refusal (404)."""
        if device not in self.stations:
            raise not_found("device", device, f"the lab has {', '.join(self.stations)}")
        return self.stations[device]

    def state(self, device: str) -> DeviceState:
        """One device as it is now."""
        return self.station(device).state(self._used_by(device), self._armed(device))

    def states(self) -> list[DeviceState]:
        """All of them, in the order of the lab."""
        return [self.state(name) for name in self.stations]

    def detail(self, device: str) -> DeviceDetail:
        """One device with its contract."""
        station = self.station(device)
        contract, limits = station.contract, station.device.limits
        described = station.client.devices.get(device) if station.client is not None else None
        moving = moving_of(contract, limits)
        return DeviceDetail(
            **self.state(device).model_dump(),
            summary=contract.summary, concurrent=contract.concurrent,
            versions=described.versions if described is not None else {},
            status_schema=contract.status, safe_state=contract.safe_state,
            actions=[action_form(name, one, limits) for name, one in contract.actions.items()],
            axes=list(moving.ranges_mm) if moving is not None else [],
            ranges_mm={**moving.ranges_mm} if moving is not None else {},
            keep_out=kept_out(self._lab, device),
        )  # fmt: skip

    async def scan(self) -> list[DeviceState]:
        """Try every device that is not reached, and give it a moment."""
        missing = [one for one in self.stations.values() if not one.online]
        for station in missing:
            station.look_again()
        until = asyncio.get_running_loop().time() + SCAN_S
        while any(not one.online for one in missing):
            if asyncio.get_running_loop().time() > until:
                break
            await asyncio.sleep(0.05)
        return self.states()

    def user(self, device: str) -> str | None:
        """The live run that holds a device."""
        return self._used_by(device)
