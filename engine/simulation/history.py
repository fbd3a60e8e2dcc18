"""One history: a run under accidents drawn by a seed, until it has ended, and what it has broken."""

import asyncio
import contextlib
import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextvars import Context
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from random import Random
from typing import Any

from ...drivers.client.client import DeviceClient, LeaseHeld, ServerUnreachable
from ...schemas import journal as j
from ...schemas.event import Event
from ...schemas.plainest import plainest
from ...system.tasks import end, spawn
from ..check import Checked
from ..journal import journal as journal_module
from ..journal.history import read_history, split_goal_id
from ..journal.journal import DiskFull, JournalFault, Records, read_records, reopen
from ..run.clock import RunClock
from ..run.questions import DID_NOT_HAPPEN, HAPPENED
from ..run.run import Run
from ..runner.begin import RunOptions, new_run, old_run
from ..runner.session import RunSession
from .disk import SimulatedJournal, lose_journal
from .instrument import STRANGER, Bench, Deed, Instrument
from .process import CURRENT, Died, Process, SimulatedLoop
from .server import SimulatedServer
from .wire import Network, SimulatedLink

BEGAN = datetime(2026, 1, 1, tzinfo=UTC)
LONGEST_S = 20_000.0
STALL_S = 3.0
TURN = re.compile(r"((?:/\w+)+?)/r\d+\1(?=/)")
OUTSIDE = re.compile(r"\d\d:\d\d:\d\d")
"""What a story leaves out, with the folder's name: the time of day of who plays it."""
NOTICED_S = 0.1
"""How long it takes until an engine knows that a server has gone, or is about to."""
SESSIONS = 40
LAPSED_S = 60.0
"""After the end: a device that could not be reached then has been made safe by its server."""
ROUNDS = 400
"""An accident comes within so many rounds of the loop after the one before."""
IN_MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None


@dataclass(slots=True)
class Outcome:
    """What one history has come to; `steady` is filled by those without accidents."""

    seed: int
    breaches: list[str] = field(default_factory=list)
    accidents: Counter[str] = field(default_factory=Counter)
    story: list[str] = field(default_factory=list)
    facts: dict[str, dict[str, Any]] = field(default_factory=dict)
    excused: dict[str, set[str]] = field(default_factory=dict)
    """By path: devices that were made safe when the engine could not know it any more."""
    redone: dict[str, list[tuple[str, Any]]] = field(default_factory=dict)
    """By path: what a retried group had set before the turn in which this was done, or in it."""
    deeds: int = 0
    sessions: int = 0
    lasted_s: float = 0.0


class History:
    """Everything that is there during one history."""

    def __init__(self, checked: Checked, seed: int, *, accidents: int, ledgers: bool) -> None:
        self.checked, self.random = checked, Random(seed)
        self.outcome = Outcome(seed)
        self.left = accidents
        self.ledgers = ledgers
        """Ledgers are put back and lost; if not, the power may be cut (decision 0027 says why)."""
        self.folder = Path(tempfile.mkdtemp(prefix="labrun-simulated-", dir=IN_MEMORY)) / "run"
        self.engine: Process | None = None
        self.run: Run | None = None
        self.session: RunSession | None = None
        self.bench = Bench(Random(self.random.random()))
        self.network = Network(
            Random(self.random.random()), self.random.choice((0, 0, 0.01)) if accidents else 0
        )
        self.servers: list[SimulatedServer] = []
        self.off_until = 0.0
        self.clock_off_s = 0.0

    def live(self) -> Outcome:
        """From the first session to the verdict."""
        self.folder.mkdir()
        try:
            with _surroundings(self), asyncio.Runner(loop_factory=SimulatedLoop) as runner:
                runner.run(self._live())
        except Exception as fault:  # whatever ends a history but death is a breach
            words = str(fault).replace(str(self.folder.parent), "")
            self.outcome.breaches.append(f"{type(fault).__name__}: {words}")
        finally:
            shutil.rmtree(self.folder.parent, ignore_errors=True)
            SimulatedJournal.lengths.pop(self.folder / "journal.jsonl", None)
        return self.outcome

    async def _live(self) -> None:
        loop = asyncio.get_running_loop()
        assert isinstance(loop, SimulatedLoop) and self.checked.lab is not None
        lab = self.checked.lab
        for name in sorted({role.device for role in self.checked.roles.values()}):
            contract = lab.contracts[lab.lab.devices[name].contract]
            instrument = Instrument(
                self.bench, name, contract, remembers=name != "c", beside_ledger=name == "a"
            )
            random = Random(self.random.random())
            journal = self.folder / "journal.jsonl"
            self.servers.append(SimulatedServer(instrument, self.network, random, journal))
        lives = [spawn(f"serve {s.url}", s.live()) for s in self.servers]
        loop.strike = self._strike
        self._aim(loop)
        try:
            async with asyncio.timeout(LONGEST_S):
                while not await self._session() and self.outcome.sessions < SESSIONS:
                    left = self.random.choice((0.05, 0.05, 1.0, 1.0, 5.0, 5.0, 5.0, 40.0))
                    await asyncio.sleep(max(left, self.off_until - loop.time()))
            loop.strike_at = 0
            over = loop.time() + LAPSED_S
            instruments = self.bench.instruments.values()
            while loop.time() < over and not all(i.is_safe for i in instruments):  # noqa: ASYNC110
                await asyncio.sleep(1.0)
            self._judge()
        except TimeoutError:
            self.outcome.breaches.append(f"it stood still for {LONGEST_S:g} s")
        finally:
            self.outcome.lasted_s = loop.time()
            await end(*lives)

    # --- the engine

    async def _session(self) -> bool:
        """One engine; True when the run needs no other."""
        self.outcome.sessions += 1
        process = self.engine = Process()
        work = process.spawn("an engine", self._engine())
        await asyncio.wait({work})
        died = not process.alive
        await process.bury()
        self.session = self.run = None
        if died or work.cancelled():
            return False
        fault = work.exception()
        if isinstance(fault, JournalFault) and SimulatedJournal.full_until:
            return False  # a person makes room, and tries again
        if fault is not None:
            raise fault
        return bool(work.result())

    async def _engine(self) -> bool:
        clients: dict[str, DeviceClient] = {}
        run, records = self._opened()
        if run is None:
            return True
        try:
            for server in self.servers:
                name = server.instrument.name
                client = DeviceClient(
                    server.url, mark=run.history.marks.get(name, ""), link=SimulatedLink
                )
                clients[name] = client
                await client.open()
                await client.take_lease(name, run.id)
        except (ServerUnreachable, LeaseHeld):
            await asyncio.gather(*(client.close() for client in clients.values()))
            run.journal.close()
            return False
        session = RunSession(run, self.checked, clients)
        run.questions.changed = session.dispatcher.wake.set
        run.listen(self._heard)
        run.journal.flush()
        self.run, self.session = run, session
        ending = await session.execute(records)
        with contextlib.suppress(DiskFull):  # the reserve has taken the last record
            run.record(j.Finished(fate=ending.fate, reason=ending.reason, detail=ending.detail))
            run.journal.close()
        self._note(f"the run {ending.fate} {ending.reason}")
        safe = [(n, c) for n, c in clients.items() if n not in session.unsafe]
        await asyncio.gather(*(client.release(name) for name, client in safe))
        await asyncio.gather(*(client.close() for client in clients.values()))
        return ending.fate == "succeeded"

    def _opened(self) -> tuple[Run | None, Records | None]:
        path = self.folder / "journal.jsonl"
        options = RunOptions(yes=True)
        whole = path.exists() and b"\n" in path.read_bytes()
        if not whole:  # killed before its name was known: another one, in its place
            path.unlink(missing_ok=True)
            SimulatedJournal.lengths.pop(path, None)
            journal = SimulatedJournal(path)
            clock = RunClock.virtual(asyncio.get_running_loop().time)
            return new_run(self.folder, self.checked, options, journal=journal, clock=clock), None
        journal, records, torn = reopen(path, SimulatedJournal)
        history = read_history(records)
        if history.finished is not None and history.finished.fate == "succeeded":
            journal.close()
            return None, None
        run = old_run(self.folder, self.checked, options, journal, history, torn)
        run.clock = RunClock.virtual(asyncio.get_running_loop().time)
        return run, records

    # --- a person, who looks at the instrument once it is idle and says what is true

    def _heard(self, event: Event) -> None:
        if event.event == "goal":
            self._note(f"{event.path} {event.state}")
        if event.event == "log":
            self._note(event.text)
        if event.event == "question" and event.state == "open":
            asyncio.get_running_loop().call_later(5.0, self._answer, event.path)

    def _answer(self, path: str) -> None:
        run = self.run
        if run is None or path not in run.questions.open:
            return
        goal = f"{run.id}/{path.removesuffix('/unknown')}"
        if any(goal in i.under_way for i in self.bench.instruments.values()):
            asyncio.get_running_loop().call_later(5.0, self._answer, path)
            return
        deed = next((deed for deed in self.bench.deeds if deed.goal == goal), None)
        self.outcome.accidents["questions to a person"] += 1
        with contextlib.suppress(Died):
            if deed is None:
                run.questions.answer(path, DID_NOT_HAPPEN, "somebody")
            else:
                run.questions.answer(path, HAPPENED, "somebody", self._read_off(deed))

    def _read_off(self, deed: Deed) -> dict[str, str]:
        """What the instrument shows of what it did, and later steps may need."""
        returns = self.bench.instruments[deed.device].contract.actions[deed.action].returns
        schemas = returns.get("properties", {})
        return {name: str(plainest(schemas[name], None)) for name in returns.get("required", ())}

    # --- accidents

    def _aim(self, loop: SimulatedLoop) -> None:
        loop.strike_at = loop.rounds + self.random.randint(1, ROUNDS) if self.left > 0 else 0

    def _strike(self) -> None:
        loop = asyncio.get_running_loop()
        assert isinstance(loop, SimulatedLoop)
        self.left -= 1
        kinds = [*ACCIDENTS, *(LEDGERS if self.ledgers else POWER)]
        name, strike = self.random.choice(kinds)
        server = self.random.choice(self.servers)
        self._note(f"accident: {name} ({server.instrument.name})")
        self.outcome.accidents[name] += 1
        strike(self, server)
        self._aim(loop)

    def kill_engine(self) -> None:
        """SIGKILL."""
        if self.engine is not None and self.engine.alive:
            self.engine.kill()

    def abort(self) -> None:
        """SIGTERM of the engine."""
        if self.session is not None and self.engine is not None and self.engine.alive:
            token = CURRENT.set(self.engine)
            with contextlib.suppress(Died):
                self.session.control.ask("abort", "SIGTERM")
            CURRENT.reset(token)

    def die_at_write(self) -> None:
        """The engine dies at its next write."""
        SimulatedJournal.doom = self.random.choice(("before", "half", "after"))

    def cut_power(self) -> None:
        """Of engine and servers; the instruments go on."""
        self.kill_engine()
        for server in self.servers:
            server.kill()
            server.disk.lose(self.random)
        if (self.folder / "journal.jsonl").exists():
            lose_journal(self.folder / "journal.jsonl", self.random)

    # --- the verdict

    def _note(self, text: str) -> None:
        text = OUTSIDE.sub("", text.replace(str(self.folder.parent), ""))
        self.outcome.story.append(f"{asyncio.get_running_loop().time():10.3f} s  {text}")

    def _judge(self) -> None:
        breaches = self.outcome.breaches
        deeds = [d for d in self.bench.deeds if not d.goal.startswith(STRANGER)]
        self.outcome.deeds = len(deeds)
        try:
            records = list(read_records(self.folder / "journal.jsonl"))
        except JournalFault as fault:
            breaches.append(str(fault))
            return
        if not (isinstance(records[-1], j.Finished) and records[-1].fate == "succeeded"):
            why = getattr(records[-1], "reason", "").replace(str(self.folder.parent), "")
            breaches.append(f"after {self.outcome.sessions} sessions it had not succeeded: {why}")
        sent = {record.id for record in records if isinstance(record, j.GoalSent)}
        times = Counter(split_goal_id(deed.goal)[0] for deed in deeds)
        for path, count in times.items():
            if count > 1:
                breaches.append(f"{path} was done {count} times")
        breaches += [f"{d.goal} is not in the journal" for d in deeds if d.goal not in sent]
        told = {r.device for r in records if isinstance(r, j.SafeState) and not r.confirmed}
        for name, instrument in self.bench.instruments.items():
            # A server that forgot who had held its device, and that no engine reached: a person was told.
            forgot = name in told and self.outcome.accidents["ledger put back or lost"]
            if not (instrument.is_safe or forgot):
                breaches.append(f"{name} was not left in its safe state")
        sent_s = SimulatedJournal.sent_s
        late_s = NOTICED_S + (STALL_S if self.outcome.accidents["connection stalled"] else 0.0)
        self.outcome.excused = {
            place_of_goal(deed.goal): {
                device
                for device, safe_at_s in deed.safe_at_s.items()
                if safe_at_s > sent_s.get(deed.goal, 0.0) - late_s
            }
            for deed in deeds
        }
        settings = [
            (place_of_goal(record.id), f"{record.device}: {record.sets}", record.params)
            for record in records
            if isinstance(record, j.GoalSent) and record.sets
        ]
        self.outcome.redone = {
            place_of_goal(deed.goal): [
                (what, value)
                for place, what, value in settings
                if place.startswith(f"{turned.string[: turned.end(1)]}/")
            ]
            for deed in deeds
            if (turned := TURN.search(split_goal_id(deed.goal)[0]))
        }
        self.outcome.facts = {place_of_goal(d.goal): _facts(d) for d in deeds}
        if breaches:
            self.outcome.story += [f"{d.at_s:10.3f} s  {d.device} did {d.goal}" for d in deeds]


def place_of_goal(goal: str) -> str:
    """The path of an action, whichever turn of a retried group it was done in."""
    path, before = split_goal_id(goal)[0], ""
    while path != before:
        path, before = TURN.sub(r"\1", path), path
    return path


def _facts(deed: Deed) -> dict[str, Any]:
    return {
        f"{device}: {what}": value
        for device, settings in deed.settings.items()
        for what, value in settings.items()
    }


def compare(outcome: Outcome, right: dict[str, dict[str, Any]]) -> None:
    """What was never done, and what was done while something was set otherwise than undisturbed."""
    for path, wanted in right.items():
        found = outcome.facts.get(path)
        if found is None:
            outcome.breaches.append(f"{path} was never done")
            continue
        excused, redone = outcome.excused[path], outcome.redone.get(path, [])
        wrong = [
            k
            for k, v in wanted.items()
            if found.get(k) != v
            and k.split(":")[0] not in excused
            and (k, found.get(k)) not in redone
        ]
        if wrong:
            told = ", ".join(f"{k} {found.get(k)} instead of {wanted[k]}" for k in wrong)
            outcome.breaches.append(f"{path} was done with {told}")


Strike = Callable[[History, SimulatedServer], None]


def _both(history: History, server: SimulatedServer) -> None:
    history.kill_engine()
    server.kill()


def _away(history: History, server: SimulatedServer) -> None:
    history.kill_engine()
    history.off_until = asyncio.get_running_loop().time() + 45.0


def _put_back(history: History, server: SimulatedServer) -> None:
    server.loses_ledger = True
    server.kill()
    if history.random.random() < 0.5:
        history.kill_engine()


def _stall(history: History, server: SimulatedServer) -> None:
    until = asyncio.get_running_loop().time() + history.random.uniform(0.5, STALL_S)
    history.network.stalled_until[server.url] = until


def _fill_disk(history: History, server: SimulatedServer) -> None:
    until = asyncio.get_running_loop().time() + history.random.choice((0.5, 5.0, 20.0))
    if history.random.random() < 0.5:
        SimulatedJournal.full_until = until
    else:
        server.disk.full_until = until


def _fire_elsewhere(history: History, server: SimulatedServer, left: int = 20) -> None:
    """Another bench has this instrument in its lab, too, by mistake, and scans."""
    actions = server.instrument.contract.actions
    once = [name for name, action in actions.items() if action.effect == "once"]
    if once and left:
        server.instrument.begin(f"{STRANGER}main/shot/{history.random.random()}", once[0], {})
        pause_s = history.random.uniform(0.3, 2.0)
        later = asyncio.get_running_loop().call_later
        later(pause_s, _fire_elsewhere, history, server, left - 1, context=Context())


def _set_clock(history: History, server: SimulatedServer) -> None:
    history.clock_off_s += history.random.choice(
        (-86400.0, -3600.0, -40.0, -5.0, 5.0, 40.0, 3600.0)
    )


ACCIDENTS: list[tuple[str, Strike]] = [
    ("engine killed", lambda h, s: h.kill_engine()),
    ("engine killed at a write", lambda h, s: h.die_at_write()),
    ("engine killed, gone for longer than its leases", _away),
    ("engine ended by SIGTERM", lambda h, s: h.abort()),
    ("server killed", lambda h, s: s.kill()),
    ("server ended by SIGTERM", lambda h, s: s.terminate()),
    ("engine and server killed", _both),
    ("connection cut", lambda h, s: h.network.cut(s.url, h.random.choice((0.1, 2.0, 40.0)))),
    ("connection stalled", _stall),
    ("disk full for some seconds", _fill_disk),
    ("clock set forward or back", _set_clock),
    ("fired by another bench", _fire_elsewhere),
]
POWER: list[tuple[str, Strike]] = [("power cut", lambda h, s: h.cut_power())]
LEDGERS: list[tuple[str, Strike]] = [
    ("ledger copied", lambda h, s: s.copy_ledger()),
    ("ledger put back or lost", _put_back),
]


@contextlib.contextmanager
def _surroundings(history: History) -> Iterator[None]:
    """Time and wire of the simulation, in place of the real ones."""

    class Clock(datetime):
        @classmethod
        def now(cls, tz: Any = None) -> datetime:
            passed = timedelta(seconds=asyncio.get_running_loop().time())
            return BEGAN + passed + timedelta(seconds=history.clock_off_s)

    SimulatedLink.network = history.network
    SimulatedJournal.doom, SimulatedJournal.full_until = "", 0.0
    SimulatedJournal.sent_s = {}
    kept = journal_module.datetime
    journal_module.datetime = Clock  # type: ignore[misc]
    try:
        yield
    finally:
        journal_module.datetime = kept  # type: ignore[misc]
