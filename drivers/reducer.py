"""Offers spectrum reduction as a device, so that it may run on another machine."""

import asyncio
import os
from collections.abc import Callable
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
        calibration: str | None = None, closure: str | None = None, response: str | None = None,
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
            known = _text(goal, "calibration", calibration), _text(goal, "response", response)
            loop = asyncio.get_running_loop()
            return await loop.run_in_executor(
                self._threads, _reduce, source, elements, *known, closure
            )
        except _WrongFile as fault:
            path = calibration if fault.of == "calibration" else response
            raise ActionFailed(f"Wrong{fault.of.capitalize()}", f"{path}: {fault}") from fault
        except (OSError, ValueError) as fault:
            raise ActionFailed("Unreadable", f"{spectrum}: {fault}") from fault


def most_at_once() -> int:
    """One per core, up to a few: more at a time would only use more memory."""
    return max(1, min(os.cpu_count() or 1, MOST_AT_ONCE))


class _WrongFile(Exception):
    """The text says why. of: calibration or response."""

    def __init__(self, of: str, why: str) -> None:
        super().__init__(why)
        self.of = of


def _text(goal: GoalContext, of: str, path: str | None) -> str | None:
    if path is None:
        return None
    sent = goal.files.get(of)
    try:
        return (Path(path).read_bytes() if sent is None else sent.data).decode("utf-8-sig")
    except OSError as fault:
        raise _WrongFile(of, fault.strerror or str(fault)) from fault
    except UnicodeDecodeError:
        raise _WrongFile(of, "it is not text") from None


def _reduce(
    source: str | bytes, elements: list[str] | None, calibration: str | None, response: str | None,
    closure: str | None,
) -> dict[str, Any]:  # fmt: skip
    reduction = import_module(REDUCTION)
    seen: Callable[[Any], Any] = _as_it_is
    known: Any = closure
    files: dict[str, str] = {}
    if response is not None:
        room = import_module(f"{REDUCTION}.spectrum.response")
        try:
            seen = room.read_response(response).divided_out
        except room.ResponseFault as fault:
            raise _WrongFile("response", str(fault)) from fault
        files["response_sha256"] = sha256(response.encode()).hexdigest()
    if calibration is None and closure is None:
        found = reduction.reduce_spectrum(seen(reduction.read_spectrum(source)), elements)
        return {**found.to_dict(), **files}
    shots = reduction.read_shots(source)
    if calibration is not None:
        room = import_module(f"{REDUCTION}.calibration.calibration")
        try:
            known = room.read_calibration(calibration)
        except room.CalibrationFault as fault:
            raise _WrongFile("calibration", str(fault)) from fault
        if why := known.other_response(files.get("response_sha256"), "response"):
            raise _WrongFile("calibration", f"it was made {why}")
        if other := known.other_axis(shots.wavelength_nm):
            raise _WrongFile("calibration", f"it was made with another instrument: {other}")
        files["calibration_sha256"] = sha256(calibration.encode()).hexdigest()
    reduce_shots = import_module(f"{REDUCTION}.calibration.reduced_shots").reduce_shots
    return {**reduce_shots(shots, known, elements, seen=seen).to_dict(elements), **files}


def _as_it_is(spectrum: Any) -> Any:
    return spectrum


def _warm_up() -> None:
    import_module(f"{REDUCTION}.warm_up").warm_up()
