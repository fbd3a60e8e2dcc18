"""Watch a command of OpenBuilds CONTROL until its proof has come."""

import asyncio
from collections.abc import Callable

from ..motion.faults import STOPPED, Ended, Lost, MotionFault, Silent
from .control import Control
from .stopping import stop
from .view import View

POLL_S = 0.1
STUCK_S = 8.0


async def watch(
    control: Control,
    answer: "asyncio.Future[None]",
    ended: Callable[[], bool],
    told: Callable[[View], None] = lambda view: None,
    *,
    seconds: float | None = None,
    late: MotionFault | None = None,
) -> None:
    """Until the answer comes; raises Ended or a MotionFault, `late` where its time is up.

    CONTROL does not show that a controller fell silent: its state and position freeze. With
    `seconds` (homing, a slow memory) that is the whole time limit, and a freeze is expected.
    """
    clock = asyncio.get_running_loop().time
    begun = moved_at = clock()
    place = None
    while True:
        await asyncio.wait({answer}, timeout=POLL_S)
        if answer.done():
            answer.result()
            return
        if ended():
            await stop(control, moving=True, homing=seconds is not None)
            raise Ended
        if control.lost:
            raise Lost(control.lost)
        view = control.look()
        told(view)
        if view.machine != place or view.held:
            place, moved_at = view.machine, clock()
        if seconds is None and clock() - moved_at > STUCK_S:
            now = await _give_up(control, homing=False)
            raise Silent(
                f"its position has not changed for {STUCK_S:g} s, and it reports {view.run}; {now}"
            )
        if seconds is not None and clock() - begun > seconds:
            await _give_up(control, homing=True)
            raise late or Silent(f"it did not end within {seconds:g} s")


async def _give_up(control: Control, *, homing: bool) -> str:
    """What came of stopping it, for a message."""
    try:
        await stop(control, moving=True, homing=homing)
    except MotionFault as fault:
        control.homed, control.alarm = False, str(fault)
    return control.alarm or STOPPED
