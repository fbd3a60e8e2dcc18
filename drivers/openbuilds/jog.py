"""A held jog through OpenBuilds CONTROL, fed by the clock: its reports are too late for control."""

import asyncio
from collections.abc import Callable

from ..grbl.jog import jog_line
from ..motion.faults import Ended, Silent
from .control import Control
from .watch import watch

PIECE_S, AHEAD_S = 0.15, 0.35
ANSWER_S = 2.0


async def jog_while(
    control: Control,
    axis: int,
    way: float,
    feed: float,
    held: Callable[[], bool],
    ended: Callable[[], bool],
) -> None:
    """Jog along `way` (mm, signed) while it is held, and stop; raises Ended or a MotionFault."""
    clock, speed = asyncio.get_running_loop().time, feed / 60
    begun, asked = clock(), 0.0
    while held() and not ended() and abs(way) - asked > 1e-6:
        if asked > speed * (clock() - begun + AHEAD_S):
            await asyncio.sleep(0.03)
            continue
        piece = min(speed * PIECE_S, abs(way) - asked)
        await control.ask(jog_line(axis, piece if way > 0 else -piece, feed), ANSWER_S)
        asked += piece
    if abs(way) - asked > 1e-6:
        await control.drop(jog=True)
    seconds = 2 + (asked / speed - (clock() - begun))
    if not await control.until(lambda: control.look().run in ("Idle", "Alarm"), max(2.0, seconds)):
        raise Silent(f"it reports {control.look().run} after the end of the jog")
    await watch(control, await control.run(), lambda: False)
    control.unsettle()
    if ended():
        raise Ended
