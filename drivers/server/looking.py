"""A look with a camera between its goals: nobody has to hold it, and nothing of it is kept."""

import asyncio
from collections.abc import Callable

from ...schemas.contract import Contract
from ...schemas.messages import BenchPlace, Look
from ...system.extras import in_words
from ...system.tasks import spawn
from ..driver import ActionFailed, Driver, GoalContext
from .lease import Refused


class Looking:
    """Takes pictures with one device, one at a time; all who ask during a look get the same one.

    `in_use` says who uses the device, and is empty if nobody does.
    """

    def __init__(
        self, name: str, driver: Driver, contract: Contract, in_use: Callable[[], str]
    ) -> None:
        self._name = name
        self._driver = driver
        self._how = contract.look()
        self._look_s = contract.look_s()
        self._sees_above = contract.looks_from_above()
        self._in_use = in_use
        self._looks = 0
        self._from_above = False
        self.task: asyncio.Task[Look] | None = None

    async def look(self, above: bool = False) -> Look:
        """What the device sees now, or as seen from straight above; raises Refused."""
        if self._how is None:
            raise Refused("INVALID", f"{self._name} takes no pictures")
        if above and not self._sees_above:
            raise Refused("INVALID", f"{self._name} takes no pictures from above")
        loop = asyncio.get_running_loop()
        until = loop.time() + self._look_s
        if above != self._from_above:
            await self.over()
        if self.task is None or self.task.done():
            if used := self._in_use():
                raise Refused("HELD", used)
            self._from_above = above
            self.task = spawn(
                f"look with {self._name}", self._look(*self._how, above), expected=(Refused,)
            )
        done, _ = await asyncio.wait({self.task}, timeout=max(0.0, until - loop.time()))
        if not done or self.task.cancelled():
            raise Refused("REJECTED", f"{self._name} gave no picture within {self._look_s:g} s")
        return self.task.result()

    async def over(self) -> None:
        """Wait for the end of a look: a camera does one thing at a time."""
        if self.task is not None and not self.task.done():
            await asyncio.wait({self.task}, timeout=self._look_s)

    async def _look(self, action: str, file: str, above: bool) -> Look:
        self._looks += 1
        context = GoalContext(f"look-{self._looks}")
        params = {file: "picture.png", "above": True} if above else {file: "picture.jpg"}
        try:
            told = await self._driver.method(action)(context, **params)
            edges = {edge: told.get(edge) for edge in BenchPlace.model_fields} if above else {}
            place = BenchPlace.model_validate(edges) if above else None
        except ActionFailed as fault:
            raise Refused("REJECTED", f"{self._name} gives no picture: {fault.message}") from fault
        except Exception as fault:  # a driver may be third-party code
            words = str(fault) if isinstance(fault, OSError) else in_words(fault)
            raise Refused("REJECTED", f"{self._name} gives no picture: {words}") from fault
        picture = context.files.get(file)
        if picture is None:
            raise Refused("REJECTED", f"{self._name} gives no picture: it sent none along")
        return Look(file=picture, place=place)
