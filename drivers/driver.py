"""A driver makes one kind of hardware, or its simulated twin, keep a contract."""

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from ..schemas.contract import Contract, Happened
from ..schemas.messages import FileContent


class ActionFailed(Exception):
    """The action ended with an error of its contract: raised by drivers, told to the engine.

    `happened` says whether the action took effect all the same; where it is None the contract's
    word for this error holds.
    """

    def __init__(self, name: str, message: str, happened: Happened | None = None) -> None:
        super().__init__(f"{name}: {message}")
        self.name = name
        self.message = message
        self.happened = happened


class ActionCanceled(Exception):
    """The action stopped because its goal was cancelled."""


@dataclass(slots=True)
class GoalContext:
    """What a driver's action sees of the goal it serves.

    `wanted_at` (of `time.monotonic()`) is when its sender last sent it: the same goal sent again
    says that it is still wanted, which is how somebody holds an action that must not outlive the
    hold, such as a jog.
    """

    id: str
    wanted_at: float = field(default_factory=time.monotonic)
    cancelled: asyncio.Event = field(default_factory=asyncio.Event)
    files: dict[str, FileContent] = field(default_factory=dict)
    tell: Callable[[float | None, str], None] = lambda progress, message: None

    def feedback(self, progress: float | None = None, message: str = "") -> None:
        """Tell the engine how far it is (0..1) and in words; also the proof of being alive."""
        self.tell(progress, message)


@dataclass(frozen=True, slots=True)
class Place:
    """Where a driver lives: its device's name, its configuration, folders of its own.

    `contract` is what the device has to keep; None where a driver is used without a server.
    """

    device: str
    config: dict[str, Any]
    limits: dict[str, tuple[float | None, float | None]]
    folder: Path
    world: Path
    contract: Contract | None = None


class Driver:
    """One async method an action, `status()` and `safe()`.

    An action is `async def move_to(self, goal, *, x=None, y=None) -> dict`: `goal` is a
    GoalContext, the parameters are numbers in the contract's units, the answer is the contract's
    `returns`. A file that the action returns is the name it was asked for; its content is put
    into `goal.files` under the name of the result.
    """

    contract: ClassVar[str]
    any_contract: ClassVar[bool] = False
    """True where the lab's `config` says how a contract is kept, whichever it is."""
    versions: dict[str, str] = {}  # noqa: RUF012 - replaced by what the hardware says, never changed

    def __init__(self, place: Place) -> None:
        self.place = place

    async def open(self) -> None:
        """Reach the hardware; raises OSError with a sentence where it cannot be reached."""

    async def close(self) -> None:
        """Let go of the hardware."""

    async def status(self) -> dict[str, Any]:
        """The contract's `status`, as it is now."""
        return {}

    async def safe(self) -> None:
        """Bring the device into its safe state, whatever it does."""
