"""Messages for one client: in order, and bounded if the client does not read."""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable

MOST_MESSAGES = 2000
MOST_BYTES = 32 * 2**20

Frame = str | bytes


class Outbox:
    """Topics and feedback are dropped for messages that must arrive; `full` is set if those pile up."""

    def __init__(self) -> None:
        self.full = asyncio.Event()
        self._frames: deque[tuple[Frame, bool]] = deque()
        self._size = 0
        self._ready = asyncio.Event()

    def put(self, frame: Frame, *, droppable: bool = False) -> None:
        """Send it in its turn."""
        self._frames.append((frame, droppable))
        self._size += len(frame)
        if self._is_over():
            self._drop()
        self._ready.set()

    async def drain_into(self, send: Callable[[Frame], Awaitable[None]]) -> None:
        """Send while the client is connected."""
        while True:
            await self._ready.wait()
            while self._frames:
                frame, _ = self._frames.popleft()
                self._size -= len(frame)
                await send(frame)
            self._ready.clear()

    def _is_over(self) -> bool:
        return len(self._frames) > MOST_MESSAGES or self._size > MOST_BYTES

    def _drop(self) -> None:
        kept: deque[tuple[Frame, bool]] = deque()
        spare = len(self._frames) // 2
        for frame, droppable in self._frames:
            if droppable and spare > 0:
                spare -= 1
                self._size -= len(frame)
            else:
                kept.append((frame, droppable))
        self._frames = kept
        if self._is_over():
            self.full.set()
