"""A line that several devices share: who asks has it alone for one exchange.

Each device is served by a process of its own, so the turn is a locked file, which the system frees
when a process dies.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from ...system.files import lock_file, lock_of_this_computer

AGAIN_S = 0.01


class SharedLine:
    """The turns of one serial port or address, for all devices of this computer that say `shared`."""

    def __init__(self, resource: str) -> None:
        self._resource = resource
        name = "".join(sign if sign.isalnum() else "_" for sign in resource.lower())
        self._name = f"line_{name}"

    @asynccontextmanager
    async def turn(self, timeout_s: float) -> AsyncIterator[None]:
        """Wait until nobody else asks; raises OSError when the time is up."""
        clock = asyncio.get_running_loop().time
        until = clock() + timeout_s
        with lock_of_this_computer(self._name) as file:
            while True:
                try:
                    lock_file(file)
                    break
                except OSError:
                    if clock() >= until:
                        words = f"{self._resource} was in use by another device for {timeout_s:g} s"
                        raise OSError(words) from None
                await asyncio.sleep(AGAIN_S)
            yield
