"""Torture a protocol: two undisturbed runs as a reference, then runs that are killed."""

import math
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random

from ...drivers.simulated.twins.bad_network import WireFaults
from ..check import Checked
from ..journal.journal import JournalFault
from .accounts import Account, steady_facts
from .bench import Bench
from .campaign import Campaign
from .lab_file import write_lab
from .plan import Kill, at_boundary, at_random
from .report import Report
from .verdict import Breach, Measure, judge

A_RUN = 40
"""At most this many kills per run; then it may end, and the next one starts."""
BAD_WIRE = WireFaults(
    drop_request=0.002, drop_reply=0.002, duplicate=0.01, reorder=0.01, hang=0.0002, hang_s=3.0,
    cut=0.001,
)  # fmt: skip


class NothingToTorture(Exception):
    """The protocol does not succeed even undisturbed; the text states why."""


@dataclass(slots=True)
class Torture:
    """One torture of one protocol; `say` reports the progress."""

    checked: Checked
    options: list[str]
    folder: Path
    seed: int
    say: Callable[[str], None]
    keep: bool = False
    wires: bool = True
    report: Report = field(default_factory=Report)
    _count: int = 0

    async def at_random(self, kills: int) -> None:
        """Run after run, until this many kills have happened."""
        report, right = self.report, await self._measure()
        random = Random(self.seed)
        blows = at_random(random, right.lasts_s, right.writes)
        while report.kills < kills:
            # At least two runs, so that one of them is over a bad wire.
            budget = min(A_RUN, math.ceil(kills / 2), kills - report.kills)
            wired = self.wires and self._count % 2 == 1
            await self._one(report, right, blows, budget, random, wired=wired)
            self.say(
                f"{report.kills} of {kills} kills, {report.runs} runs, {len(report.breaches)} breaches"
            )

    async def at_every_boundary(self) -> None:
        """One run for each write of the journal, until a run ends before its kill."""
        report, right = self.report, await self._measure()
        random, flush = Random(self.seed), 1
        while await self._one(report, right, iter([at_boundary(flush, self.seed)]), 1, random):
            self.say(f"write {flush} of the journal, {len(report.breaches)} breaches")
            flush += 1

    async def _measure(self) -> Measure:
        self.say("two undisturbed runs, as a reference")
        one, other = [await self._undisturbed() for _ in range(2)]
        assert one.finished is not None
        iterations = {name: ends[-1].fate for name, ends in one.iterations.items()}
        safe = {device for device, confirmed in one.safe.items() if confirmed}
        return Measure(
            one.finished.fate, iterations, steady_facts(one, other), safe, one.lasts_s,
            writes=len(one.sent) + 2,
        )  # fmt: skip

    async def _undisturbed(self) -> Account:
        campaign = self._campaign(iter(()), 0, Random(0))
        found = await campaign.suffer()
        if found is None or found.finished is None or found.finished.fate != "succeeded":
            reason = found.finished.reason if found and found.finished else ""
            log = campaign.folder / "engine.log"
            reason = reason or (log.read_text(encoding="utf-8").strip() if log.exists() else "")
            raise NothingToTorture(f"undisturbed, the run does not succeed: {reason}")
        self._clear(campaign, kept=False)
        return found

    async def _one(
        self,
        report: Report,
        right: Measure,
        blows: Iterator[Kill],
        budget: int,
        random: Random,
        *,
        wired: bool = False,
    ) -> int:
        """One run and its verdict; returns the number of kills."""
        campaign = self._campaign(blows, budget, random)
        if wired:
            campaign.bench = await self._bench(campaign.folder)
        try:
            found = await campaign.suffer()
            breaches = [*campaign.breaches, *(judge(found, right) if found else ())]
        except JournalFault as fault:
            found, breaches = (
                None,
                [*campaign.breaches, Breach("end", str(campaign.run), str(fault))],
            )
        finally:
            if campaign.bench is not None:
                await campaign.bench.close()
                for wire in campaign.bench.wires.values():
                    report.wire.update(wire.done)
        if found is not None:
            report.add(found)
        report.dealt.update(campaign.dealt)
        report.breaches += breaches
        self._clear(campaign, kept=bool(breaches))
        return campaign.dealt.total()

    def _campaign(self, blows: Iterator[Kill], budget: int, random: Random) -> Campaign:
        self._count += 1
        assert self.checked.source is not None and self.checked.lab is not None
        lab = self.folder / "lab" / "lab.yaml"
        write_lab(self.checked.lab, self._devices(), lab, {})
        folder = self.folder / f"{self._count:04d}"
        return Campaign(self.checked.source.path, lab, self.options, folder, blows, budget, random)

    def _devices(self) -> list[str]:
        return sorted({role.device for role in self.checked.roles.values()})

    async def _bench(self, folder: Path) -> Bench:
        assert self.checked.lab is not None
        faults = replace(BAD_WIRE, seed=self.seed * 1000 + self._count)
        bench = Bench(self.checked.lab, self._devices(), folder / "stand", faults)
        await bench.open()
        return bench

    def _clear(self, campaign: Campaign, *, kept: bool) -> None:
        if not (kept or self.keep):
            shutil.rmtree(campaign.folder, ignore_errors=True)
