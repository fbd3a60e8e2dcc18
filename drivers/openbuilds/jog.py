"""A held jog through OpenBuilds CONTROL, fed by the clock: its reports are too late for control."""

import asyncio
from collections.abc import Callable

from ..grbl.jog import jog_line, pieces_of
from ..motion.faults import Ended, Silent
from .control import SETTLE_S, Control
from .watch import watch

PIECE_S, AHEAD_S = 0.15, 0.35
ANSWER_S = 2.0


async def jog_while(
    control: Control,
    far: dict[int, float],
    feed: float,
    held: Callable[[], bool],
    ended: Callable[[], bool],
) -> None:
    """Jog while it is held, `far` (mm, signed) at most, and stop; raises Ended or a MotionFault."""
    clock, speed = asyncio.get_running_loop().time, feed / 60
    parts, length = pieces_of(far)
    begun, asked = clock(), 0.0
    while held() and not ended() and length - asked > 1e-6:
        if asked > speed * (clock() - begun + AHEAD_S):
            await asyncio.sleep(0.03)
            continue
        piece = min(speed * PIECE_S, length - asked)
        by = {axis: part * piece for axis, part in parts.items()}
        await control.ask(jog_line(by, feed), ANSWER_S)
        asked += piece
    if length - asked > 1e-6:
        await control.drop(jog=True)
    # An Idle from before the jog may be shown until it has moved for a while.
    await control.until(lambda: control.look().run in ("Jog", "Alarm"), SETTLE_S)
    seconds = 2 + (asked / speed - (clock() - begun))
    if not await control.until(lambda: control.look().run in ("Idle", "Alarm"), max(2.0, seconds)):
        raise Silent(f"it reports {control.look().run} after the end of the jog")
    await watch(control, await control.run(), lambda: False)
    control.unsettle()
    if ended():
        raise Ended
