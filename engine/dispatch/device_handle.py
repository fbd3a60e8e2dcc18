"""A device as the engine reaches it: over the wire in a run, in this process in a rehearsal."""

from collections.abc import Callable
from typing import Any, Protocol

from ...drivers.client.client import Outcome
from ...schemas.messages import Goal, GoalReport


class DeviceHandle(Protocol):
    """What the engine needs from a device's server."""

    boot: str
    ledger: str
    mark: str
    continues: bool
    on_stopped: Callable[[str, str], None] | None
    """Called with a device and who stopped it, when another client has."""
    on_touch: Callable[[], None] | None
    """Called when `in_touch` may have changed."""
    on_told: Callable[[], None] | None
    """Called when a device has told its status."""

    @property
    def in_touch(self) -> bool:
        """Whether its server is there and stays."""
        ...

    def newest_status(self, device: str) -> tuple[dict[str, Any], float]:
        """What a device told of itself when its driver last could, and when by the event loop."""
        ...

    def epoch(self, device: str) -> int:
        """The epoch of the lease that is held on a device."""
        ...

    def lapsed(self, device: str) -> int:
        """The epoch of the newest lease after which the device was made safe, or 0."""
        ...

    async def follow(
        self, goal: Goal, on_report: Callable[[GoalReport], None], *, send: bool = True
    ) -> Outcome:
        """Send a goal, or only ask about it, and wait for its end."""
        ...

    async def knows(self, goal_id: str) -> bool:
        """Whether its server ever had a goal; raises ServerUnreachable."""
        ...

    async def cancel(self, goal_id: str) -> None:
        """Cancel a goal."""
        ...

    async def take_lease(self, device: str, owner: str) -> int:
        """Take the lease again, which also ends the hold after a stop; raises LeaseHeld."""
        ...

    async def stop(self, device: str | None = None) -> dict[str, tuple[bool, str]]:
        """Bring a device to its safe state; device -> (confirmed, message)."""
        ...
