"""A driver makes one kind of hardware, or its simulated twin, keep a contract."""

import asyncio
import time
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from ..schemas.contract import Contract, Happened
from ..schemas.messages import FileContent
from ..system.extras import missing

if TYPE_CHECKING:
    from pydantic import ValidationError

    from .world import World


class ActionFailed(Exception):
    """The action ended with an error of its contract: raised by drivers, reported to the engine.

    `happened` says whether the action took effect all the same; if it is None, the contract's
    value for this error applies.
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
    """What a driver's action sees of its goal.

    `wanted_at` (of `time.monotonic()`) is when its sender last sent it: sending the same goal again
    means that it is still wanted, which is how a client holds an action that must not outlive the
    hold, such as a jog.
    """

    id: str
    wanted_at: float = field(default_factory=time.monotonic)
    cancelled: asyncio.Event = field(default_factory=asyncio.Event)
    files: dict[str, FileContent] = field(default_factory=dict)
    tell: Callable[[float | None, str], None] = lambda progress, message: None

    def feedback(self, progress: float | None = None, message: str = "") -> None:
        """Report progress (0..1) and a message to the engine; also serves as a sign of life."""
        self.tell(progress, message)


@dataclass(frozen=True, slots=True)
class Place:
    """A driver's surroundings: its device's name, its configuration, its own folders.

    `contract` is what the device has to keep; None if a driver is used without a server. `in_memory` is
    what a rehearsal has in place of what twins write into `world`.
    """

    device: str
    config: dict[str, Any]
    limits: dict[str, tuple[float | None, float | None]]
    folder: Path
    world: Path
    contract: Contract | None = None
    in_memory: "World | None" = None


class Misfit(ValueError):
    """A config does not fit its driver; `path` leads to the first thing in it that does not."""

    def __init__(self, words: str, path: Sequence[str | int]) -> None:
        super().__init__(words)
        self.path = path


class UnknownKey(Misfit):
    """A config says what its driver does not know; `path` leads to the first such key in it."""


def check_keys(
    known: Collection[str],
    given: Iterable[str],
    what: str = "config",
    at: Sequence[str | int] | None = None,
) -> None:
    """Raise UnknownKey for a key that is given and not known, with the one that it looks like.

    `at` leads to the keys in the config, where `what` is not their place (`status.qos`) itself.
    """
    unknown = sorted(set(given) - set(known))
    if not unknown:
        return
    from difflib import get_close_matches  # not at the top: most labs have no mistyped keys

    if at is None:
        at = () if what == "config" else what.split(".")
    near = get_close_matches(unknown[0].casefold(), known, n=1)
    guess = f"; perhaps {near[0]} is meant" if near else ""
    raise UnknownKey(
        f"{what} has no key {', '.join(unknown)}; its keys are: {', '.join(known) or 'none'}{guess}",
        (*at, unknown[0]),
    )


def misfit(fault: "ValidationError", *at: str) -> Misfit:
    """The first thing in a config, or in the part of it at `at`, that does not fit its model."""
    first = fault.errors()[0]
    path = *at, *first["loc"]
    place = ".".join(("config", *map(str, path)))
    words = f"{place} is missing" if first["type"] == "missing" else f"{place}: {first['msg']}"
    return (UnknownKey if first["type"] == "extra_forbidden" else Misfit)(words, path)


class Driver:
    """One async method per action, `status()` and `safe()`.

    An action is `async def move_to(self, goal, *, x=None, y=None) -> dict`: `goal` is a
    GoalContext, the parameters are numbers in the contract's units, the return value is the
    contract's `returns`. A returned file is given by the name that was requested; its content goes
    into `goal.files` under the name of the result.
    """

    contract: ClassVar[str]
    any_contract: ClassVar[bool] = False
    """True if the lab's `config` defines how a contract is kept, whichever contract it is."""
    extra: ClassVar[str | None] = None
    """The extra of labrun (`system/extras.py`) without which it cannot work."""
    alone: str = ""
    """What only one device server at a time may use, as each of them calls it: an address."""
    versions: dict[str, str] = {}  # noqa: RUF012 - replaced by what the hardware reports, never mutated

    def __init__(self, place: Place) -> None:
        self.place = place

    @classmethod
    def lacks(cls, config: dict[str, Any]) -> str | None:
        """What is not installed here that it needs with this config, and the line that adds it."""
        return missing(cls.extra) if cls.extra is not None else None

    def method(self, action: str) -> Any:
        """What does an action: the method of its name."""
        return getattr(self, action)

    async def open(self) -> None:
        """Connect to the hardware; raises OSError with the reason if that fails."""

    async def close(self) -> None:
        """Release the hardware."""

    async def status(self) -> dict[str, Any]:
        """The current values of the contract's `status`."""
        return {}

    async def safe(self) -> None:
        """Bring the device into its safe state, whatever it is doing."""
