"""What a driver begins with whose instrument speaks in bytes: a connection, and answers out of what comes.

`labrun new device` writes one. See docs/how-to/add-a-device.md.
"""

import asyncio
from collections.abc import Callable

from ..driver import Place
from .bridge import Bridge
from .config import BridgeConfig
from .lines import LineConfig, NoAnswer, channel_of

Found = Callable[[bytearray], bytes | None]
"""Finds the answer in what has come since something was sent; None if it is not whole yet."""


class ByteBridgeConfig(LineConfig, BridgeConfig):
    """Where it is (`resource`, `baud` and the like), and what every bridge's config has."""


class ByteBridge(Bridge):
    """A bridge of your own: it says `perform`, and asks by `ask`."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.channel = self._reads = channel_of(place, self.config)

    async def ready(self, timeout_s: float) -> None:
        if not self.channel.is_open:
            await self.channel.open(timeout_s)
            if self.channel.resource.kind != "visa":  # which is only read when it has been asked
                await self.channel.quiet()

    async def drop(self) -> None:
        await self.channel.close()

    async def ask(self, data: bytes, found: Found, timeout_s: float) -> bytes:
        """Send bytes and return the answer that is found; raises NoAnswer or OSError."""
        self.channel.received.clear()
        await self.channel.write(data)
        clock = asyncio.get_running_loop().time
        until = clock() + timeout_s
        while (answer := found(self.channel.received)) is None:
            left = until - clock()
            if left <= 0 or not await self.channel.more(left):
                heard = self.channel.received.hex(" ")[:80]
                told = f"answered {heard}, which is no whole answer" if heard else "was silent"
                raise NoAnswer(f"it was sent {data.hex(' ')[:80]} and {told}")
        return answer
