"""One goal's execution by a driver, from acceptance to outcome."""

import asyncio
import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

from ...schemas.contract import Action
from ...schemas.messages import FileContent, Goal, GoalError, GoalReport, GoalState
from ...system.extras import in_words
from ..driver import ActionCanceled, ActionFailed, Driver, GoalContext
from .arguments import Arguments
from .ledger import NEVER_STARTED

FEEDBACK_PAUSE_S = 0.05
"""Of faster feedback only the latest is sent."""

LOG = logging.getLogger("labrun")


@dataclass(frozen=True, slots=True)
class Ending:
    """How a goal ended: what goes into the ledger and over the wire."""

    state: GoalState
    result: dict[str, Any] | None = None
    error: GoalError | None = None
    files: dict[str, FileContent] = field(default_factory=dict)

    def report(self, goal_id: str, boot: str, seq: int = 0) -> GoalReport:
        """The last report on its goal; raises ValidationError for what a report cannot hold."""
        return GoalReport(
            id=goal_id, state=self.state, seq=seq, boot=boot, result=self.result,
            error=self.error, files=self.files,
        )  # fmt: skip


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
        cancel_grace_s: float,
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
        self.turn: asyncio.Future[bool] | None = None
        self.over = False
        self.outcome: GoalReport | None = None
        self.cut: tuple[str, str] | None = None
        self._tell = tell
        self._cancel_grace_s = cancel_grace_s
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._interruptible = False
        self._kill_timer: asyncio.TimerHandle | None = None
        self._feedback_timer: asyncio.TimerHandle | None = None
        self._deadline: asyncio.TimerHandle | None = None
        self._expired = False
        if goal.timeout_s is not None:
            self._deadline = self._loop.call_later(goal.timeout_s, self._expire)
        self._untold = False

    def report(self) -> GoalReport:
        """The current report on it."""
        if self.outcome is not None:
            return self.outcome
        return GoalReport(
            id=self.goal.id,
            state=self.state,
            seq=self.seq,
            boot=self.boot,
            progress=self.progress,
            message=self.message,
        )

    @property
    def acts(self) -> bool:
        """Its code may act on the device: from the owner's word until it has returned."""
        return self.turn is not None and self.turn.done() and self.turn.result()

    @property
    def is_cancelled(self) -> bool:
        """Somebody, or its deadline, wants it to end."""
        return self.context.cancelled.is_set()

    def let_begin(self, may: bool) -> None:
        """The owner's word, if it still waits for one."""
        if self.turn is not None and not self.turn.done():
            self.turn.set_result(may)

    async def perform(self, driver: Driver, arguments: Arguments) -> Ending:
        """Call the driver, and turn whatever it does into an ending."""
        self._interruptible = True
        try:
            result = await driver.method(self.goal.action)(self.context, **self.goal.params)
            return self._answered(result, arguments)
        except ActionFailed as failure:
            happened = failure.happened or self.action.happened(failure.name)
            if happened == "unknown" and failure.__cause__ is not None:
                LOG.warning("%s: %s", arguments.place, failure, exc_info=failure)
            return _aborted(failure.name, failure.message, happened)
        except ActionCanceled:
            return Ending("CANCELED")
        except asyncio.CancelledError:
            return self._broken_off()
        except (Exception, SystemExit) as fault:  # a driver may be third-party code
            return fault_of(arguments.place, fault)
        finally:
            self._interruptible = False
            self._forgive()
            self._stop_timers()

    def _answered(self, result: Any, arguments: Arguments) -> Ending:
        files = {n: f for n, f in self.context.files.items() if n in arguments.returned}
        wrong = arguments.fault_out(result, files)
        return _fault(wrong) if wrong is not None else Ending("SUCCEEDED", result, None, files)

    def _broken_off(self) -> Ending:
        if not self.is_cancelled:
            return _fault("the driver was cancelled from within")
        if self.action.cancel:
            return Ending("CANCELED")
        return _aborted(
            "Stopped", "a stop aborted the action; how far it got is unknown", "unknown"
        )

    def _forgive(self) -> None:
        """The interruption was meant for the driver, not for the task that reports it."""
        task = asyncio.current_task()
        while task is not None and task.cancelling():
            task.uncancel()

    def finish(self, ending: Ending, place: str) -> Ending:
        """It is over; where its deadline has cancelled it, that is how it ended."""
        self.over = True
        self._stop_timers()
        if not self._expired or ending.state != "CANCELED":
            return ending
        words = f"{place} took longer than {self.goal.timeout_s:g} s"
        if ending.error is NEVER_STARTED:
            return _aborted("Timeout", f"{words}, and had not begun", "no")
        return _aborted("Timeout", words, "unknown")

    def _expire(self) -> None:
        if not self.is_cancelled:
            self.cancel()
            self._expired = self.is_cancelled

    def cancel(self) -> GoalState:
        """Ask the driver to end it; an action that its contract does not let cancel runs to its end."""
        if self.action.cancel or self.state == "ACCEPTED":
            self.interrupt()
        return self.state

    def interrupt(self) -> None:
        """Make the driver end it, whatever the contract says, and abort it if it does not."""
        if self.over:
            return
        self.context.cancelled.set()
        self.let_begin(False)
        if self.action.cancel or self.state == "ACCEPTED":
            self.state = "CANCELING"
        if self._kill_timer is None:
            self._kill_timer = self._loop.call_later(self._cancel_grace_s, self._kill)
        self._tell(self)

    def cut_by(self, name: str, words: str) -> None:
        """End it because of a stop or a lost lease; its outcome says so, however it ends."""
        if self.cut is None and not (self.over or self.context.cancelled.is_set()):
            self.cut = name, words
        self.interrupt()

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
            return  # a driver's thread that still reports after the action has ended
        self.progress = None if progress is None or not isfinite(progress) else float(progress)
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
        for timer in (self._kill_timer, self._feedback_timer, self._deadline):
            if timer is not None:
                timer.cancel()


def cut_short(ending: Ending, cut: tuple[str, str]) -> Ending:
    """The ending of a goal that a stop met: also a success, whose result may not be worth much."""
    name, words = cut
    if ending.state == "SUCCEEDED":
        error = GoalError(name=name, message=f"{words} while the action ran", happened="yes")
    elif ending.error is None:
        error = GoalError(name=name, message=words, happened="unknown")
    else:
        own = ending.error
        own_words = "" if own.name in (name, NEVER_STARTED.name) else f"; {own.name}: {own.message}"
        error = GoalError(name=name, message=f"{words}{own_words}", happened=own.happened)
    return replace(ending, error=error)


def never_started(*, cancelled: bool) -> Ending:
    """The ending of a goal that was cancelled, or whose lease was over, before it could begin."""
    return Ending("CANCELED" if cancelled else "ABORTED", error=NEVER_STARTED)


def not_begun(reason: str) -> Ending:
    """The ending of an accepted goal whose driver could not be called."""
    return _aborted("Rejected", f"{reason}; nothing was started", "no")


def _aborted(name: str, message: str, happened: Any) -> Ending:
    word = happened if happened in ("no", "yes") else "unknown"
    return Ending("ABORTED", error=GoalError(name=str(name), message=str(message), happened=word))


def fault_of(place: str, fault: BaseException) -> Ending:
    """The ending of a goal whose driver, or server, has failed where no error was foreseen."""
    LOG.error("%s", place, exc_info=fault)
    words = f"{place}: {in_words(fault)}"
    return _fault(words.encode(errors="backslashreplace").decode())


def _fault(message: str) -> Ending:
    return _aborted("Fault", message, "unknown")
