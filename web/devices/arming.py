"""Arming: a manual hazard is armed by the holder of control, held, and then done once."""

import asyncio
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass

from ...schemas.contract import Action
from ..local.clock import iso
from ..local.refusal import Refusal, not_found
from ..models.devices import Armed
from .device_link import DeviceLink
from .form import level_of

LASTS_S = 60.0
HOLD_S = 1.0


@dataclass(slots=True)
class _Armed:
    told: Armed
    since: float
    timer: asyncio.TimerHandle


class Arming:
    """What is armed now; `changed` is called with the device's name."""

    def __init__(
        self, device_link: Callable[[str], DeviceLink], used_by: Callable[[str], str | None],
        changed: Callable[[str], None], lasts_s: float = LASTS_S,
    ) -> None:  # fmt: skip
        self._device_link = device_link
        self._used_by = used_by
        self._changed = changed
        self._lasts_s = lasts_s
        self._armed: dict[str, _Armed] = {}

    def any(self) -> bool:
        """True while something is armed."""
        return bool(self._armed)

    def by(self, device: str) -> str | None:
        """Who has armed an action of a device."""
        armed = self._armed.get(device)
        return armed.told.by if armed is not None else None

    def arm(self, device: str, action: str, by: str) -> Armed:
        """Arm an action for a minute; raises Refusal if that is not allowed now."""
        device_link = self._device_link(device)
        wanted = device_link.contract.actions.get(action)
        if wanted is None:
            raise not_found("action", f"{device}.{action}")
        if level_of(wanted) != 3:
            raise Refusal(422, "NOT_DANGEROUS", f"{device}.{action} needs no arming")
        device_link.reachable_client()
        self.check_free(device)
        self.check_interlock(device_link, wanted)
        self.disarm(device)
        told = Armed(
            id=secrets.token_urlsafe(12), device=device, action=action,
            danger=wanted.danger or "", by=by, ends_at=iso(time.time() + self._lasts_s),
            hold_s=HOLD_S,
        )  # fmt: skip
        timer = asyncio.get_running_loop().call_later(self._lasts_s, self.disarm, device)
        self._armed[device] = _Armed(told, time.monotonic(), timer)
        self._changed(device)
        return told

    def spend(self, device_link: DeviceLink, action: str, by: str, id: str | None) -> None:
        """Use an armed action, once; raises Refusal if it was not armed, or not held."""
        armed = self._armed.get(device_link.name)
        known = armed is not None and id is not None and secrets.compare_digest(armed.told.id, id)
        if armed is None or not known or armed.told.action != action or armed.told.by != by:
            raise Refusal(
                409, "NOT_ARMED", f"{device_link.name}.{action} is dangerous and was not armed by you",
                "arm it, hold, and try again",
            )  # fmt: skip
        if time.monotonic() - armed.since < HOLD_S:
            raise Refusal(409, "NOT_HELD", f"hold for {HOLD_S:g} s to start {action}")
        self.check_interlock(device_link, device_link.contract.actions[action])
        self.disarm(device_link.name)

    def disarm(self, device: str | None = None) -> None:
        """Disarm one device, or all."""
        for name in [device] if device is not None else list(self._armed):
            armed = self._armed.pop(name, None)
            if armed is not None:
                armed.timer.cancel()
                self._changed(name)

    def check_free(self, device: str) -> None:
        """Raise Refusal (409) while a run holds the device."""
        run = self._used_by(device)
        if run is not None:
            raise Refusal(
                409, "HELD", f"{run} uses {device}", "abort the run, or wait until it has ended",
                details={"run": run},
            )  # fmt: skip

    def check_interlock(self, device_link: DeviceLink, action: Action) -> None:
        """Raise Refusal (409) if a status field is not what the contract requires."""
        for field, wanted in action.interlock.items():
            found = device_link.status.get(field)
            if found != wanted:
                raise Refusal(
                    409,
                    "INTERLOCK",
                    f"{device_link.name}: {field} is {found!r} but must be {wanted!r}",
                )
