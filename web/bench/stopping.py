"""STOP ALL: every device into its safe state at once, and nothing that starts anything again."""

import asyncio
import time
from collections.abc import Awaitable, Callable

from ..clock import now_iso
from ..models.devices import Stopped, StoppedDevice, StoppedRun
from .arming import Arming
from .jogging import Jogging
from .station import Station

ANSWER_S = 0.9
"""A device has so long to confirm; the answer is out within the second."""


class Stopping:
    """Stops `stations`; `abort` tells every live run, and gives what each said."""

    def __init__(
        self, stations: Callable[[], list[Station]], jogging: Jogging, arming: Arming,
        abort: Callable[[float], Awaitable[list[StoppedRun]]], tell: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._stations = stations
        self._jogging = jogging
        self._arming = arming
        self._abort = abort
        self._tell = tell
        self._latest: asyncio.Task[Stopped] | None = None
        self._press: str | None = None

    async def stop_all(self, press: str | None = None) -> Stopped:
        """Stop; whoever asks while that is under way, or again for the same press, gets its answer.

        A page asks by two ways at once, and an engine that is told twice to abort leaves out
        `finally`. The stop goes on when its asker has gone.
        """
        same = press is not None and press == self._press
        if self._latest is None or (self._latest.done() and not same):
            self._latest = asyncio.create_task(self._stop_all())
            self._press = press
        return await asyncio.shield(self._latest)

    async def close(self) -> None:
        """Wait for the end of a stop."""
        if self._latest is not None:
            await asyncio.wait({self._latest})

    async def _stop_all(self) -> Stopped:
        """Devices first; runs are aborted beside, so that none goes on when its device is calm."""
        stopping = [asyncio.create_task(_stop(station)) for station in self._stations()]
        aborting = asyncio.ensure_future(self._abort(ANSWER_S))
        self._jogging.end_all("STOP ALL")
        self._arming.disarm()
        await asyncio.wait({*stopping, aborting})
        devices = [task.result() for task in stopping]
        silent = [one.device for one in devices if not one.confirmed]
        if silent:
            self._tell(f"{', '.join(silent)} did not confirm the stop. Use the hardware e-stop.")
        return Stopped(
            all_confirmed=not silent, devices=devices, runs=aborting.result(), at=now_iso()
        )


async def _stop(station: Station) -> StoppedDevice:
    began = time.monotonic()
    confirmed, message = False, f"not connected: {station.state(None, None).reason}"
    if station.client is not None:
        try:
            async with asyncio.timeout(ANSWER_S + 0.05):
                told = await station.client.stop(station.name, ANSWER_S)
            confirmed, message = told.get(station.name, (False, "it did not answer for itself"))
        except TimeoutError:
            message = f"no answer within {ANSWER_S:g} s"
    took = round(time.monotonic() - began, 3)
    return StoppedDevice(device=station.name, confirmed=confirmed, message=message, seconds=took)
