"""The same engine, checker, tree and drivers as in a run; only network, disk and time differ."""

import asyncio
import math
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...drivers.driver import Place
from ...drivers.server.arguments import read_limits
from ...drivers.simulated.twins.faults import Faults
from ...drivers.simulated.twins.twin import Twin
from ...drivers.world import World, WorldInMemory
from ...schemas import journal as j
from ...schemas import protocol as p
from ...schemas.contract import RESERVED_ERRORS
from ...schemas.event import Event
from ..check import Checked
from ..journal.gantt import Gantt
from ..journal.journal import Journal, R
from ..language.expression import told_roles, told_steps
from ..language.suggest import listed
from ..language.value import Value
from ..run.clock import RunClock
from ..run.copies import keep_used
from ..run.function_calls import call_at_once
from ..run.virtual_time import VirtualLoop
from ..runner.begin import RunOptions, new_run
from ..runner.session import RunSession
from ..survey.survey import Survey
from .client import RehearsedDevice, Trouble
from .totals import Counting, Totals
from .twin_choice import may_repeat, player

IN_MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None
"""What a rehearsal writes is read again within seconds and then thrown away."""


TURNS = 10_000
"""Of a `while` without `max`, before a rehearsal ends."""


class NoRehearsal(Exception):
    """A rehearsal that cannot start; the text states why."""


@dataclass(slots=True)
class Rehearsal:
    """What to rehearse: a checked protocol, faults by device and action, and a random seed."""

    checked: Checked
    faults: dict[str, dict[str, Any]] = field(default_factory=dict)
    seed: int | None = None
    turns: int = TURNS
    say: Callable[[float, int], None] = lambda at_s, goals: None
    gantt: Gantt = field(default_factory=Gantt)
    real_s: float = 0.0

    def play(self) -> Totals:
        """Rehearse it from start to end; raises NoRehearsal."""
        began = time.monotonic()
        folder = Path(tempfile.mkdtemp(prefix="labrun-rehearsal-", dir=IN_MEMORY))
        try:
            with asyncio.Runner(loop_factory=VirtualLoop) as runner:
                totals = runner.run(self._rehearse(folder / "rehearsal"))
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        self.real_s = time.monotonic() - began
        return totals

    async def _rehearse(self, folder: Path) -> Totals:
        checked, clock = self.checked, asyncio.get_running_loop().time
        assert checked.protocol is not None and checked.survey is not None
        assert checked.source is not None
        folder.mkdir(parents=True)
        keep_used(folder, checked.source.name, checked.survey)
        names = [step.id or step.name for step in checked.protocol.steps]
        names = [name or f"step {n + 1}" for n, name in enumerate(names)]
        counting = Counting(names, self.gantt)
        journal = _EventRelay(folder / "journal.jsonl", lambda r: self._heard(counting, r, clock()))
        run = new_run(
            folder, checked, RunOptions(yes=True), journal=journal, clock=RunClock.virtual(clock)
        )
        run.call, run.turns_at_most = call_at_once, self.turns
        run.questions.person = lambda question: question.choices[0]
        world = WorldInMemory()
        devices = self._devices(folder, world, counting.totals.players)
        session = RunSession(run, checked, devices)
        run.questions.changed = session.dispatcher.wake.set
        pauses: list[str] = []

        def end_at_pause(event: Event) -> None:
            if event.state == "pause":  # nobody is there to go on, and time would jump for ever
                pauses.append(event.text)
                session.control.ask("abort", "the rehearsal")

        run.listen(end_at_pause, {"control"})
        try:
            for device in devices.values():
                await device.open(run.id)
            ending = await session.execute(None)
            if pauses:
                ending.reason = f"it pauses and waits for a person: {pauses[0]}"
        finally:
            for device in devices.values():
                await device.close()
            journal.close()
        finished = j.Finished(
            fate=ending.fate, reason=ending.reason, holes=run.history.hole_count,
            points=run.history.points(),
        )  # fmt: skip
        totals = counting.close(clock(), finished)
        wanted = (f"{device}.{one}" for device, each in self.faults.items() for one in each)
        totals.unreached = [label for label in wanted if label not in totals.actions]
        totals.path_mm = path_lengths(world, list(devices))
        return totals

    def _devices(
        self, folder: Path, world: World, players: dict[str, str]
    ) -> dict[str, RehearsedDevice]:
        lab = self.checked.lab
        assert lab is not None and self.checked.survey is not None
        told, heard = devices_read(self.checked.survey), devices_heard(self.checked.survey)
        made: dict[str, RehearsedDevice] = {}
        for name in sorted({role.device for role in self.checked.roles.values()}):
            contract = lab.contracts[lab.lab.devices[name].contract]
            driver, config, players[name] = player(name, lab)
            ordered, reserved = apart(self.faults.get(name, {}))
            if unknown := sorted(set(reserved) - set(contract.actions)):
                raise NoRehearsal(f"{name}: {contract.type} has no action {unknown[0]!r}")
            try:
                faults = Faults(ordered, contract, self.seed or 1)
                if issubclass(driver, Twin):
                    config["faults"] = {**config.get("faults", {}), **ordered}
                    config.update({} if self.seed is None else {"seed": self.seed})
                limits = lab.lab.devices[name].limits.items()
                place = Place(
                    name, config, read_limits({k: v.model_dump() for k, v in limits}, contract),
                    folder, folder, contract, world,
                )  # fmt: skip
                trouble = Trouble(reserved, self.seed or 1)
                made[name] = RehearsedDevice(
                    place, driver, contract, faults, trouble, is_read=name in told,
                    repeats=name not in heard and may_repeat(players[name], contract),
                )  # fmt: skip
            except ValueError as fault:
                any_of = f"; any action may end with {listed(RESERVED_ERRORS)}"
                raise NoRehearsal(f"{name}: {fault}{any_of * bool(ordered)}") from fault
        return made

    def _heard(self, counting: Counting, record: j.Record, at_s: float) -> None:
        counting.record(record, at_s)
        if isinstance(record, j.GoalEnded):
            self.say(at_s, counting.goals)


def devices_read(survey: Survey) -> set[str]:
    """The devices whose status an expression reads, also in used protocols."""
    values = (spot.value for spot in survey.spots if isinstance(spot.value, Value))
    asked = (one for value in values for one in value.expressions())
    found = {survey.roles[role].device for one in asked for role in told_roles(one, survey.roles)}
    return found.union(*(devices_read(used.survey) for used in survey.used.values()))


def devices_heard(survey: Survey) -> set[str]:
    """The devices whose answers are read, other than into a table; all, where it may be any's."""
    values = (s.value for s in survey.spots if s.use != "collect" and isinstance(s.value, Value))
    read = {id_ for value in values for one in value.expressions() for id_ in told_steps(one)}
    by_id = {at.step.id: at.step for at in survey.steps if at.step.id is not None}
    found: set[str] = set()
    for id_ in read:
        step = by_id.get(id_ or "")
        if isinstance(step, p.Do) and not step.fallback and (known := survey.action(step)):
            found.add(known[0].device)
        elif not isinstance(step, p.LoopBase | p.Use) or step.fallback:
            found.update(role.device for role in survey.roles.values())
    return found.union(*(devices_heard(used.survey) for used in survey.used.values()))


def apart(faults: dict[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
    """Faults that a device's driver makes, and those that any action may end with, by action."""
    own: dict[str, Any] = {}
    reserved: dict[str, dict[str, float]] = {}
    for action, rates in faults.items():
        if not isinstance(rates, dict):
            own[action] = rates
            continue
        met = {error: rate for error, rate in rates.items() if error in RESERVED_ERRORS}
        rest = {error: rate for error, rate in rates.items() if error not in RESERVED_ERRORS}
        reserved |= {action: met} if met else {}
        own |= {action: rest} if rest else {}
    return own, reserved


class _EventRelay(Journal):
    """A journal for one rehearsal, which passes on what is written to it."""

    def __init__(self, path: Path, told: Callable[[j.Record], None]) -> None:
        super().__init__(path, sync=False)
        self._told = told

    def append(self, record: R) -> R:
        written = super().append(record)
        self._told(written)
        return written


def path_lengths(world: World, devices: list[str]) -> dict[str, float]:
    """Millimetres that each device moved, from the log of what it really did."""
    lengths: dict[str, float] = {}
    for device in devices:
        for entry in world.truth(device).entries():
            if "start" in entry and "end" in entry:
                way = math.dist(entry["start"], entry["end"])
                lengths[device] = lengths.get(device, 0.0) + way
    return lengths
