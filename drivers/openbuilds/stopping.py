"""Stop the axes through OpenBuilds CONTROL.

CONTROL's stop sends `!` and 0.2 s later a reset, which at speed comes before the axes have stopped
and loses the position. So the hold is sent first, alone, and the stop when the hold is complete.
"""

import asyncio

from ..motion.faults import Lost, MotionFault
from .control import Control

HOLD_S = 1.5
RESET_S = 0.5  # CONTROL waits 0.2 s before its reset; what is queued before that is lost
PROOF_S = 1.2
STILL = ("Idle", "Alarm", "Sleep", "Check", "Stopped")


async def stop(control: Control, *, moving: bool, homing: bool = False) -> None:
    """Stop, with nothing queued; raises a MotionFault if standstill cannot be confirmed."""
    if control.lost:
        raise Lost(f"it cannot be stopped: {control.lost}")
    view = control.look()
    if control.locked:
        return  # an alarm has stopped the motors
    if homing:
        await control.drop(abort=True)
        control.homed = False
        control.alarm = control.alarm or "homing was aborted. Unlock it, home it"
        await asyncio.sleep(RESET_S)
        return
    if not moving and view.run in STILL:
        return
    await control.emit("serialInject", "!")
    if not await control.until(lambda: _held(control), HOLD_S) and not control.locked:
        control.homed = False
        control.alarm = control.alarm or "it was reset before it had stopped. Home it"
    if control.locked:
        return
    await control.drop()
    control.unsettle()
    await asyncio.sleep(RESET_S)
    await _prove(control)


def _held(control: Control) -> bool:
    return control.locked or (control.view is not None and control.view.held)


async def _prove(control: Control) -> None:
    for _ in range(2):
        answer = await control.run()
        done, _ = await asyncio.wait({answer}, timeout=PROOF_S)
        if done:
            if control.locked or answer.exception() is None:
                return
            break
        if control.locked:
            return
    control.homed = False
    raise MotionFault(
        "it did not confirm that it has stopped and may still move: press its emergency stop"
    )
