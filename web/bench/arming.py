"""Arming: a hazard by hand is armed by whoever has control, held, and then done once."""

import asyncio
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass

from ...schemas.contract import Action
from ..clock import iso
from ..guard.refusal import Refusal, not_found
from ..models.devices import Armed
from .form import level_of
from .station import Station

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
        self, station: Callable[[str], Station], used_by: Callable[[str], str | None],
        changed: Callable[[str], None], lasts_s: float = LASTS_S,
    ) -> None:  # fmt: skip
        self._station = station
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
        """Arm an action for a minute; raises Refusal where that must not be now."""
        station = self._station(device)
        wanted = station.contract.actions.get(action)
        if wanted is None:
            raise not_found("action", f"{device}.{action}")
        if level_of(wanted) != 3:
            raise Refusal(422, "NOT_DANGEROUS", f"{device}.{action} needs no arming")
        station.reached()
        self.check_free(device)
        self.check_interlock(station, wanted)
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

    def spend(self, station: Station, action: str, by: str, id: str | None) -> None:
        """Use what was armed, once; raises Refusal where it was not, or was not held."""
        armed = self._armed.get(station.name)
        known = armed is not None and id is not None and secrets.compare_digest(armed.told.id, id)
        if armed is None or not known or armed.told.action != action or armed.told.by != by:
            raise Refusal(
                409, "NOT_ARMED", f"{station.name}.{action} is dangerous and was not armed by you",
                "arm it, hold, and ask again",
            )  # fmt: skip
        if time.monotonic() - armed.since < HOLD_S:
            raise Refusal(409, "NOT_HELD", f"hold for {HOLD_S:g} s before {action} is done")
        self.check_interlock(station, station.contract.actions[action])
        self.disarm(station.name)

    def disarm(self, device: str | None = None) -> None:
        """Disarm one device, or all."""
        for name in [device] if device is not None else list(self._armed):
            armed = self._armed.pop(name, None)
            if armed is not None:
                armed.timer.cancel()
                self._changed(name)

    def check_free(self, device: str) -> None:
        """Raise Refusal (409) while a run has the device."""
        run = self._used_by(device)
        if run is not None:
            raise Refusal(
                409, "HELD", f"{run} uses {device}", "abort the run, or wait until it is over",
                details={"run": run},
            )  # fmt: skip

    def check_interlock(self, station: Station, action: Action) -> None:
        """Raise Refusal (409) where a field of the status is not what the contract demands."""
        for field, wanted in action.interlock.items():
            found = station.status.get(field)
            if found != wanted:
                raise Refusal(
                    409, "INTERLOCK", f"{station.name}: {field} is {found!r}, it must be {wanted!r}"
                )
