"""The way into a device's safe state: one at a time, with an answer that can be trusted."""

import asyncio
from collections.abc import Callable

from ..schemas.contract import Contract
from .driver import Driver, GoalContext


class Safety:
    """Brings one device into its safe state; who asks while it is under way shares its answer."""

    def __init__(
        self, device: str, driver: Driver, contract: Contract, changed: Callable[[], None]
    ) -> None:
        self.device = device
        self.under_way: asyncio.Task[tuple[bool, str]] | None = None
        self._driver = driver
        self._contract = contract
        self._changed = changed

    def begin(self) -> "asyncio.Task[tuple[bool, str]]":
        """Call the driver now; the task's result says whether it confirmed, and in words."""
        if self.under_way is None:
            self.under_way = asyncio.create_task(self._make_safe())
            self.under_way.add_done_callback(self._over)
        return self.under_way

    async def confirmed(self, timeout_s: float) -> tuple[bool, str]:
        """Begin, and wait for the driver's word; it goes on trying when we wait no longer."""
        task = self.begin()
        done, _ = await asyncio.wait({task}, timeout=timeout_s)
        if not done:
            return False, f"{self.device} did not confirm its safe state within {timeout_s:g} s"
        return task.result()

    async def close(self, timeout_s: float) -> None:
        """Leave no task behind."""
        if self.under_way is not None:
            self.under_way.cancel()
            await asyncio.wait({self.under_way}, timeout=timeout_s)

    def _over(self, _: "asyncio.Task[tuple[bool, str]]") -> None:
        self.under_way = None
        self._changed()

    async def _make_safe(self) -> tuple[bool, str]:
        try:
            if type(self._driver).safe is not Driver.safe:
                await self._driver.safe()
            else:
                for action in self._contract.safe_state:
                    await getattr(self._driver, action)(GoalContext(f"safe:{action}"))
        except Exception as fault:  # whatever it is, the device is then not known to be safe
            return False, f"{self.device} may not be safe: {type(fault).__name__}: {fault}"
        return True, f"{self.device} is in its safe state"
