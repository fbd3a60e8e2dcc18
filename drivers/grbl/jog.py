"""Jog: axes by hand, by a distance or for as long as it is held.

A held jog is fed to the controller in short pieces, a quarter of a second ahead of the axes, so
that they stop by themselves when the feeding ends: with the hold, with this program, with the cable.
"""

import asyncio
import math
from collections.abc import Callable, Iterable

from ..motion.bench import LETTERS
from ..motion.faults import Ended, MotionFault, Silent, WrongPlace
from .controller import ANSWER_S
from .faults import GrblRefused
from .motion import Move
from .report import Report
from .stopping import stop

AHEAD_S = 0.25
PIECE_S = 0.1
LOOK_S = 0.03
STOOD = 2
"""So many reports that it stands although it was asked to go on: one may come before it begins."""
WAITS_S = 0.3
"""A line without an answer by then waits, if a `?` that is sent after it is answered first."""
NOT_IDLE = 8
"""The error of a jog that comes while it brakes, or a door is open."""


def words_of(by: dict[int, float]) -> str:
    """The distances of machine axes in G-code."""
    return "".join(f"{LETTERS[axis]}{distance:.4f}" for axis, distance in by.items())


def pieces_of(far: dict[int, float]) -> tuple[dict[int, float], float]:
    """What each axis goes of a millimetre along the way (all go as far), and how long the way is."""
    part = 1 / math.sqrt(len(far))
    ways = {axis: math.copysign(part, distance) for axis, distance in far.items()}
    return ways, abs(next(iter(far.values()))) / part


def jog_line(by: dict[int, float], feed: float) -> str:
    """A relative jog of machine axes, in a straight line."""
    return f"$J=G21G91{words_of(by)}F{feed:.3f}"


async def jog_by(move: Move, by: dict[int, float], feed: float) -> None:
    """Jog machine axes by distances, and stop; raises Ended or a MotionFault.

    A feed hold ends a jog, and so does a door: where it stands then is compared, too.
    """
    controller = move.controller
    start = _positions(await controller.look(), by)
    await controller.ask(jog_line(by, feed))
    while (report := await _watched(move)).state == "Jog":
        move.told(report)
        await asyncio.sleep(LOOK_S)
    await move.wait_until_still()
    end = _positions(await controller.look(), by)
    for (axis, distance), before, after in zip(by.items(), start, end, strict=True):
        # Where it stands and where it is sent are whole steps: half a step at each end.
        if abs(after - before - distance) > 2 * controller.settings.tolerance:
            raise WrongPlace(
                f"{LETTERS[axis]} moved {after - before:.3f} mm instead of {distance:.3f} and stands: "
                f"a feed hold or an open door ends a jog"
            )


async def jog_while(
    move: Move, far: dict[int, float], feed: float, held: Callable[[], bool]
) -> None:
    """Jog while it is held, and stop; `far` (mm, signed) is how far the axes may go, each as far.

    Raises Ended or a MotionFault. A feed hold of another, and a door, end it: it is fed no more where
    it brakes, or stands although there is way left.
    """
    controller = move.controller
    start = _positions(await controller.look(), far)
    parts, length = pieces_of(far)
    speed = feed / 60
    slowest = min(controller.settings.acceleration[axis] for axis in far)
    ahead = speed * AHEAD_S + speed**2 / (2 * slowest)
    asked, gone, stood = 0.0, 0.0, 0
    while held():
        piece = min(max(speed * PIECE_S, 0.01), length - asked)
        line = jog_line({axis: part * piece for axis, part in parts.items()}, feed)
        if not stood and piece > 1e-6 and asked - gone < ahead and controller.room_for(line):
            if not await _taken(move, line, first=not asked):
                break
            asked += piece
            continue
        report = await _watched(move)
        move.told(report)
        gone = math.dist(_positions(report, far), start)
        has_way_left = asked - gone > 4 * controller.settings.tolerance
        stood = stood + 1 if report.state == "Idle" and has_way_left else 0
        if report.state in ("Hold", "Door") or stood == STOOD:
            break
        if length - asked <= 1e-6 and report.state != "Jog":
            break
        await asyncio.sleep(LOOK_S)
    await stop(controller, moving=False)
    await move.wait_until_still()


async def _taken(move: Move, line: str, *, first: bool) -> bool:
    """Whether it went on with a piece: while it brakes for a feed hold it answers `?`, but no line."""
    answer = move.controller.say(line)
    await asyncio.wait({answer}, timeout=WAITS_S)
    if not answer.done():
        await _watched(move)
        if not answer.done():
            await asyncio.wait({answer}, timeout=ANSWER_S)  # it begins once the axes stand
            move.controller.forget(answer)
            return False
    try:
        await answer
    except GrblRefused as fault:
        if first:
            raise
        if fault.code != NOT_IDLE:
            raise MotionFault(f"part of the way was behind it when {fault}") from fault
        return False
    return True


async def _watched(move: Move) -> Report:
    if move.ended():
        await stop(move.controller, moving=False)
        raise Ended
    try:
        report = await move.controller.look()
    except Silent:
        if not move.controller.alarm:  # which would be why it is silent
            raise
    else:
        if not move.controller.alarm:
            return report
    raise MotionFault(f"it answered {move.controller.alarm}")


def _positions(report: Report, axes: Iterable[int]) -> list[float]:
    if report.machine is None:
        raise Silent("it does not report where it is")
    return [report.machine[axis] for axis in axes]
