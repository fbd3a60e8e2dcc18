"""One goal on its way through a driver, from acceptance to the word on how it ended."""

import asyncio
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ..schemas.contract import Action
from ..schemas.messages import FileContent, Goal, GoalError, GoalReport, GoalState
from .arguments import Arguments
from .driver import ActionCanceled, ActionFailed, Driver, GoalContext
from .ledger import NEVER_STARTED

CANCEL_GRACE_S = 3.0
"""How long a driver has to end by itself what was cancelled."""

FEEDBACK_PAUSE_S = 0.05
"""Feedback that comes faster is told as its newest word."""


@dataclass(frozen=True, slots=True)
class Ending:
    """How a goal ended: what goes into the ledger and over the wire."""

    state: GoalState
    result: dict[str, Any] | None = None
    error: GoalError | None = None
    files: dict[str, FileContent] = field(default_factory=dict)


class Execution:
    """A goal that a device server has accepted and that has not ended yet."""

    def __init__(
        self,
        goal: Goal,
        action: Action,
        state: GoalState,
        seq: int,
        boot: str,
        tell: Callable[["Execution"], None],
    ) -> None:
        self.goal = goal
        self.action = action
        self.state: GoalState = state
        self.seq = seq
        self.boot = boot
        self.followers: set[str] = set()
        self.progress: float | None = None
        self.message = ""
        self.context = GoalContext(goal.id, files=dict(goal.files), tell=self._feedback)
        self.task: asyncio.Task[None] | None = None
        self._tell = tell
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._interruptible = False
        self._kill_timer: asyncio.TimerHandle | None = None
        self._feedback_timer: asyncio.TimerHandle | None = None
        self._untold = False

    def report(self) -> GoalReport:
        """What can be told of it now."""
        return GoalReport(
            id=self.goal.id,
            state=self.state,
            seq=self.seq,
            boot=self.boot,
            progress=self.progress,
            message=self.message,
        )

    async def wait_for(self, gate: "asyncio.Task[Any]") -> bool:
        """Stay accepted until the gate opens; False where the goal was cancelled meanwhile."""
        if self.context.cancelled.is_set():
            return False
        self._interruptible = True
        try:
            await asyncio.wait({gate})
        except asyncio.CancelledError:
            self._forgive()
        finally:
            self._interruptible = False
        return not self.context.cancelled.is_set()

    async def perform(self, driver: Driver, arguments: Arguments) -> Ending:
        """Call the driver, and put into words whatever comes of it."""
        self._interruptible = True
        try:
            result = await getattr(driver, self.goal.action)(self.context, **self.goal.params)
            return self._answered(result, arguments)
        except ActionFailed as failure:
            happened = failure.happened or self.action.happened(failure.name)
            return _aborted(failure.name, failure.message, happened)
        except ActionCanceled:
            return Ending("CANCELED")
        except asyncio.CancelledError:
            return self._broken_off()
        except Exception as fault:  # a driver may be anybody's; what it raises is told, not obeyed
            return _fault(f"{arguments.place}: {type(fault).__name__}: {fault}")
        finally:
            self._interruptible = False
            self._forgive()
            self._stop_timers()

    def _answered(self, result: Any, arguments: Arguments) -> Ending:
        files = {n: f for n, f in self.context.files.items() if n in arguments.returned}
        wrong = arguments.fault_out(result, files)
        return _fault(wrong) if wrong is not None else Ending("SUCCEEDED", result, None, files)

    def _broken_off(self) -> Ending:
        if not self.context.cancelled.is_set():
            return _fault("the driver was cancelled by something inside itself")
        if self.action.cancel:
            return Ending("CANCELED")
        return _aborted(
            "Stopped", "a stop broke the action off; nobody saw how far it came", "unknown"
        )

    def _forgive(self) -> None:
        """The interruption was meant for the driver, not for the task that tells of it."""
        task = asyncio.current_task()
        while task is not None and task.cancelling():
            task.uncancel()

    def cancel(self) -> GoalState:
        """Ask the driver to end it; what its contract does not let cancel goes on to its end."""
        if self.action.cancel or self.state == "ACCEPTED":
            self.interrupt()
        return self.state

    def interrupt(self) -> None:
        """Tell the driver to end it, whatever the contract says, and break it off if it does not."""
        self.context.cancelled.set()
        if self.state == "ACCEPTED":
            self._kill()
        if self.action.cancel or self.state == "ACCEPTED":
            self.state = "CANCELING"
        if self._kill_timer is None:
            self._kill_timer = self._loop.call_later(CANCEL_GRACE_S, self._kill)
        self._tell(self)

    def _kill(self) -> None:
        if self.task is not None and self._interruptible:
            self.task.cancel()

    def _feedback(self, progress: float | None, message: str) -> None:
        if threading.get_ident() == self._thread:
            self._note(progress, message)
        else:
            self._loop.call_soon_threadsafe(self._note, progress, message)

    def _note(self, progress: float | None, message: str) -> None:
        if not self._interruptible:
            return  # a driver's thread that talks on after the action has ended
        self.progress = None if progress is None else float(progress)
        self.message = str(message)
        self._untold = True
        if self._feedback_timer is None:
            self._tell_feedback()

    def _tell_feedback(self) -> None:
        self._feedback_timer = None
        if self._untold:
            self._untold = False
            self._tell(self)
            self._feedback_timer = self._loop.call_later(FEEDBACK_PAUSE_S, self._tell_feedback)

    def _stop_timers(self) -> None:
        for timer in (self._kill_timer, self._feedback_timer):
            if timer is not None:
                timer.cancel()


def never_started() -> Ending:
    """The ending of a goal that was cancelled before its driver was called."""
    return Ending("CANCELED", error=NEVER_STARTED)


def not_begun(reason: str) -> Ending:
    """The ending of an accepted goal whose driver could not be called."""
    return _aborted("Rejected", f"{reason}; nothing was started", "no")


def _aborted(name: str, message: str, happened: Any) -> Ending:
    word = happened if happened in ("no", "yes") else "unknown"
    return Ending("ABORTED", error=GoalError(name=str(name), message=str(message), happened=word))


def _fault(message: str) -> Ending:
    return _aborted("Fault", message, "unknown")
