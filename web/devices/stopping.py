"""STOP ALL: put every device into its safe state at once, and restart nothing."""

import asyncio
import logging
import time
from collections.abc import Callable, Coroutine
from typing import Any

from ...system.tasks import spawn
from ..access.headers import by_whom
from ..local.clock import now_iso
from ..models.devices import Stopped, StoppedDevice, StoppedRun
from .arming import Arming
from .device_link import DeviceLink
from .jogging import Jogging

LOG = logging.getLogger("labrun")
BY = "STOP ALL on the page"
ANSWER_S = 0.9
"""Time for a device to confirm; the answer is sent within one second."""


class Stopping:
    """Stops `links`; `abort` aborts every live run and returns their answers."""

    def __init__(
        self, links: list[DeviceLink], jogging: Jogging, arming: Arming,
        abort: Callable[[float, str], Coroutine[Any, Any, list[StoppedRun]]], tell: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._links = links
        self._jogging = jogging
        self._arming = arming
        self._abort = abort
        self._tell = tell
        self._latest: asyncio.Task[Stopped] | None = None
        self._press: str | None = None

    async def stop_all(self, press: str | None = None, name: str = "") -> Stopped:
        """Stop, for who says to be `name`.

        A request during a stop, or again for the same press, gets the same answer:
        a page sends it by two routes at once, and an engine that gets a second abort skips
        `finally`. The stop continues if its requester disconnects.
        """
        same = press is not None and press == self._press
        if self._latest is None or (self._latest.done() and not same):
            self._latest = spawn("stop all devices", self._stop_all(by_whom(name, BY)))
            self._press = press
        return await asyncio.shield(self._latest)

    async def close(self) -> None:
        """Wait for the end of a stop."""
        if self._latest is not None:
            await asyncio.wait({self._latest})

    async def _stop_all(self, by: str) -> Stopped:
        """Devices first; runs are aborted meanwhile, so that none continues once its device is stopped."""
        stopping = [spawn(f"stop {one.name}", _stop(one, by)) for one in self._links]
        aborting = spawn("abort all runs", self._abort(ANSWER_S, by))
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


async def _stop(device_link: DeviceLink, by: str) -> StoppedDevice:
    began = time.monotonic()
    confirmed, message = False, f"not connected: {device_link.state(None, None).reason}"
    if device_link.client is not None:
        try:
            async with asyncio.timeout(ANSWER_S + 0.05):
                told = await device_link.client.stop(device_link.name, ANSWER_S, by=by)
            confirmed, message = told.get(device_link.name, (False, "it did not answer"))
        except TimeoutError:
            message = f"no answer within {ANSWER_S:g} s"
        except Exception as fault:  # whatever it was: the answer says so, and how the others did
            LOG.exception("the stop of %s failed", device_link.name)
            message = f"the stop failed: {type(fault).__name__}: {fault}"
    took = round(time.monotonic() - began, 3)
    return StoppedDevice(
        device=device_link.name, confirmed=confirmed, message=message, seconds=took
    )
