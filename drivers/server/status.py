"""A device's status: sent when something changes, and once a second."""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from typing import Any

from ...system.tasks import end, keep
from ..driver import Driver
from .arguments import odd_value

EVERY_S = 1.0
ANSWER_S = 2.0
FLURRY_S = 0.05
"""Changes that come faster share one status query."""

LOG = logging.getLogger("labrun")


class StatusWatch:
    """Queries one driver's status and passes it on."""

    def __init__(
        self, driver: Driver, tell: Callable[[dict[str, Any]], None],
        every_s: float | None = EVERY_S,
    ) -> None:  # fmt: skip
        """`every_s`: None, if nobody listens."""
        self.every_s = every_s
        self.latest: dict[str, Any] = {}
        self._driver = driver
        self._tell = tell
        self._changed = asyncio.Event()
        self._asking = asyncio.Lock()
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Query for the first time, and keep querying where anybody listens."""
        await self._ask()
        if self.every_s is not None:
            self._task = keep(f"status of {type(self._driver).__name__}", self._watch)

    async def close(self) -> None:
        """Stop querying."""
        await end(self._task)

    def changed(self) -> None:
        """Note that something happened to the device, so that it is queried soon."""
        self._changed.set()

    async def _watch(self) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self.every_s):
                    await self._changed.wait()
            await asyncio.sleep(FLURRY_S)
            self._changed.clear()
            await self._ask()
            self._tell(self.latest)

    async def unmet(self, interlock: dict[str, Any]) -> str | None:
        """The first thing that the status must be and is not now, as a message."""
        fault = await self._ask()
        for name, wanted in interlock.items():
            if fault:
                return f"nobody knows whether {name} is {wanted!r}: {fault}"
            if name not in self.latest:
                return f"{name} is not reported and must be {wanted!r}"
            if self.latest[name] != wanted:
                return f"{name} is {self.latest[name]!r} and must be {wanted!r}"
        return None

    async def _ask(self) -> str:
        async with self._asking:
            return await self._ask_driver()

    async def _ask_driver(self) -> str:
        """Query the driver; why it could not answer, or nothing."""
        try:
            async with asyncio.timeout(ANSWER_S):
                latest = await self._driver.status()
            odd = odd_value(latest, "status")
            if odd is not None:
                raise ValueError(odd)
            self.latest = latest
        except Exception as fault:  # a device without a status still has to be described
            words = f"{type(fault).__name__}: {fault}"
            if self.latest.get("fault") != words:  # once, and not every second
                LOG.exception("the status of %s", type(self._driver).__name__)
            self.latest = {**self.latest, "fault": words}
            return words
        return ""
