"""Find the machine's zero by its switches, or accept a position set by hand."""

import asyncio
from collections.abc import Callable

from ..motion.faults import Ended, HomingFailed
from .alarm import RECOVERED_S
from .controller import Contact, Controller
from .faults import Alarmed, GrblRefused
from .stopping import stop

LOOK_S = 0.1


async def home(controller: Controller, seconds: float, ended: Callable[[], bool]) -> None:
    """Run `$H` to its end; raises HomingFailed or Ended. During homing it does not answer `?`."""
    controller.homed = False
    if controller.dead:
        await controller.until(lambda: not controller.dead, RECOVERED_S)
    answer = controller.say("$H")
    controller.contact = Contact.HOMING
    try:
        await _wait(controller, answer, seconds, ended)
        controller.contact = Contact.READY
        # An `ok` that follows an alarm is not a success: the alarm has already ended the future.
        report = await controller.look()
    except Alarmed as fault:
        await controller.until(lambda: not controller.dead, RECOVERED_S)
        raise HomingFailed(str(fault)) from fault
    except GrblRefused as fault:
        raise HomingFailed(_refused(fault)) from fault
    except asyncio.CancelledError:
        controller.reset()
        raise
    finally:
        if controller.contact is Contact.HOMING:
            controller.contact = Contact.READY
    if report.state != "Idle":
        raise HomingFailed(f"it answered `ok`, but reports {report.state}")
    controller.homed, controller.alarm = True, ""


async def _wait(
    controller: Controller,
    answer: asyncio.Future[None],
    seconds: float,
    ended: Callable[[], bool],
) -> None:
    clock = asyncio.get_running_loop().time
    end = clock() + seconds
    while not answer.done():
        await asyncio.wait({answer}, timeout=LOOK_S)
        if answer.done():
            break
        if ended():
            await stop(controller, moving=True)
            raise Ended
        if clock() > end:
            await stop(controller, moving=True)
            raise HomingFailed.too_long(seconds)
    answer.result()


def _refused(fault: GrblRefused) -> str:
    if fault.code == 5:
        return (
            f"{fault}. If there are no switches, put the carriage at a known place by hand and "
            f"give that place in config: `home_here: {{x: 0, y: 0, z: 50}}`"
        )
    return str(fault)
