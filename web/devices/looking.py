"""What cameras see now, for all who look on: a look each so often, and none while a run has the camera."""

import asyncio
import time
from collections import defaultdict
from collections.abc import Callable

from ...drivers.client.client import NoPicture, ServerUnreachable
from ...schemas.messages import Look
from ..local.refusal import Refusal, not_found
from .device_link import DeviceLink

KINDS = {b"\xff\xd8\xff": ".jpg", b"\x89PNG\r\n\x1a\n": ".png"}
"""First bytes -> suffix, of the pictures that a browser may be shown."""


class Looking:
    """`used_by` gives the live run that has a device, `every_s` how often a camera is looked through."""

    def __init__(
        self, device_link: Callable[[str], DeviceLink], used_by: Callable[[str], str | None],
        every_s: Callable[[], float],
    ) -> None:  # fmt: skip
        self._device_link = device_link
        self._used_by = used_by
        self._every_s = every_s
        self._seen: dict[tuple[str, bool], tuple[float, Look]] = {}
        self._one_look: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)

    async def look(
        self, device: str, *, now: bool = False, above: bool = False
    ) -> tuple[Look, str]:
        """A look and the suffix of its picture; with `now`, a look of its own. Raises Refusal."""
        link = self._device_link(device)
        if link.contract.look() is None:
            raise not_found("camera", device, f"{link.contract.type} has no action that is a look")
        if above and not link.contract.looks_from_above():
            words = f"{device} gives no picture from above: {link.contract.type} has no `above`"
            raise Refusal(409, "NO_PICTURE", words)
        async with self._one_look[device]:
            self._check_free(device)
            at_s, look = self._seen.get((device, above), (0.0, None))
            if now or look is None or time.monotonic() - at_s >= self._every_s():
                look = await self._look(link, above)
                self._seen[device, above] = time.monotonic(), look
        data = look.file.data
        suffix = next((suffix for first, suffix in KINDS.items() if data.startswith(first)), "")
        if not suffix:
            raise Refusal(502, "NO_PICTURE", f"what {device} gives is neither JPEG nor PNG")
        return look, suffix

    def _check_free(self, device: str) -> None:
        run = self._used_by(device)
        if run is not None:
            words = f"{device} is not looked through while {run} has it"
            raise Refusal(409, "HELD", words, "the pictures that the run takes are among its files")

    async def _look(self, link: DeviceLink, above: bool) -> Look:
        try:
            client, within_s = link.reachable_client(), link.contract.look_s()
            return await client.look(link.name, above, within_s)
        except NoPicture as fault:
            raise Refusal(409, "NO_PICTURE", str(fault)) from fault
        except ServerUnreachable as fault:
            raise Refusal(503, "LOST", str(fault)) from fault
