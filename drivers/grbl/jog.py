"""Jog: one axis by hand, by a distance or for as long as it is held.

A held jog is fed to the controller in short pieces, a quarter of a second ahead of the axis, so
that it ends by itself when the feeding ends: with the hold, with this program, with the cable.
"""

import asyncio
from collections.abc import Callable

from ..motion.bench import LETTERS
from ..motion.faults import Ended, Silent
from .motion import Move
from .report import Report
from .stopping import stop

AHEAD_S = 0.25
PIECE_S = 0.1
LOOK_S = 0.03


def jog_line(axis: int, distance: float, feed: float) -> str:
    """A relative jog of one machine axis."""
    return f"$J=G21G91{LETTERS[axis]}{distance:.4f}F{feed:.3f}"


async def jog_by(move: Move, axis: int, distance: float, feed: float) -> None:
    """Jog a machine axis by a distance, and stop; raises Ended or a MotionFault."""
    controller = move.controller
    await controller.ask(jog_line(axis, distance, feed))
    while (report := await _watched(move)).state == "Jog":
        move.told(report)
        await asyncio.sleep(LOOK_S)
    await move.wait_until_still()


async def jog_while(
    move: Move, axis: int, way: float, feed: float, held: Callable[[], bool]
) -> None:
    """Jog along `way` (mm, signed: as far as the axis may go) while it is held, and stop.

    Raises Ended or a MotionFault.
    """
    controller = move.controller
    start = _position(await controller.look(), axis)
    sign = 1.0 if way > 0 else -1.0
    speed = feed / 60
    ahead = speed * AHEAD_S + speed**2 / (2 * controller.settings.acceleration[axis])
    asked, gone = 0.0, 0.0
    while held():
        piece = min(max(speed * PIECE_S, 0.01), abs(way) - asked)
        line = jog_line(axis, sign * piece, feed)
        if piece > 1e-6 and asked - gone < ahead and controller.room_for(line):
            await controller.ask(line)
            asked += piece
            continue
        report = await _watched(move)
        move.told(report)
        gone = abs(_position(report, axis) - start)
        if abs(way) - asked <= 1e-6 and report.state != "Jog":
            break
        await asyncio.sleep(LOOK_S)
    await stop(controller, moving=False)
    await move.wait_until_still()


async def _watched(move: Move) -> Report:
    if move.ended():
        await stop(move.controller, moving=False)
        raise Ended
    return await move.controller.look()


def _position(report: Report, axis: int) -> float:
    if report.machine is None:
        raise Silent("it does not report where it is")
    return report.machine[axis]
