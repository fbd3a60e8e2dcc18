"""What all simulated devices have: a clock, a world, a log of the truth and injected faults.

Configuration that every one of them takes: `clock: real|fast|20` (20 times faster than real),
`seed`, `faults`.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from ....schemas.contracts import shipped_contracts
from ...driver import Driver, GoalContext, Place, check_keys
from ...world import World
from .clock import Clock
from .faults import Faults

SHARED = ("clock", "seed", "faults")


class Twin(Driver):
    """A driver without hardware; `options` are the names of its own configuration."""

    options: ClassVar[tuple[str, ...]] = ()
    without: ClassVar[str] = ""
    """The contract that it keeps where its place names none, if that is not its own."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.config: dict[str, Any] = place.config
        check_keys((*SHARED, *self.options), self.config)
        self.seed = int(self.config.get("seed", 1))
        self.clock = Clock(self.config.get("clock", "real"))
        contract = place.contract or shipped_contracts()[self.without or self.contract]
        self.faults = Faults(self.config.get("faults", {}), contract, self.seed)
        self.world = place.in_memory or World(place.world)
        self.truth = self.world.truth(place.device)

    async def open(self) -> None:
        self.truth.open()

    async def close(self) -> None:
        self.truth.close()

    @contextmanager
    def failing(self, action: str, goal: GoalContext) -> Iterator[None]:
        """Around the instant when the action happens: it fails before, after or not at all."""
        fault = self.faults.drawn(action, goal.id)
        if fault is not None and not fault.after:
            raise fault.failure()
        yield
        if fault is not None:
            raise fault.failure()
