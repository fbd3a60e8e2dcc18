"""A line that several devices share: who asks has it alone for one exchange.

Each device is served by a process of its own, so the turn is a locked file, which the system frees
when a process dies.
"""

import asyncio
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from ...system.files import lock_file

AGAIN_S = 0.01


class SharedLine:
    """The turns of one serial port or address, for all devices of this computer that say `shared`."""

    def __init__(self, resource: str) -> None:
        self._resource = resource
        name = "".join(sign if sign.isalnum() else "_" for sign in resource.lower())
        self._path = Path(tempfile.gettempdir()) / f"labrun_line_{name}.lock"

    @asynccontextmanager
    async def turn(self, timeout_s: float) -> AsyncIterator[None]:
        """Wait until nobody else asks; raises OSError when the time is up."""
        clock = asyncio.get_running_loop().time
        until = clock() + timeout_s
        with self._path.open("a+") as file:
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
