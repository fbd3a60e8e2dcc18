"""What a device says of itself: told when something changed, and once a second."""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any

from .arguments import odd_value
from .driver import Driver

EVERY_S = 1.0
ANSWER_S = 2.0
FLURRY_S = 0.05
"""Changes that come faster share one look at the device."""


class StatusWatch:
    """Asks one driver for its status and passes it on."""

    def __init__(self, driver: Driver, tell: Callable[[dict[str, Any]], None]) -> None:
        self.latest: dict[str, Any] = {}
        self._driver = driver
        self._tell = tell
        self._changed = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Ask for the first time, and go on asking."""
        await self._ask()
        self._task = asyncio.create_task(self._watch())

    async def close(self) -> None:
        """Ask no more."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    def changed(self) -> None:
        """Something happened to the device; it is asked soon."""
        self._changed.set()

    async def _watch(self) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(EVERY_S):
                    await self._changed.wait()
            await asyncio.sleep(FLURRY_S)
            self._changed.clear()
            await self._ask()
            self._tell(self.latest)

    async def _ask(self) -> None:
        try:
            async with asyncio.timeout(ANSWER_S):
                latest = await self._driver.status()
            odd = odd_value(latest, "status")
            if odd is not None:
                raise ValueError(odd)
            self.latest = latest
        except Exception as fault:  # a device that cannot say how it is still has to be described
            self.latest = {**self.latest, "fault": f"{type(fault).__name__}: {fault}"}
