"""Stop the axes, whatever they do, and know afterwards whether the position can be trusted.

Hold first: the axes brake along their path and no step is lost. A reset once they have stopped
discards the queue; its boot without an alarm proves that nothing was moving, so the position is
still trusted. A reset in mid-motion (homing, or a hold that never completed) causes an ALARM:3 or
6 and the position is not trusted until homed.
"""

import asyncio

from ...system.tasks import spawn
from ..motion.faults import Lost, MotionFault, NotStopped, Silent
from .alarm import RECOVERED_S
from .controller import CANCEL_JOG, HOLD, Contact, Controller

LOOK_S = 0.2
HOLD_S = 1.5
BOOT_S = 1.0
JOG_S = 1.5


async def stop(controller: Controller, *, moving: bool) -> None:
    """Stop, with nothing queued; raises a MotionFault if standstill cannot be confirmed.

    `moving` is whether a line is under way: a report may show Idle before it has begun. Ends within
    about 3 s; after an alarm, within the time that recovery takes. A call during another stop
    shares it: a second reset would come in the middle of the first.
    """
    task = controller.stopping
    if task is None:
        name, stopping = f"stopping {controller.port.name}", _stop(controller, moving=moving)
        task = controller.stopping = spawn(name, stopping, expected=(MotionFault,))
        task.add_done_callback(lambda _: setattr(controller, "stopping", None))
    await asyncio.shield(task)


async def finished(controller: Controller) -> None:
    """Wait for a stop that is under way, however it ends."""
    if controller.stopping is not None:
        await asyncio.wait({controller.stopping})


async def _stop(controller: Controller, *, moving: bool) -> None:
    if controller.lost:
        raise Lost(f"it cannot be stopped: {controller.lost}")
    if controller.dead:  # an alarm has stopped the motors
        if not await controller.until(lambda: not controller.dead, RECOVERED_S):
            raise Silent("it has not responded since the alarm: switch it off")
        if controller.lost:
            raise Lost(controller.lost)
        return
    if controller.contact is Contact.HOMING:
        await _reset(controller)
        return
    try:
        report = await controller.look(LOOK_S)
    except Silent:
        report = None
    if report is not None and report.state == "Jog":
        await _cancel_jog(controller)
    elif moving or report is None or report.state not in ("Idle", "Alarm", "Sleep", "Check"):
        await _hold_and_reset(controller)


async def _cancel_jog(controller: Controller) -> None:
    controller.write(CANCEL_JOG)
    if not await _comes(controller, ("Idle",), JOG_S):
        await _hold_and_reset(controller)


async def _hold_and_reset(controller: Controller) -> None:
    controller.write(HOLD)
    wait = min(HOLD_S, 0.5 + 1.5 * controller.settings.braking_s)
    if not await _comes(controller, ("Hold", "Door"), wait):
        controller.homed = False
        controller.alarm = controller.alarm or "it was reset before it had stopped. Home it"
    if not controller.dead:
        await _reset(controller)


async def _comes(controller: Controller, states: tuple[str, ...], seconds: float) -> bool:
    """Whether it reports one of these states, at rest, in time; an alarm also ends the wait."""
    clock = asyncio.get_running_loop().time
    end = clock() + seconds
    while clock() < end and not controller.dead:
        try:
            report = await controller.look(min(LOOK_S, seconds))
        except Silent:
            continue
        if report.state == "Alarm" or (report.state in states and report.still):
            return report.state in states
        await asyncio.sleep(0.02)
    return False


async def _reset(controller: Controller) -> None:
    before = controller.boots
    controller.reset()
    if await controller.until(lambda: controller.boots > before or bool(controller.lost), BOOT_S):
        if controller.lost:
            raise Lost(controller.lost)
        return
    controller.homed = False
    if controller.dead and await controller.until(lambda: not controller.dead, RECOVERED_S):
        if controller.lost:
            raise Lost(controller.lost)
        return
    raise NotStopped(
        f"it did not respond to a reset within {BOOT_S:g} s and may still move: press its emergency stop"
    )


async def wake(controller: Controller) -> None:
    """Leave Sleep and Check, which only a reset ends; raises a MotionFault."""
    report = await controller.look()
    if report.state == "Sleep":
        controller.homed = False
        controller.alarm = controller.alarm or "it slept with its motors off. Home it"
    if report.state in ("Sleep", "Check"):
        await _reset(controller)
        await controller.look()
