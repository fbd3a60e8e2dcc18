"""Jogging: bounded steps, and holds that a dead-man ends."""

import asyncio
from collections.abc import Callable
from typing import Any

from ...schemas.quantity import magnitude_in
from ..guard.headers import Deadline
from ..guard.refusal import Refusal, not_found
from ..models.devices import GoalState, JogStart, JogState, JogStep
from .acting import Acting
from .arming import Arming
from .form import Moving, moving_of
from .held import JOG, Held, OwnJog, jogging_by_itself
from .jog import Jog
from .station import Station
from .stretched import Stretched
from .where import where_mm

KEPT = 20
REST_S = 6.0


class Jogging:
    """All holds, those under way and the last that ended; `changed` gets a hold's id."""

    def __init__(
        self, station: Callable[[str], Station], acting: Acting, arming: Arming,
        changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._station = station
        self._acting = acting
        self._arming = arming
        self._changed = changed
        self._jogs: dict[str, Jog] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def close(self) -> None:
        """Bring every axis to rest."""
        self.end_all("the server ends")
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=REST_S)

    def states(self) -> dict[str, JogState]:
        """All holds."""
        return {id: jog.state() for id, jog in self._jogs.items()}

    def known(self, id: str) -> JogState | None:
        """A hold, or None."""
        return self._jogs[id].state() if id in self._jogs else None

    async def step(
        self, device: str, asked: JogStep, by: str, key: str, deadline: Deadline
    ) -> GoalState:
        """One move from where the device stands; refused beyond the limits."""
        station, moving = self._ready(device, asked.axis)
        jogging = jogging_by_itself(station, asked.axis)
        if jogging is not None and station.status.get("homed") is False:
            # To get off a switch: the device itself bounds what it does before it knows its place.
            return await self._step_by(station, jogging, asked, by, key, deadline)
        low, high = moving.ranges_mm[asked.axis]
        target = where_mm(station, asked.axis) + asked.distance_mm
        if not low <= round(target, 6) <= high:
            raise Refusal(
                422, "LIMIT",
                f"{asked.axis} would be at {target:.2f} mm, outside {low:g} to {high:g} mm",
            )  # fmt: skip
        if jogging is not None:
            return await self._step_by(station, jogging, asked, by, key, deadline)
        params: dict[str, Any] = {asked.axis: f"{round(target, 6)!r} mm"}
        if asked.feed_mm_min is not None and moving.feed_unit is not None:
            params["feed"] = magnitude_in(f"{asked.feed_mm_min!r} mm/min", moving.feed_unit)
        checked = self._acting.checked(station, moving.action, params)
        return await self._acting.do(station, moving.action, checked, by, key, deadline)

    async def _step_by(
        self, station: Station, jogging: OwnJog, asked: JogStep, by: str, key: str,
        deadline: Deadline,
    ) -> GoalState:  # fmt: skip
        """By a distance, which the device adds to where it truly stands."""
        params: dict[str, Any] = {"axis": asked.axis, "distance": f"{asked.distance_mm!r} mm"}
        if asked.feed_mm_min is not None:
            params["feed"] = magnitude_in(f"{asked.feed_mm_min!r} mm/min", jogging.feed_unit)
        checked = self._acting.checked(station, JOG, params)
        return await self._acting.do(station, JOG, checked, by, key, deadline)

    async def start(self, device: str, asked: JogStart, by: str, deadline: Deadline) -> JogState:
        """Begin a hold; returns when the axis is on its way."""
        station, moving = self._ready(device, asked.axis)
        deadline.check()
        jogging = jogging_by_itself(station, asked.axis)
        if jogging is not None:
            jog: Jog = Held(station, jogging, asked, by, self._changed)
        else:
            jog = Stretched(station, moving, asked, by, self._changed)
        begun: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(jog.run(begun))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        self._remember(jog)
        await asyncio.wait({task, begun}, return_when=asyncio.FIRST_COMPLETED)
        if not begun.done():
            begun.cancel()
            task.result()  # a refusal; where there is none, the axis stood at its limit
        else:
            task.add_done_callback(_looked_at)
        return jog.state()

    def beat(self, id: str, session: str | None = None) -> JogState:
        """Keep a hold alive; the first socket that does is the one whose end ends it."""
        jog = self._jogs.get(id)
        if jog is None:
            raise not_found("hold", id)
        if session is not None and jog.session is None:
            jog.session = session
        jog.beat()
        return jog.state()

    async def stop(self, id: str) -> JogState:
        """End a hold, and wait until the axis stands."""
        jog = self._jogs.get(id)
        if jog is None:
            raise not_found("hold", id)
        jog.end("let go")
        try:
            async with asyncio.timeout(REST_S):
                await jog.over.wait()
        except TimeoutError:
            raise Refusal(
                503, "NOT_AT_REST", f"{jog.station.name} has not come to rest in {REST_S:g} s",
                "STOP ALL; if that is not confirmed, the hardware's emergency stop",
            ) from None  # fmt: skip
        return jog.state()

    def gone(self, session: str) -> None:
        """A socket has closed: what it held comes to rest."""
        for jog in self._jogs.values():
            if jog.session == session:
                jog.end("the browser's connection closed")

    def end_all(self, reason: str) -> None:
        """End every hold, without waiting."""
        for jog in self._jogs.values():
            jog.end(reason)

    def _ready(self, device: str, axis: str) -> tuple[Station, Moving]:
        station = self._station(device)
        moving = moving_of(station.contract, station.device.limits)
        if moving is None or axis not in moving.ranges_mm:
            raise Refusal(422, "NO_AXIS", f"{device} has no axis {axis} that can be jogged")
        self._arming.check_free(device)
        station.reached()
        if station.turn.locked():
            raise Refusal(409, "BUSY", f"{device} is busy with another action by hand")
        return station, moving

    def _remember(self, jog: Jog) -> None:
        self._jogs[jog.id] = jog
        over = [id for id, one in self._jogs.items() if one.over.is_set()]
        for id in over[: max(0, len(over) - KEPT)]:
            del self._jogs[id]
            self._changed(id)


def _looked_at(task: "asyncio.Task[None]") -> None:
    """A hold that fails after its start says so in its reason; its exception is not lost silently."""
    if not task.cancelled() and task.exception() is not None:
        import logging

        logging.getLogger(__name__).warning("a hold ended: %s", task.exception())
