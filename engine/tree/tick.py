"""Tick a tree until it ends: results in, tick to quiescence, journal, goals out, then wait.

Nothing here is periodic: a round starts when a result, a person or a deadline requires it.
"""

import asyncio
import contextlib
from typing import Literal

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ..control.control import Control
from ..dispatch.dispatcher import Dispatcher
from ..journal.journal import DiskFull
from ..run.files import NoRoom
from ..run.run import Run

DRAIN_S = 120.0
"""How long goals may take to end after they were cancelled, before the run continues without them; longer
where a contract's `cancel_grace` says so."""

QUIET_S = 60.0
"""After so long without any news, and longer than what is under way should take, a run says what it
waits for."""

CLOCK_STEP_S = 1e-6
"""No wait is shorter: what is due within the clock's own rounding would be waited for again, at once
and without end where time stands still between two rounds."""

Ended = Literal["succeeded", "failed", "aborted", "state lost", "changed"]


class StopNow(Exception):
    """A second abort: wait for nothing more."""


async def run_tree(
    root: Behaviour, run: Run, dispatcher: Dispatcher, control: Control, *, abortable: bool,
    watchful: bool = False,
) -> Ended:  # fmt: skip
    """Run a tree to its end, or stop it for an abort; every goal has ended when this returns.

    `watchful`: stop it also when a device has lost the state that earlier steps gave it, a person goes
    on after a pause that the stop of a device has brought, or the protocol is to be changed.
    Raises StopNow for a second abort and NoRoom when the disk is full.
    """
    dispatcher.heeds_stops = watchful
    try:
        return await _rounds(root, run, dispatcher, control, abortable=abortable, watchful=watchful)
    except BaseException:  # whatever it was, the tree is ticked no more: its goals are cancelled
        root.stop(Status.INVALID)
        dispatcher.withdraw_all()
        raise
    finally:
        dispatcher.heeds_stops = False


async def _rounds(
    root: Behaviour, run: Run, dispatcher: Dispatcher, control: Control, *, abortable: bool,
    watchful: bool,
) -> Ended:  # fmt: skip
    paused_for: set[str] = set()
    while True:
        if control.now:
            raise StopNow
        dispatcher.wake.clear()
        dispatcher.apply()
        if dispatcher.disk_full:
            raise NoRoom(dispatcher.disk_full)
        if abortable and control.aborted_by:
            root.stop(Status.INVALID)
            dispatcher.withdraw_all()
            await _drain(dispatcher, control)
            return "aborted"
        goes_on = await _heed_stops(dispatcher, control, paused_for)
        if watchful and (goes_on or run.requests.take_up or dispatcher.states_lost()):
            root.stop(Status.INVALID)
            dispatcher.withdraw_all()
            await _drain(dispatcher, control)
            return "state lost"
        if watchful and control.change_due(dispatcher.busy):
            root.stop(Status.INVALID)
            dispatcher.withdraw_all()
            await _drain(dispatcher, control)
            return "changed"
        again, wake_at, look_at = _round(root, run, dispatcher, control)
        if root.status != Status.RUNNING:
            await _drain(dispatcher, control)  # what was cancelled before has ended, too
            return "succeeded" if root.status == Status.SUCCESS else "failed"
        if again or dispatcher.has_arrived():
            await asyncio.sleep(0)
        else:
            await _wait(run, dispatcher, wake_at, look_at)


async def _heed_stops(dispatcher: Dispatcher, control: Control, paused_for: set[str]) -> bool:
    """Pause for every device that was stopped; True once a person has gone on, and nothing runs."""
    new = dispatcher.stopped.keys() - paused_for
    if new:
        paused_for |= new
        who = "; ".join(dispatcher.stopped[device] for device in sorted(new))
        if control.paused:
            dispatcher.run.log(who)
        control.ask("pause", f"{who}; `labrun continue` goes on")
    if not dispatcher.stopped or control.paused or control.aborted_by or dispatcher.busy:
        return False
    why_not = await dispatcher.take_stopped_again()
    if why_not:
        control.ask("pause", why_not)
    return not why_not


def _round(
    root: Behaviour, run: Run, dispatcher: Dispatcher, control: Control
) -> tuple[bool, float | None, float | None]:
    root.tick_once()
    dispatcher.check_time()
    if run.requests.pause and not control.paused and not control.aborted_by:
        control.ask("pause", run.requests.pause)
    dispatcher.paused = control.paused or (dispatcher.heeds_stops and bool(dispatcher.stopped))
    ready = dispatcher.prepare()
    try:
        run.journal.flush()
    except DiskFull as fault:
        raise NoRoom(str(fault)) from fault
    dispatcher.send(ready)
    return run.requests.take_round()


async def _wait(
    run: Run, dispatcher: Dispatcher, wake_at: float | None, look_at: float | None
) -> None:
    handle, loop = None, asyncio.get_running_loop()
    at = [] if look_at is None else [look_at]
    if wake_at is not None and not dispatcher.paused:
        at.append(loop.time() + max(CLOCK_STEP_S, wake_at - run.clock.now()))
    if at:
        handle = loop.call_at(min(at), dispatcher.wake.set)
    if not at or min(at) > loop.time() + QUIET_S:
        await _wait_long(run, dispatcher, for_a_time=wake_at is not None)
    await dispatcher.wake.wait()
    if handle is not None:
        handle.cancel()


async def _wait_long(run: Run, dispatcher: Dispatcher, *, for_a_time: bool) -> None:
    """Wait until it is woken, and say from time to time what for."""
    patience_s = max(QUIET_S, dispatcher.longest_s())
    while True:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(patience_s):
                await dispatcher.wake.wait()
                return
        calls = [f"the function {name}" for name in run.calling]
        if waits_for := [*dispatcher.waits_for(), *calls]:
            run.log(f"still waiting for {'; '.join(waits_for)}")
        elif not (for_a_time or run.questions.open or dispatcher.paused):
            run.log(
                "still waiting, for nothing that is known: a fault of labrun; Ctrl-C twice ends it"
            )
        patience_s *= 2


async def _drain(dispatcher: Dispatcher, control: Control) -> None:
    drained = await dispatcher.drain(DRAIN_S, stop=lambda: control.now)
    if control.now:
        raise StopNow
    if not drained:
        left = "; ".join(dispatcher.waits_for())
        dispatcher.run.log(f"cancelled, but not ended: {left}; continuing without them")
