"""Wait until incoming data makes a condition true."""

import asyncio
from collections.abc import Callable

from ...system.tasks import in_time


class Condition(asyncio.Event):
    """Set by the receiver of data; a waiter then checks its condition again."""

    async def until(self, true: Callable[[], bool], seconds: float) -> bool:
        """Wait until this is true; False on timeout."""
        clock = asyncio.get_running_loop().time
        end = clock() + seconds
        while not true():
            self.clear()
            left = end - clock()
            if left <= 0:
                return False
            await in_time(self.wait(), left)
        return True
