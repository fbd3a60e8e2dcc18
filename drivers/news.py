"""Wait until something that is heard makes something true."""

import asyncio
import contextlib
from collections.abc import Callable


class News(asyncio.Event):
    """Set by whoever hears something; who waits looks again then whether it is what was waited for."""

    async def until(self, true: Callable[[], bool], seconds: float) -> bool:
        """Wait until this is true; False where it was not in time."""
        clock = asyncio.get_running_loop().time
        end = clock() + seconds
        while not true():
            self.clear()
            left = end - clock()
            if left <= 0:
                return False
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(left):
                    await self.wait()
        return True
