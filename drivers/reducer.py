"""Offers spectrum reduction as a device, so that it may run on another machine."""

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import Any, ClassVar

from .driver import ActionFailed, Driver, GoalContext, Place

# By name, since reduction is not part of the drivers: it is data in, figures out, and stands alone.
REDUCTION = "labrun.reduction"
WARM_UP_S = 60.0
MOST_AT_ONCE = 4


class Reducer(Driver):
    """Implements spectrum_reducer@1; spectra are reduced in threads while the server's loop runs on.

    The device has a few threads of its own: a backlog of spectra waits its turn, and takes neither
    the memory nor the threads that other devices of the same server need.
    """

    contract: ClassVar[str] = "spectrum_reducer@1"
    extra: ClassVar[str | None] = "spectra"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._warming: asyncio.Future[None] | None = None
        self._threads = ThreadPoolExecutor(most_at_once(), thread_name_prefix="reduce")

    async def open(self) -> None:
        # The fits are compiled on first use; better now than during the first goal.
        loop = asyncio.get_running_loop()
        self._warming = loop.run_in_executor(self._threads, _warm_up)

    async def close(self) -> None:
        if self._warming is not None:
            await asyncio.wait([self._warming], timeout=WARM_UP_S)
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def reduce(
        self, goal: GoalContext, *, spectrum: str, elements: list[str] | None = None
    ) -> dict[str, Any]:
        if self._warming is not None and not self._warming.done():
            # Only one thread imports and compiles: two could deadlock, one with numba's lock, one
            # with Python's lock on a module that is being imported.
            goal.feedback(message="compiling the fits, on first use only")
            await asyncio.wait([self._warming])
        sent = goal.files.get("spectrum")
        source = spectrum if sent is None else sent.data
        try:
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(self._threads, _reduce, source, elements)
        except (OSError, ValueError) as fault:
            raise ActionFailed("Unreadable", f"{spectrum}: {fault}") from fault


def most_at_once() -> int:
    """One per core, up to a few: more at a time would only use more memory."""
    return max(1, min(os.cpu_count() or 1, MOST_AT_ONCE))


def _reduce(source: str | bytes, elements: list[str] | None) -> dict[str, Any]:
    reduction = import_module(REDUCTION)
    return reduction.reduce_spectrum(reduction.read_spectrum(source), elements).to_dict()


def _warm_up() -> None:
    import_module(f"{REDUCTION}.warm_up").warm_up()
