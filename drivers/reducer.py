"""Offers the reduction of spectra as a device, so that it may run on another machine."""

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import Any, ClassVar

from .driver import ActionFailed, Driver, GoalContext, Place

# By name, since reduction is no part of the drivers: it is data in, figures out, and stands alone.
REDUCTION = "labrun.reduction"
WARM_UP_S = 60.0
MOST_AT_ONCE = 4


class Reducer(Driver):
    """Keeps spectrum_reducer@1; spectra are reduced in threads, the server's loop goes on meanwhile.

    The threads are the device's own and few: a heap of spectra waits for its turn, and takes
    neither the memory nor the threads that other devices of the same server need.
    """

    contract: ClassVar[str] = "spectrum_reducer@1"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._warming: asyncio.Future[None] | None = None
        self._threads = ThreadPoolExecutor(most_at_once(), thread_name_prefix="reduce")

    async def open(self) -> None:
        # The fits compile themselves on first use; better now than on the first goal's time.
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
            # One thread imports and compiles, alone: two of them can wait for each other for ever,
            # one with numba's lock, one with Python's for a module that is being imported.
            goal.feedback(message="the fits are being made ready (compiled, on first use only)")
            await asyncio.wait([self._warming])
        sent = goal.files.get("spectrum")
        source = spectrum if sent is None else sent.data
        try:
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(self._threads, _reduce, source, elements)
        except (OSError, ValueError) as fault:
            raise ActionFailed("Unreadable", f"{spectrum}: {fault}") from fault


def most_at_once() -> int:
    """One for each core, few at the most: more at a time would only hold more memory."""
    return max(1, min(os.cpu_count() or 1, MOST_AT_ONCE))


def _reduce(source: str | bytes, elements: list[str] | None) -> dict[str, Any]:
    reduction = import_module(REDUCTION)
    return reduction.reduce_spectrum(reduction.read_spectrum(source), elements).to_dict()


def _warm_up() -> None:
    import_module(f"{REDUCTION}.warm_up").warm_up()
