"""A laboratory balance on a serial line, using MT-SICS levels 0 and 1 (Mettler-Toledo, Ohaus, Kern).

Mettler-Toledo, *Reference Manual MT-SICS*, 11780711. Configuration: that of a serial line.
"""

import asyncio
import contextlib
import json
import re
from collections.abc import AsyncIterator
from typing import Any, ClassVar

from ...schemas.contract import RESERVED_ERRORS, Happened
from ...system.files import write_whole
from ..bridges.record import OnceRecord
from ..driver import ActionCanceled, ActionFailed, Driver, GoalContext, Place
from ..serial_io.line import SerialLine
from ..serial_io.port import read_port

ANSWER_S, PATIENCE_S, TICK_S = 2.0, 10.0, 0.2
SURE_STEPS = 20
"""A load that a tare has taken away is told from none if it is so many steps of the display."""
TARED, RUNS_KEPT = "tared.json", 100
"""Run -> its newest zero or tare, and the tare memory then."""
ANSWER = r"{} +(?:([SDA]) +(-?\d+\.?\d*) (\S+)|([AIL+-])|A (.+)|S (?P<fault>Error \S+)) *|(E[STL])"
FAULTS = {
    "ES": "it does not know the command: is MT-SICS, level 1, switched on in its menu?",
    "ET": "it could not read the bytes: check baud rate, bits and parity in its menu",
    "EL": "it cannot do that now: its display may show why",
}
GRAMS = {
    "g": 1.0, "kg": 1000.0, "mg": 1e-3, "ug": 1e-6, "t": 1e6, "ct": 0.2, "lb": 453.59237,
    "oz": 28.349523125, "ozt": 31.1034768, "GN": 0.06479891, "dwt": 1.55517384,
}  # fmt: skip


class Balance(Driver):
    """Implements balance@1.

    It polls with SI where S would do: a balance that waits for a stable value can only be
    interrupted by @, which clears its tare. It keeps no names of goals either: what was sent is on
    disk before it goes out, and after a crash its tare memory (TA) tells whether it was done.
    """

    contract: ClassVar[str] = "balance@1"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self._line = SerialLine(read_port(place))
        self._turn = asyncio.Lock()
        self._latest: dict[str, Any] = {}
        self._step_g = 0.0
        self._tared: dict[str, list[Any]] = {}
        self._record = OnceRecord(place.folder)

    async def open(self) -> None:
        self._record.open()
        with contextlib.suppress(FileNotFoundError):
            self._tared = json.loads((self.place.folder / TARED).read_bytes())
        try:
            await self._ask("I1")
        except ActionFailed as failure:
            raise OSError(failure.message) from failure

    async def close(self) -> None:
        await self._line.close()

    async def status(self) -> dict[str, Any]:
        if not self._turn.locked():  # an action polls all the time and keeps this up to date
            try:
                self._latest["tared"] = self._weight(await self._ask("TA"))[0] != 0
                await self._reading()
            except ActionFailed as failure:
                if failure.name not in ("Busy", "Overload"):
                    raise
                self._latest["stable"] = False
        return dict(self._latest)

    async def zero(self, goal: GoalContext) -> dict[str, Any]:
        try:
            await self._still(goal)
        except ActionFailed as failure:
            if failure.name != "Overload":
                raise
            raise ActionFailed("NotEmpty", failure.message) from failure
        async with self._recorded("zero", goal, 0.0):
            match await self._ask("Z", wait_s=PATIENCE_S, tries=1):
                case ["A"]:
                    self._has_happened(goal.id, 0.0)
                    return {}
                case ["+" | "-" as side]:
                    raise ActionFailed(
                        "NotEmpty", f"the load on the pan is too {_far(side)} to zero", "no"
                    )
            raise ActionFailed("Unstable", "the reading started to change while zeroing", "no")

    async def tare(self, goal: GoalContext) -> dict[str, Any]:
        async with self._recorded("tare", goal, await self._still(goal)):
            answer = await self._ask("T", wait_s=PATIENCE_S, tries=1)
            if answer == ["I"]:
                raise ActionFailed("Unstable", "the reading started to change while taring", "no")
            tare_g = self._weight(answer)[0]
            self._has_happened(goal.id, tare_g)
        return {"tare": tare_g}

    async def last_tare(self, goal: GoalContext) -> dict[str, Any]:
        if (begun := self._record.begun) is not None:
            happened, tare_g = await self._trace_of(begun)
            if happened == "yes":
                self._has_happened(begun["goal"], tare_g)
            self._record.ended(begun["goal"], happened)
        return {"goal_id": None} if self._record.begun is not None else self._record.last()

    async def weigh(self, goal: GoalContext, *, patience: float = PATIENCE_S) -> dict[str, Any]:
        mass, stable = await self._settle(goal, patience)
        await self._same_tare(goal)
        return {"mass": mass, "stable": stable}

    @contextlib.asynccontextmanager
    async def _recorded(self, action: str, goal: GoalContext, net_g: float) -> AsyncIterator[None]:
        """Around what changes all later readings: on disk, with what the balance showed before."""
        before = {"tare": await self._tare_g(), "net": net_g, "step": self._step_g}
        try:
            self._record.begin(goal.id, action, before)
        except OSError as fault:
            raise ActionFailed("Lost", f"{fault}; nothing was sent", "no") from fault
        try:
            yield
        except ActionFailed as failure:
            happened = failure.happened or RESERVED_ERRORS.get(failure.name, "unknown")
            self._record.ended(goal.id, happened)
            raise

    async def _tare_g(self) -> float:
        """What its tare memory holds; once it answers, no tare that was asked for is under way."""
        until = asyncio.get_running_loop().time() + PATIENCE_S
        while True:
            try:
                return self._weight(await self._ask("TA"))[0]
            except ActionFailed as failure:
                if failure.name != "Busy" or asyncio.get_running_loop().time() >= until:
                    raise
            await asyncio.sleep(TICK_S)

    async def _trace_of(self, begun: dict[str, Any]) -> tuple[Happened, float]:
        """Whether what was begun has happened, as the tare memory shows, and what it holds."""
        tare, before = await self._tare_g(), begun["count"]
        if begun["action"] == "zero":  # it clears the tare; where there was none, nothing shows it
            return ("no" if before["tare"] and tare == before["tare"] else "unknown"), tare
        if abs(before["net"]) < SURE_STEPS * before["step"]:
            return "unknown", tare
        if tare == before["tare"]:
            return "no", tare
        as_it_would_be = abs(tare - before["tare"] - before["net"]) < abs(before["net"]) / 10
        return ("yes" if as_it_would_be else "unknown"), tare

    def _has_happened(self, goal_id: str, tare_g: float) -> None:
        tared = {**self._tared, _run(goal_id): [goal_id, tare_g]}
        self._tared = dict(list(tared.items())[-RUNS_KEPT:])
        write_whole(self.place.folder / TARED, json.dumps(self._tared).encode())
        self._record.ended(goal_id, "yes", {"tare": tare_g})

    async def _same_tare(self, goal: GoalContext) -> None:
        """Fail if what this run has zeroed or tared no longer holds: it would take its mass for another."""
        tared, begun = self._tared.get(_run(goal.id)), self._record.begun
        if tared is None or (begun is not None and _run(begun["goal"]) == _run(goal.id)):
            return  # of the run's newest a person has said what became of it
        goal_id, was_g = tared
        done, tare_g = self._record.done or {"goal": goal_id}, await self._tare_g()
        if done["goal"] != goal_id:
            raise ActionFailed("TareLost", f"{done['goal']} has zeroed or tared it since {goal_id}")
        if abs(tare_g - was_g) > self._step_g:
            raise ActionFailed(
                "TareLost",
                f"its tare was {was_g:g} g when {goal_id} had set it, and is {tare_g:g} g now: it was "
                "switched off, or somebody has zeroed or tared it by hand",
            )

    async def _still(self, goal: GoalContext) -> float:
        mass, stable = await self._settle(goal, PATIENCE_S)
        if not stable:
            raise ActionFailed("Unstable", f"no stable reading within {PATIENCE_S:g} s")
        return mass

    async def _settle(self, goal: GoalContext, patience_s: float) -> tuple[float, bool]:
        """The latest reading in grams, and whether it became stable in time."""
        now = asyncio.get_running_loop().time
        until = now() + patience_s
        while not goal.cancelled.is_set():
            try:
                mass, stable = await self._reading()
                goal.feedback(None, f"{mass:g} g")
                if stable or now() >= until:
                    return mass, stable
            except ActionFailed as failure:
                if failure.name != "Busy" or now() >= until:
                    raise
            await asyncio.sleep(TICK_S)
        raise ActionCanceled("the reading was stopped")

    async def _reading(self) -> tuple[float, bool]:
        mass, stable = self._weight(await self._ask("SI"))
        self._latest |= {"mass": mass, "stable": stable}
        return mass, stable

    def _weight(self, answer: list[str]) -> tuple[float, bool]:
        """Grams, and whether they are stable; raises ActionFailed if the answer has no weight."""
        match answer:
            case [kind, value, unit] if unit in GRAMS:
                self._step_g = GRAMS[unit] / 10 ** len(value.partition(".")[2])
                return round(float(value) * GRAMS[unit], 9), kind != "D"
            case [_, _, unit]:
                raise ActionFailed("Rejected", f"it weighs in {unit!r}; set its unit to g", "no")
            case ["+" | "-" as side]:
                raise ActionFailed(
                    "Overload", f"the load is too {_far(side)} for the balance", "no"
                )
        raise ActionFailed("Busy", f"the balance is busy: it answers {' '.join(answer)}", "no")

    async def _ask(self, command: str, *, wait_s: float = ANSWER_S, tries: int = 2) -> list[str]:
        """The fields of its answer; a query is sent twice if need be, as noise may garble an answer."""
        async with self._turn:
            try:
                if not self._line.is_open:
                    await self._connect()
                return await self._exchange(command, wait_s, tries)
            except OSError as fault:
                raise ActionFailed("Lost", str(fault)) from fault

    async def _connect(self) -> None:
        """Open the line and identify the balance; a different one would have a different tare."""
        await self._line.open()
        names = (("model", "I2"), ("software", "I3"), ("serial_number", "I4"))
        try:
            await self._exchange("SI")  # ends a repeated reading that another program requested
            found = {n: " ".join(await self._exchange(command)).strip('"') for n, command in names}
            before, now = self.versions.get("serial_number"), found["serial_number"]
            if before not in (None, now):
                where = self._line.port
                raise OSError(
                    f"the balance on {where} is now {now}, but was {before}: swap them back"
                )
        except (ActionFailed, OSError):
            await self._line.close()
            raise
        self.versions = found

    async def _exchange(self, command: str, wait_s: float = ANSWER_S, tries: int = 2) -> list[str]:
        answer = re.compile(ANSWER.format("S" if command == "SI" else command))
        heard: list[str] = []
        for _ in range(tries):
            found, heard = await self._line.ask(command, answer, wait_s)
            if found and found["fault"]:
                start = self._line.port.asked_and_answered(command, heard[-1])
                raise ActionFailed(
                    "Rejected",
                    f"{start}: a fault of its own, which its manual names; switch it off and on",
                )
            if found and heard[-1] not in FAULTS:
                return [word for word in found.groups() if word]
        if heard and heard[-1] in FAULTS:
            start = self._line.port.asked_and_answered(command, heard[-1])
            raise ActionFailed("Rejected", f"{start}: {FAULTS[heard[-1]]}")
        raise ActionFailed("Timeout", self._line.port.no_answer(command, heard, "MT-SICS"))


def _run(goal_id: str) -> str:
    return goal_id.partition("/")[0]


def _far(side: str) -> str:
    return "heavy" if side == "+" else "light (is the pan on?)"
