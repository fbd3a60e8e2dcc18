"""Find the machine's zero by its switches, or take a place that somebody vouches for."""

import asyncio
from collections.abc import Callable

from .alarm import RECOVERED_S
from .controller import Controller
from .faults import Alarmed, GrblFault, Refused
from .motion import Ended
from .stopping import stop

LOOK_S = 0.1


class HomingFailed(GrblFault):
    """It does not know where it is."""

    error = "HomingFailed"


async def home(controller: Controller, seconds: float, ended: Callable[[], bool]) -> None:
    """Run `$H` to its end; raises HomingFailed or Ended. While it homes it answers no `?`."""
    controller.homed = False
    if controller.dead:
        await controller.until(lambda: not controller.dead, RECOVERED_S)
    answer = controller.say("$H")
    controller.deaf = True
    try:
        await _wait(controller, answer, seconds, ended)
        controller.deaf = False
        # An `ok` that follows an alarm is no success: the alarm has taken the future before it.
        report = await controller.look()
    except Alarmed as fault:
        await controller.until(lambda: not controller.dead, RECOVERED_S)
        raise HomingFailed(str(fault)) from fault
    except Refused as fault:
        raise HomingFailed(_refused(fault)) from fault
    except asyncio.CancelledError:
        controller.reset()
        raise
    finally:
        controller.deaf = False
    if report.state != "Idle":
        raise HomingFailed(f"it said `ok`, but reports {report.state}")
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
            raise HomingFailed(
                f"it did not end within {seconds:g} s and was reset; is a switch's cable off, or "
                f"is `homing_timeout` too short for this machine?"
            )
    answer.result()


def _refused(fault: Refused) -> str:
    if fault.code == 5:
        return (
            f"{fault}. Where there are no switches, put the carriage at a known place by hand and "
            f"say in config where that is: `home_here: {{x: 0, y: 0, z: 50}}`"
        )
    return str(fault)
