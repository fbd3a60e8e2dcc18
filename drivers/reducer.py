"""Offers the reduction of spectra as a device, so that it may run on another machine."""

import asyncio
from importlib import import_module
from typing import Any, ClassVar

from .driver import ActionFailed, Driver, GoalContext, Place

# By name, since reduction is no part of the drivers: it is data in, figures out, and stands alone.
REDUCTION = "labrun.reduction"
WARM_UP_S = 60.0


class Reducer(Driver):
    """Keeps spectrum_reducer@1; each spectrum is reduced in a thread of its own."""

    contract: ClassVar[str] = "spectrum_reducer@1"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._warming: asyncio.Task[None] | None = None

    async def open(self) -> None:
        # The fits compile themselves on first use; better now than on the first goal's time.
        self._warming = asyncio.create_task(asyncio.to_thread(_warm_up))

    async def close(self) -> None:
        if self._warming is not None:
            await asyncio.wait([self._warming], timeout=WARM_UP_S)

    async def reduce(
        self, goal: GoalContext, *, spectrum: str, elements: list[str] | None = None
    ) -> dict[str, Any]:
        if self._warming is not None and not self._warming.done():
            goal.feedback(message="the fits are being compiled, on first use only")
        sent = goal.files.get("spectrum")
        source = spectrum if sent is None else sent.data
        try:
            return await asyncio.to_thread(_reduce, source, elements)
        except (OSError, ValueError) as fault:
            raise ActionFailed("Unreadable", f"{spectrum}: {fault}") from fault


def _reduce(source: str | bytes, elements: list[str] | None) -> dict[str, Any]:
    reduction = import_module(REDUCTION)
    return reduction.reduce_spectrum(reduction.read_spectrum(source), elements).to_dict()


def _warm_up() -> None:
    """Reduce a made-up spectrum that has what real ones have: noise, peaks alone and in pairs."""
    import numpy as np

    wavelength = np.linspace(190.0, 950.0, 22_800)
    counts = 200 + np.random.default_rng(1).normal(0, 5, len(wavelength))
    for centre in (*np.arange(250.0, 800.0, 20.0), 250.3, 610.36, 670.78, 656.28, 766.49):
        counts += 4000 / (1 + ((wavelength - centre) / 0.08) ** 2)
    rows = (f"{x:.4f},{y:.1f}" for x, y in zip(wavelength, counts, strict=True))
    _reduce("\n".join(("wavelength,intensity", *rows)).encode(), None)
