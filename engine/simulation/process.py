"""A process within the simulation: its tasks die at once, and what is left of them does nothing."""

import asyncio
from collections.abc import Coroutine
from contextvars import ContextVar, copy_context
from typing import Any

from ...system.tasks import spawn
from ..run.virtual_time import VirtualLoop

ROUNDS = 100


class Died(BaseException):
    """Raised where a process that is dead would still touch its disk, the wire or an instrument."""


class Process:
    """An engine, or a device server: whatever is started within it belongs to it."""

    def __init__(self) -> None:
        self.alive = True
        self.tasks: dict[asyncio.Task[Any], None] = {}  # in their order, so that a seed tells all

    def check(self) -> None:
        """Raise Died unless it lives."""
        if not self.alive:
            raise Died

    def spawn(self, name: str, work: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        """Start work within it."""
        context = copy_context()
        context.run(CURRENT.set, self)
        return context.run(spawn, name, work, expected=(Died,))

    def kill(self) -> None:
        """End it, as SIGKILL does: nothing that it would still do has an effect."""
        self.alive = False
        for task in list(self.tasks):
            task.cancel()

    async def bury(self) -> None:
        """Wait until nothing of it is left."""
        for _ in range(ROUNDS):
            if not self.tasks:
                return
            self.kill()
            await asyncio.sleep(0)
        raise AssertionError(f"what does not die: {self.tasks}")


CURRENT: ContextVar[Process | None] = ContextVar("CURRENT", default=None)


def living() -> Process:
    """The process that calls; raises Died where it is dead."""
    process = CURRENT.get()
    assert process is not None
    process.check()
    return process


class SimulatedLoop(VirtualLoop):
    """A loop that knows to which process a task belongs, and calls `strike` after so many rounds."""

    def __init__(self) -> None:
        super().__init__(longest_real_s=0)
        self.rounds = 0
        self.strike_at = 0
        self.set_task_factory(_task)

    def strike(self) -> None:
        """Something happens between two awaits."""

    def _run_once(self) -> None:
        self.rounds += 1
        if self.rounds == self.strike_at:
            self.strike()
        super()._run_once()  # pyright: ignore[reportAttributeAccessIssue] - asyncio's own


def _task(loop: asyncio.AbstractEventLoop, work: Any, **more: Any) -> asyncio.Task[Any]:
    task = asyncio.Task(work, loop=loop, **more)
    process = CURRENT.get()
    if process is not None:
        process.tasks[task] = None
        task.add_done_callback(lambda done: process.tasks.pop(done, None))
    return task
