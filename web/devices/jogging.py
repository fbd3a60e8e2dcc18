"""Jogging: bounded steps, and holds with a dead-man's switch."""

import asyncio
from collections.abc import Callable
from typing import Any

from ...schemas.quantity import magnitude_in
from ...system.tasks import first_of, spawn
from ..access.headers import Deadline
from ..local.refusal import Refusal, not_found
from ..models.devices import Axis, GoalState, JogStart, JogState, JogStep
from .acting import Acting
from .arming import Arming
from .device_link import DeviceLink
from .form import Moving, moving_of
from .held import JOG, Held, OwnJog, jogging_by_itself, way_words
from .jog import Jog
from .stretched import Stretched
from .where import where_mm

KEPT = 20
REST_S = 6.0


class Jogging:
    """All holds, under way and recently ended; `changed` gets a hold's id."""

    def __init__(
        self, device_link: Callable[[str], DeviceLink], acting: Acting, arming: Arming,
        changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._device_link = device_link
        self._acting = acting
        self._arming = arming
        self._changed = changed
        self._jogs: dict[str, Jog] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def close(self) -> None:
        """Bring every axis to rest."""
        self.end_all("the server is stopping")
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=REST_S)

    def ids(self) -> list[str]:
        """Those of all holds."""
        return list(self._jogs)

    def known(self, id: str) -> JogState | None:
        """A hold, or None."""
        return self._jogs[id].state() if id in self._jogs else None

    async def step(
        self, device: str, asked: JogStep, by: str, key: str, deadline: Deadline
    ) -> GoalState:
        """One move from the present position; refused beyond the limits."""
        device_link, moving, jogging = self._ready(device, asked)
        if jogging is not None and device_link.status.get("homed") is False:
            # To get off a switch: an unhomed device itself limits its moves.
            return await self._step_by(device_link, jogging, asked, by, key, deadline)
        far: dict[Axis, float] = {asked.axis: asked.distance_mm}
        far |= {axis: sign * abs(asked.distance_mm) for axis, sign in asked.along.items()}
        for axis, distance_mm in far.items():
            if (edges := moving.ranges_mm.get(axis)) is None:
                continue
            target = where_mm(device_link, axis) + distance_mm
            if not edges[0] <= round(target, 6) <= edges[1]:
                words = (
                    f"{axis} would be at {target:.2f} mm, outside {edges[0]:g} to {edges[1]:g} mm"
                )
                raise Refusal(422, "LIMIT", words)
        if jogging is not None:
            return await self._step_by(device_link, jogging, asked, by, key, deadline)
        target = where_mm(device_link, asked.axis) + asked.distance_mm
        params: dict[str, Any] = {asked.axis: f"{round(target, 6)!r} mm"}
        if asked.feed_mm_min is not None and moving.feed_unit is not None:
            params["feed"] = magnitude_in(f"{asked.feed_mm_min!r} mm/min", moving.feed_unit)
        checked = self._acting.checked(device_link, moving.action, params)
        return await self._acting.do(device_link, moving.action, checked, by, key, deadline)

    async def _step_by(
        self, device_link: DeviceLink, jogging: OwnJog, asked: JogStep, by: str, key: str,
        deadline: Deadline,
    ) -> GoalState:  # fmt: skip
        """Move by a distance, which the device adds to its true position."""
        params: dict[str, Any] = {"axis": asked.axis, "distance": f"{asked.distance_mm!r} mm"}
        if asked.along:
            first = -1 if asked.distance_mm < 0 else 1
            params = {
                "way": way_words({asked.axis: first, **asked.along}),
                "distance": f"{abs(asked.distance_mm)!r} mm",
            }
        if asked.feed_mm_min is not None:
            params["feed"] = magnitude_in(f"{asked.feed_mm_min!r} mm/min", jogging.feed_unit)
        checked = self._acting.checked(device_link, JOG, params)
        return await self._acting.do(device_link, JOG, checked, by, key, deadline)

    async def start(self, device: str, asked: JogStart, by: str, deadline: Deadline) -> JogState:
        """Begin a hold; returns when the axis is moving."""
        device_link, moving, jogging = self._ready(device, asked)
        deadline.check()
        if jogging is not None:
            jog: Jog = Held(device_link, jogging, asked, by, self._changed)
        else:
            jog = Stretched(device_link, moving, asked, by, self._changed)
        begun: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        await device_link.take_turn()
        name = f"hold {jog.id} of {device}"
        task = spawn(name, jog.run(begun), expected=(Refusal,), among=self._tasks)
        self._remember(jog)
        await first_of((task, begun))
        if not begun.done():
            task.result()  # raises a refusal; without one, the axis was at its limit
        return jog.state()

    def beat(self, id: str, session: str | None = None) -> JogState:
        """Keep a hold alive; it ends when the first socket to do so closes."""
        jog = self._jogs.get(id)
        if jog is None:
            raise not_found("hold", id)
        if session is not None and jog.session is None:
            jog.session = session
        jog.beat()
        return jog.state()

    async def stop(self, id: str) -> JogState:
        """End a hold, and wait until the axis is at rest."""
        jog = self._jogs.get(id)
        if jog is None:
            raise not_found("hold", id)
        jog.end("let go")
        try:
            async with asyncio.timeout(REST_S):
                await jog.over.wait()
        except TimeoutError:
            raise Refusal(
                503, "NOT_AT_REST", f"{jog.device_link.name} did not come to rest within {REST_S:g} s",
                "use STOP ALL; if that is not confirmed, the hardware emergency stop",
            ) from None  # fmt: skip
        return jog.state()

    def session_closed(self, session: str) -> None:
        """A socket has closed: end its holds."""
        for jog in self._jogs.values():
            if jog.session == session:
                jog.end("the browser's connection closed")

    def end_all(self, reason: str) -> None:
        """End every hold, without waiting."""
        for jog in self._jogs.values():
            jog.end(reason)

    def _ready(
        self, device: str, asked: JogStep | JogStart
    ) -> tuple[DeviceLink, Moving, OwnJog | None]:
        device_link = self._device_link(device)
        moving = moving_of(device_link.contract, device_link.device.limits)
        for axis in (asked.axis, *asked.along):
            if moving is None or axis not in moving.axes:
                raise Refusal(422, "NO_AXIS", f"{device} has no axis {axis} that can be jogged")
        assert moving is not None
        self._arming.check_free(device)
        device_link.reachable_client()
        device_link.check_turn()
        jogging = jogging_by_itself(device_link, asked.axis)
        if jogging is None and asked.axis not in moving.ranges_mm:
            raise Refusal(422, "NO_AXIS", f"the ends of {device}'s axis {asked.axis} are not known")
        if asked.along and (asked.axis in asked.along or not (jogging and jogging.several)):
            words = f"{device} moves one axis at a time (gantry@2 moves several, each named once)"
            raise Refusal(422, "ONE_AXIS", words)
        return device_link, moving, jogging

    def _remember(self, jog: Jog) -> None:
        self._jogs[jog.id] = jog
        over = [id for id, one in self._jogs.items() if one.over.is_set()]
        for id in over[: max(0, len(over) - KEPT)]:
            del self._jogs[id]
            self._changed(id)
