"""Instruments that outlive their servers, and the list of what they really did: the witness."""

import asyncio
from contextvars import Context
from dataclasses import dataclass, field
from random import Random
from typing import Any

from ...drivers.driver import ActionCanceled, Driver, GoalContext, Place
from ...schemas.contract import Contract
from ...schemas.messages import FileContent
from ...schemas.plainest import plainest
from ...system.tasks import spawn
from .process import living

STRANGER = "elsewhere/"
"""So the goals of another bench begin, whose server has this instrument, too, by mistake."""
SAFE_S = 0.0, 0.1, 3.0
"""How long an instrument takes to become safe."""


@dataclass(frozen=True, slots=True)
class Deed:
    """One execution of a `once` action, and what every instrument was set to then."""

    at_s: float
    device: str
    action: str
    goal: str
    settings: dict[str, dict[str, Any]]
    safe_at_s: dict[str, float]


@dataclass(slots=True)
class Bench:
    """All instruments of a history."""

    random: Random
    instruments: dict[str, "Instrument"] = field(default_factory=dict)
    deeds: list[Deed] = field(default_factory=list)


class Instrument:
    """What it has begun it ends, whoever asked for it. `remembers`: it knows goals by their ids.

    `beside_ledger`: its driver knows them for it, and its files are put back with the ledger.
    """

    def __init__(
        self, bench: Bench, name: str, contract: Contract, *, remembers: bool, beside_ledger: bool
    ) -> None:
        self.bench, self.name, self.contract = bench, name, contract
        self.remembers, self.beside_ledger = remembers, beside_ledger
        self.settings: dict[str, Any] = {}
        self.under_way: dict[str, asyncio.Future[None]] = {}
        self.is_safe = True
        self.safe_at_s = -1.0
        self.newest: str = ""
        bench.instruments[name] = self

    async def idle(self) -> None:
        """Until nothing is under way."""
        while self.under_way:
            await asyncio.wait(list(self.under_way.values()))

    def begin(self, goal: str, action: str, params: dict[str, Any]) -> asyncio.Future[None]:
        """Start an action; it takes effect on the way, and the future is its end."""
        if not goal.startswith(STRANGER):
            living()
        loop = asyncio.get_running_loop()
        typical_s = self.contract.actions[action].typical_s({}) or 0.0
        lasts_s = self.bench.random.uniform(0.02, 2 * typical_s + 0.03)
        end: asyncio.Future[None] = loop.create_future()
        self.under_way[goal] = end
        effect_s = lasts_s * self.bench.random.random()
        if self.contract.safe_state and not goal.startswith(STRANGER):
            self.is_safe = False
        nobody = Context()  # what is under way belongs to no process
        loop.call_later(effect_s, self._take_effect, goal, action, params, context=nobody)
        loop.call_later(lasts_s, self._end, goal, context=nobody)
        return end

    def abort(self, goal: str) -> bool:
        """Take back what has not taken effect yet."""
        there = goal in self.under_way
        self._end(goal)
        return there

    def _take_effect(self, goal: str, action: str, params: dict[str, Any]) -> None:
        if goal not in self.under_way:
            return
        told = self.contract.actions[action]
        if told.effect == "once":
            settings = {n: dict(i.settings) for n, i in self.bench.instruments.items()}
            now = asyncio.get_running_loop().time()
            safe_at_s = {n: i.safe_at_s for n, i in self.bench.instruments.items()}
            self.bench.deeds.append(Deed(now, self.name, action, goal, settings, safe_at_s))
            self.newest = goal
        elif (
            told.effect == "idempotent" and not told.returned_paths()
        ):  # what hands over a file sets nothing
            self.settings[told.setting(params) or action] = params

    def _end(self, goal: str) -> None:
        end = self.under_way.pop(goal, None)
        if end is not None and not end.done():
            end.set_result(None)

    def make_safe(self) -> None:
        """What was set is lost."""
        self.settings.clear()
        self.is_safe, self.safe_at_s = True, asyncio.get_running_loop().time()


def driver_of(instrument: Instrument) -> type[Driver]:
    """The driver of one instrument: it waits until the instrument is idle, as a good driver does."""
    contract = instrument.contract
    probes = {action.probe for action in contract.actions.values()}

    def action(named: str) -> Any:
        told = contract.actions[named]

        async def perform(self: Driver, goal: GoalContext, **params: Any) -> dict[str, Any]:
            await asyncio.sleep(instrument.bench.random.uniform(0, 0.01))
            if not (contract.concurrent or told.meanwhile):
                await instrument.idle()
            result = {
                name: plainest(schema, params.get(name))
                for name, schema in told.returns.get("properties", {}).items()
            }
            for name in told.returned_paths():
                goal.files[name] = FileContent.of(str(result[name]), b"")
            if told.effect != "pure":
                await _end_of(instrument, goal, named, params)
            elif named in probes:
                await instrument.idle()
                result["goal_id"] = instrument.newest if instrument.remembers else None
            return result

        return perform

    async def safe(self: Driver) -> None:
        living()
        await asyncio.sleep(instrument.bench.random.choice(SAFE_S))
        await instrument.idle()
        living()
        instrument.make_safe()

    methods = {name: action(name) for name in contract.actions}
    return type("Simulated", (Driver,), {"contract": contract.type, "safe": safe, **methods})


async def _end_of(
    instrument: Instrument, goal: GoalContext, name: str, params: dict[str, Any]
) -> None:
    end = instrument.begin(goal.id, name, params)
    if not instrument.contract.actions[name].cancel:
        return await asyncio.shield(end)
    cancelled = spawn("a cancel", goal.cancelled.wait())
    try:
        await asyncio.wait({end, cancelled}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        cancelled.cancel()
    if not end.done() and instrument.abort(goal.id):
        raise ActionCanceled
    return None


def place_of(instrument: Instrument, folder: Any) -> Place:
    """A driver's surroundings."""
    return Place(instrument.name, {}, {}, folder, folder, instrument.contract)
