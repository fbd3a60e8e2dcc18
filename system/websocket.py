"""A WebSocket that can be dropped: aiohttp's own is closed by a farewell, which a cancel can cut short."""

import aiohttp


class WebSocket(aiohttp.ClientWebSocketResponse):
    """The client's end of one connection."""

    def drop(self) -> None:
        """Close the connection without a farewell; nothing is left to wait for."""
        self._response.close()
