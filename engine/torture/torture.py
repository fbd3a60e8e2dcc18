"""Torture a protocol: two undisturbed runs to know what is right, then runs that are struck down."""

import math
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random

from ...drivers.twins.wire import WireFaults
from ..check import Checked
from ..journal import JournalFault
from .lab_file import write_lab
from .ordeal import Ordeal
from .plan import Kill, at_boundary, at_random
from .stand import Stand
from .toll import Toll
from .verdict import Breach, Measure, judge
from .witness import Account, steady_facts

A_RUN = 40
"""Blows to one run at most; then it may end, and the next one begins."""
BAD_WIRE = WireFaults(
    drop_request=0.002, drop_reply=0.002, duplicate=0.01, reorder=0.01, hang=0.0002, hang_s=3.0,
    cut=0.001,
)  # fmt: skip


class NothingToTorture(Exception):
    """The protocol does not even run undisturbed; the text says why."""


@dataclass(slots=True)
class Torture:
    """One torture of one protocol; `say` is told how it goes."""

    checked: Checked
    options: list[str]
    folder: Path
    seed: int
    say: Callable[[str], None]
    keep: bool = False
    wires: bool = True
    toll: Toll = field(default_factory=Toll)
    _count: int = 0

    async def at_random(self, kills: int) -> None:
        """Runs, one after the other, until so many blows have fallen."""
        toll, right = self.toll, await self._measure()
        random = Random(self.seed)
        blows = at_random(random, right.lasts_s, right.writes)
        while toll.kills < kills:
            # At least two runs, so that one of them is over a bad wire.
            budget = min(A_RUN, math.ceil(kills / 2), kills - toll.kills)
            wired = self.wires and self._count % 2 == 1
            await self._one(toll, right, blows, budget, random, wired=wired)
            self.say(
                f"{toll.kills} of {kills} blows, {toll.runs} runs, {len(toll.breaches)} breaches"
            )

    async def at_every_boundary(self) -> None:
        """One run for each write of the journal, until a run ends before its blow falls."""
        toll, right = self.toll, await self._measure()
        random, flush = Random(self.seed), 1
        while await self._one(toll, right, iter([at_boundary(flush, self.seed)]), 1, random):
            self.say(f"write {flush} of the journal, {len(toll.breaches)} breaches")
            flush += 1

    async def _measure(self) -> Measure:
        self.say("two undisturbed runs, to know what is right")
        one, other = [await self._undisturbed() for _ in range(2)]
        assert one.finished is not None
        iterations = {name: ends[-1].fate for name, ends in one.iterations.items()}
        safe = {device for device, confirmed in one.safe.items() if confirmed}
        return Measure(
            one.finished.fate, iterations, steady_facts(one, other), safe, one.lasts_s,
            writes=len(one.sent) + 2,
        )  # fmt: skip

    async def _undisturbed(self) -> Account:
        ordeal = self._ordeal(iter(()), 0, Random(0))
        found = await ordeal.suffer()
        if found is None or found.finished is None or found.finished.fate != "succeeded":
            reason = found.finished.reason if found and found.finished else ""
            log = ordeal.folder / "engine.log"
            reason = reason or (log.read_text(encoding="utf-8").strip() if log.exists() else "")
            raise NothingToTorture(f"undisturbed, the run does not succeed: {reason}")
        self._clear(ordeal, kept=False)
        return found

    async def _one(
        self,
        toll: Toll,
        right: Measure,
        blows: Iterator[Kill],
        budget: int,
        random: Random,
        *,
        wired: bool = False,
    ) -> int:
        """One run and its verdict; how many blows fell."""
        ordeal = self._ordeal(blows, budget, random)
        if wired:
            ordeal.stand = await self._stand(ordeal.folder)
        try:
            found = await ordeal.suffer()
            breaches = [*ordeal.breaches, *(judge(found, right) if found else ())]
        except JournalFault as fault:
            found, breaches = None, [*ordeal.breaches, Breach("end", str(ordeal.run), str(fault))]
        finally:
            if ordeal.stand is not None:
                await ordeal.stand.close()
                for wire in ordeal.stand.wires.values():
                    toll.wire.update(wire.done)
        if found is not None:
            toll.add(found)
        toll.dealt.update(ordeal.dealt)
        toll.breaches += breaches
        self._clear(ordeal, kept=bool(breaches))
        return ordeal.dealt.total()

    def _ordeal(self, blows: Iterator[Kill], budget: int, random: Random) -> Ordeal:
        self._count += 1
        assert self.checked.source is not None and self.checked.lab is not None
        lab = self.folder / "lab" / "lab.yaml"
        write_lab(self.checked.lab, self._devices(), lab, {})
        folder = self.folder / f"{self._count:04d}"
        return Ordeal(self.checked.source.path, lab, self.options, folder, blows, budget, random)

    def _devices(self) -> list[str]:
        return sorted({role.device for role in self.checked.roles.values()})

    async def _stand(self, folder: Path) -> Stand:
        assert self.checked.lab is not None
        faults = replace(BAD_WIRE, seed=self.seed * 1000 + self._count)
        stand = Stand(self.checked.lab, self._devices(), folder / "stand", faults)
        await stand.open()
        return stand

    def _clear(self, ordeal: Ordeal, *, kept: bool) -> None:
        if not (kept or self.keep):
            shutil.rmtree(ordeal.folder, ignore_errors=True)
