"""Offers spectrum reduction as a device, so that it may run on another machine."""

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar

from .driver import ActionFailed, Driver, GoalContext, Place, check_keys

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
        check_keys((), place.config)
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
        self, goal: GoalContext, *, spectrum: str, elements: list[str] | None = None,
        calibration: str | None = None, closure: str | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        if self._warming is not None and not self._warming.done():
            # Only one thread imports and compiles: two could deadlock, one with numba's lock, one
            # with Python's lock on a module that is being imported.
            goal.feedback(message="compiling the fits, on first use only")
            await asyncio.wait([self._warming])
        if calibration is not None and closure is not None:
            raise ActionFailed(
                "WrongCalibration",
                "closure is without standards, calibration by them: leave one out",
            )
        sent = goal.files.get("spectrum")
        source = spectrum if sent is None else sent.data
        try:
            known = None if calibration is None else _text(goal, calibration)
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(
                self._threads, _reduce, source, elements, known, closure
            )
        except _WrongCalibration as fault:
            raise ActionFailed("WrongCalibration", f"{calibration}: {fault}") from fault
        except (OSError, ValueError) as fault:
            raise ActionFailed("Unreadable", f"{spectrum}: {fault}") from fault


def most_at_once() -> int:
    """One per core, up to a few: more at a time would only use more memory."""
    return max(1, min(os.cpu_count() or 1, MOST_AT_ONCE))


class _WrongCalibration(Exception):
    """The text says why."""


def _text(goal: GoalContext, path: str) -> str:
    sent = goal.files.get("calibration")
    try:
        return (Path(path).read_bytes() if sent is None else sent.data).decode("utf-8-sig")
    except OSError as fault:
        raise _WrongCalibration(fault.strerror or str(fault)) from fault
    except UnicodeDecodeError:
        raise _WrongCalibration("it is not text") from None


def _reduce(
    source: str | bytes, elements: list[str] | None, calibration: str | None, closure: str | None
) -> dict[str, Any]:
    reduction = import_module(REDUCTION)
    if calibration is None and closure is None:
        return reduction.reduce_spectrum(reduction.read_spectrum(source), elements).to_dict()
    shots = reduction.read_shots(source)
    reduce_shots = import_module(f"{REDUCTION}.calibration.reduced_shots").reduce_shots
    if calibration is None:
        return reduce_shots(shots, closure, elements).to_dict(elements)
    room = import_module(f"{REDUCTION}.calibration.calibration")
    try:
        known = room.read_calibration(calibration)
    except room.CalibrationFault as fault:
        raise _WrongCalibration(str(fault)) from fault
    if known.card.response_sha256 is not None:
        raise _WrongCalibration(
            "it was made with a --response, which a run does not divide out; make one without, or use "
            "it with `labrun reduce` after the run"
        )
    if other := known.other_axis(shots.wavelength_nm):
        raise _WrongCalibration(f"it was made with another instrument: {other}")
    found = reduce_shots(shots, known, elements).to_dict(elements)
    return {**found, "calibration_sha256": sha256(calibration.encode()).hexdigest()}


def _warm_up() -> None:
    import_module(f"{REDUCTION}.warm_up").warm_up()
