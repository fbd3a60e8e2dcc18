"""Make one move: send it, wait for the proof that it ended, verify the position.

`ok` means that a line is queued, and a report may show Idle before the move has begun. The answer
to `G4 P0` comes when all earlier motion has ended, and is the only proof of it.
"""

import asyncio
import math
from collections.abc import Callable

from ..motion.bench import LETTERS, Point
from ..motion.faults import STOPPED, Ended, MotionFault, Silent, WrongPlace
from .controller import ASK, Controller
from .faults import SOFT_LIMIT, Alarmed, GrblRefused
from .report import Report
from .stopping import finished, stop

POLL_S = 0.1
BRAKING_S = 0.02
SILENCE_S = 2.5
STUCK_S = 15.0
PROOFS = 4

Told = Callable[[Report], None]


class Move:
    """One motion of a controller, watched to its end.

    `ended` is checked all the time: when it is true the axes are stopped.
    """

    def __init__(self, controller: Controller, ended: Callable[[], bool], told: Told) -> None:
        self.controller = controller
        self.ended = ended
        self.told = told

    async def go(self, line: str, end: dict[int, float]) -> Point:
        """Move, stop, and verify; returns the machine position. Raises Ended or a MotionFault.

        A controller that falls silent in mid-move is told to stop before the fault is raised.
        """
        try:
            await self._begin(line)
            await self.wait_until_still()
            await self._check_not_ended()
            return await self._verify(end)
        except Silent as fault:
            raise Silent(f"{fault}; {await _try_to_stop(self.controller)}") from fault
        except asyncio.CancelledError:
            self.controller.reset()  # nothing is left to wait for a hold
            raise

    async def _begin(self, line: str) -> None:
        try:
            await self._wait(self.controller.say(line))
        except Alarmed as fault:
            if fault.code == SOFT_LIMIT:  # which is looked at before a line is planned
                fault.happened = "no"
            raise

    async def touch(self, line: str) -> list[str]:
        """Probe, and stop; what was told of it. Raises Ended or a MotionFault."""
        sent = self.controller.send(line)
        try:
            await self._wait(sent.answer)
            await self._check_not_ended()
            await self.controller.ask("G90")  # for other programs
            await self.wait_until_still()
        except Silent as fault:
            raise Silent(f"{fault}; {await _try_to_stop(self.controller)}") from fault
        except asyncio.CancelledError:
            self.controller.reset()
            raise
        return sent.told

    async def _check_not_ended(self) -> None:
        """GRBL answers the line that a stop's reset has broken off with `ok`, too."""
        if self.ended():
            await finished(self.controller)
            raise Ended

    async def wait_until_still(self) -> None:
        """Wait for the proof that all motion has ended."""
        for _ in range(PROOFS):
            proof = self.controller.say("G4P0")
            try:
                if await self._wait(proof, lost_if_idle=True):
                    return
            except GrblRefused as fault:
                # What was sent before it has moved the axes, or still does.
                raise MotionFault(f"asked whether all motion has ended, {fault}") from fault
        raise Silent("it reports Idle, but never answered `G4P0`")

    async def _wait(self, answer: asyncio.Future[None], *, lost_if_idle: bool = False) -> bool:
        """Watch until the line is answered; False if its answer was lost in noise."""
        clock = asyncio.get_running_loop().time
        c, idle_since, moved_at, place = self.controller, None, clock(), None
        heard = c.reports_heard
        while True:
            await asyncio.wait({answer}, timeout=POLL_S)
            if answer.done():
                answer.result()
                return True
            if self.ended():
                await stop(c, moving=True)
                raise Ended
            if c.silent_s() > SILENCE_S:
                c.forget(answer)
                raise Silent(f"it fell silent for {SILENCE_S:g} s; {c.last_words}")
            c.write(ASK)
            if c.reports_heard == heard or c.report is None:
                continue
            heard = c.reports_heard
            self.told(c.report)
            if c.report.machine != place or c.report.state in ("Hold", "Door"):
                place, moved_at, idle_since = c.report.machine, clock(), None
            elif clock() - moved_at > STUCK_S:
                c.forget(answer)
                raise Silent(f"it reports {c.report.state} and has not moved for {STUCK_S:g} s")
            if c.report.state != "Idle":
                idle_since = None
            elif idle_since is None:
                idle_since = clock()
            elif clock() - idle_since > 1.0:  # far longer than it needs to answer a finished line
                c.forget(answer)
                # The position will show whether the line itself was received.
                return not lost_if_idle

    async def _verify(self, end: dict[int, float]) -> Point:
        for _ in range(PROOFS):
            report = await self._braked()
            if self.controller.alarm:  # an emergency stop between the proof and this report
                raise MotionFault(self.controller.alarm)
            if report.state in ("Run", "Hold", "Door"):
                # The line and the proof were received as one; or it is held, and ends when it is resumed.
                await self.wait_until_still()
                continue
            if report.machine is not None and _there(
                report.machine, end, self.controller.settings.tolerance
            ):
                self.told(report)
                return report.machine
        raise WrongPlace(f"it has stopped, but {self._where(end)}")

    async def _braked(self) -> Report:
        """A report of no braking: a hold in the last 0.06 s of the way frees the proof too early."""
        clock = asyncio.get_running_loop().time
        until = clock() + STUCK_S
        while (report := await self.controller.look()).braking and clock() < until:
            if self.ended():
                await stop(self.controller, moving=True)
                raise Ended
            await asyncio.sleep(BRAKING_S)
        return report

    def _where(self, end: dict[int, float]) -> str:
        machine = self.controller.report.machine if self.controller.report else None
        if machine is None:
            return "it does not report where"
        wanted = " ".join(f"{LETTERS[a]} {v:.3f}" for a, v in sorted(end.items()))
        found = " ".join(f"{LETTERS[a]} {machine[a]:.3f}" for a in sorted(end))
        return (
            f"at {found} instead of {wanted} (machine coordinates); repeat the move, and if "
            f"that does not help check the line for noise"
        )


def _there(machine: tuple[float, ...], end: dict[int, float], tolerance: float) -> bool:
    # The report's own rounding to 0.001 mm comes on top.
    return all(math.fabs(machine[axis] - value) <= tolerance for axis, value in end.items())


async def _try_to_stop(controller: Controller) -> str:
    """What came of it, for a message."""
    try:
        await stop(controller, moving=True)
    except MotionFault as fault:
        controller.alarm = str(fault)
        controller.homed = False
    return controller.alarm or STOPPED
