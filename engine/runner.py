"""The life of a run: connect, main, finally, safe state, report; and the same again on resume."""

import asyncio
import contextlib
import platform
import shutil
import signal
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from py_trees.behaviour import Behaviour

from .. import __version__
from ..schemas import journal as j
from ..schemas.protocol import Protocol
from .check import Checked
from .clock import RunClock
from .compile import TreeCompiler
from .connect import connect
from .control import Control
from .control_server import ControlServer
from .dispatcher import Dispatcher
from .encode import encode
from .failure import Failure
from .frame import Frame, Scope
from .history import History, read_history
from .journal import DiskFull, Journal, JournalFault, read_records
from .language.expression import ExpressionError
from .language.value import value_of
from .nodes.node import failure_of
from .questions import Questions
from .reached import Reached
from .reports import make_reports
from .rows import restore_rows
from .run import Listener, Run
from .run_files import sync_files
from .run_folder import CONTRACTS, COPIES, hashes
from .safe import note_touched, settle, strangers, to_safe_state, touched
from .tick import NoRoom, StopNow, run_tree

LINKS_S = 1.0
"""Within that time every link to a server that was started anew has found it again."""
FINALLY_S = 600.0
"""The time that `finally` has in all."""

Watcher = Callable[[Run, Control], Listener]


@dataclass(slots=True)
class Wishes:
    """What the person who started a run wants beside its protocol."""

    yes: bool = False
    answers: dict[str, str] = field(default_factory=dict)
    watchers: list[Watcher] = field(default_factory=list)


@dataclass(slots=True)
class Ending:
    """How a run ended; `interrupted` when Ctrl-C ended it."""

    fate: j.RunFate
    reason: str = ""
    interrupted: bool = False


class Life:
    """One engine's share of a run: from its connection to its last record."""

    def __init__(self, run: Run, checked: Checked, clients: Mapping[str, Reached]) -> None:
        assert checked.protocol is not None and checked.survey is not None
        self.run = run
        self.protocol: Protocol = checked.protocol
        self.survey = checked.survey
        self.names = {"params": run.params, "run": run.about, "csv": self.survey.tables}
        self.clients = clients
        self.dispatcher = Dispatcher(run, clients)
        self.control = Control(run, self.dispatcher.wake.set)
        self.by_strangers: set[str] = set()
        self._plant()

    def _plant(self) -> None:
        """A fresh tree: what the run's history says is done, it takes as done."""
        self.compiler = TreeCompiler(self.run, self.dispatcher, self.survey, self.run.folder)
        self.main_frame = Frame.phase("main", self.names)
        self.run.cut_off.clear()
        self.main = self.compiler.sequence(self.protocol.steps, Scope(self.main_frame))

    async def live(self, records: list[j.JournalRecord] | None) -> Ending:
        """Everything from the first phase to the safe state; never leaves a goal under way."""
        if records is not None:
            restore_rows(self.run.folder, records, self.compiler.tables)
        ending = Ending("failed")
        self.by_strangers = strangers(self.run, self.clients)
        self.dispatcher.look_anew()
        try:
            ending = await self._phases(resumed=records is not None)
        except StopNow:
            ending = Ending("aborted", f"stopped at once by {self.control.aborted_by}")
        except (NoRoom, DiskFull, JournalFault) as fault:
            ending = await self._out_of_room(str(fault))
        finally:
            await self._make_safe()
            await self.dispatcher.close()
        ending.interrupted = self.control.aborted_by == "Ctrl-C"
        return ending

    async def _phases(self, *, resumed: bool) -> Ending:
        if resumed:
            history = self.run.history
            await settle(self.run, self.dispatcher, self.control)
            note_touched(self.run, self.clients, _away_s(history), self.by_strangers)
            if history.finished is None:  # the engine was killed: nobody has cleaned up
                await self._finally()
                await self._make_safe()
            on_resume = await self._on_resume()
            if on_resume is not None:
                return await self._then_finally(on_resume)
        while True:
            self._begin("main")
            ended = await run_tree(
                self.main, self.run, self.dispatcher, self.control, abortable=True, watchful=True
            )
            if ended != "touched":
                return await self._then_finally(self._ending(ended, "main"))
            on_resume = await self._take_up_again()
            if on_resume is not None:
                return await self._then_finally(on_resume)

    async def _take_up_again(self) -> Ending | None:
        """A device lost its state under a living engine: go on as after a crash, from the journal.

        Without `finally`, since nobody was away: `on_resume`, then the unfinished iterations, in
        which the finished steps of that device are repeated before anything else is done once.
        """
        if self.dispatcher.touched():
            # A server with several devices is seen anew by each one's link, a moment apart.
            await asyncio.sleep(LINKS_S)
        lost = self.dispatcher.touched()
        for device, reason in lost.items():
            touched(self.run, device, reason)
            self.run.log(f"{device}: {reason}; going on from the journal")
        if self.run.taken_up:
            self.run.record(j.Again())
            self.run.taken_up = False
        self.run.journal.flush()
        records = list(read_records(self.run.journal.path))
        self.run.history = read_history(records)
        self.run.history.resumes += bool(lost)
        self.run.holes = self.run.history.holes
        self.run.repeated.clear()
        self.dispatcher.look_anew()
        self._plant()
        restore_rows(self.run.folder, records, self.compiler.tables)
        await settle(self.run, self.dispatcher, self.control)
        return await self._on_resume() if lost else None

    async def _on_resume(self) -> Ending | None:
        """Run `on_resume`; an ending where it did not succeed."""
        steps = self.protocol.on_resume
        if not steps:
            return None
        phase = f"resume:{self.run.history.resumes}"
        self._begin(phase)
        root = self.compiler.sequence(steps, Scope(Frame.phase(phase, self.names)))
        ended = await run_tree(root, self.run, self.dispatcher, self.control, abortable=True)
        if ended == "succeeded":
            return None
        return self._ending(ended, phase, failure_of(root))

    def _ending(self, ended: str, phase: str, failure: Failure | None = None) -> Ending:
        if ended == "aborted":
            return Ending("aborted", f"aborted by {self.control.aborted_by}")
        if ended == "failed":
            failure = failure or failure_of(self.main)
            reason = failure.sentence() if phase == "main" else f"{phase}: {failure.sentence()}"
            return Ending("aborted" if failure.stop else "failed", reason)
        return Ending("succeeded")

    async def _then_finally(self, ending: Ending) -> Ending:
        failure = await self._finally()
        if failure is not None:
            reason = f"finally: {failure}"
            ending.reason = f"{ending.reason}; {reason}" if ending.reason else reason
            ending.fate = "failed" if ending.fate == "succeeded" else ending.fate
        return ending

    async def _finally(self) -> str | None:
        """Run every `finally` that is due, never cut short by the abort that caused it.

        Those of used protocols that were stopped come first, the innermost before all. Returns a
        sentence if one failed; the others run all the same.
        """
        if not self.protocol.finally_ and not self.run.cut_off:
            return None
        self.run.history.finals += 1
        phase = f"finally:{self.run.history.finals}"
        self._begin(phase)
        failures: list[str] = []
        try:
            async with asyncio.timeout(FINALLY_S):
                for root in self._finals(phase):
                    ended = await run_tree(
                        root, self.run, self.dispatcher, self.control, abortable=False
                    )
                    if ended != "succeeded":
                        failures.append(failure_of(root).sentence())
        except TimeoutError:
            return f"not over within {FINALLY_S:g} s"
        return "; ".join(failures) or None

    def _finals(self, phase: str) -> Iterator[Behaviour]:
        cut_off, self.run.cut_off = self.run.cut_off, {}
        for path, left in reversed(cut_off.items()):
            yield left.build(Scope(Frame.phase(f"{phase}/{path}", left.names, left.frame)))
        if self.protocol.finally_:
            frame = Frame.phase(phase, self.names, self.main_frame)
            yield self.compiler.sequence(self.protocol.finally_, Scope(frame))

    def _begin(self, phase: str) -> None:
        self.run.history.phase = phase
        self.run.record(j.Phase(phase=phase))
        self.run.tell("phase", phase)

    async def _out_of_room(self, reason: str) -> Ending:
        """The disk is full: end what runs, try `finally` in the room that was kept for it."""
        self.run.log(reason)
        ending = Ending("failed", reason)
        with contextlib.suppress(StopNow, NoRoom, DiskFull, JournalFault):
            await self.dispatcher.drain(60.0, stop=lambda: self.control.now)
            self.dispatcher.disk_full = ""
            ending = await self._then_finally(ending)
        return ending

    async def _make_safe(self) -> None:
        await to_safe_state(self.run, self.dispatcher, self.clients)

    def outputs(self) -> dict[str, object]:
        """The protocol's outputs; one that cannot be told is null."""
        told: dict[str, object] = {}
        for name, raw in self.protocol.outputs.items():
            try:
                told[name] = value_of(raw).evaluate(self.main_frame.names)
            except ExpressionError as fault:
                told[name] = None
                self.run.log(f"output {name!r}: {fault}")
        return told


def new_run(
    folder: Path, checked: Checked, wishes: Wishes, *, journal: Journal | None = None,
    clock: RunClock | None = None,
) -> Run:  # fmt: skip
    """A run at its very beginning, its journal open."""
    assert checked.protocol is not None
    journal = journal or Journal(folder / "journal.jsonl")
    run = _run(folder, checked, wishes, journal, History())
    run.clock = clock or run.clock
    run.record(
        j.Started(
            run=run.id, protocol=checked.protocol.name, labrun=__version__,
            python=platform.python_version(), began=run.about["started"], params=encode(checked.params),
            roles={name: role.device for name, role in checked.roles.items()},
            files=hashes(folder),
        )
    )  # fmt: skip
    return run


def old_run(
    folder: Path, checked: Checked, wishes: Wishes, journal: Journal, history: History, torn: int
) -> Run:
    """A run that goes on from its journal."""
    if history.finished is not None:
        history.spend()
    history.resumes += 1
    run = _run(folder, checked, wishes, journal, history)
    run.holes = history.holes
    history.resumed_n = run.record(
        j.Resumed(count=history.resumes, labrun=__version__, torn=torn)
    )  # fmt: skip
    return run


def _run(folder: Path, checked: Checked, wishes: Wishes, journal: Journal, history: History) -> Run:
    assert checked.protocol is not None and checked.lab is not None
    about = {
        "id": folder.name,
        "name": checked.protocol.name,
        "simulated": checked.lab.lab.simulated,
        "started": history.started.began if history.started else _now(),
    }
    return Run(
        id=folder.name, folder=folder, journal=journal, history=history, roles=checked.roles,
        params=checked.params, about=about,
        questions=Questions(yes=wishes.yes, answers=wishes.answers),
    )  # fmt: skip


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _away_s(history: History) -> float:
    """How long no engine has written to the journal."""
    return (datetime.now(UTC) - datetime.fromisoformat(history.last_at)).total_seconds()


async def run_life(
    run: Run, checked: Checked, wishes: Wishes, records: list[j.JournalRecord] | None = None
) -> Ending:
    """Connect, live, and end a run; raises NotReached before anything was sent.

    A new run whose devices cannot be reached leaves no folder behind.
    """
    assert checked.lab is not None
    loop = asyncio.get_running_loop()
    try:
        connections = await connect(checked.roles, checked.lab, run.folder, run.id)
    except BaseException:
        with contextlib.suppress(JournalFault, DiskFull):
            run.journal.close()
        if records is None:
            shutil.rmtree(run.folder, ignore_errors=True)
        raise
    life = Life(run, checked, connections.clients)
    connections.say = run.log
    run.questions.changed = life.dispatcher.wake.set
    endpoint = ControlServer(run.folder, life.control, run.questions)
    with _signals(loop, life.control):
        try:
            await endpoint.open()
            run.listeners.append(endpoint.publish)
            for watcher in wishes.watchers:
                run.listeners.append(watcher(run, life.control))
            # From here on the run's name is known to a person, and so the run must last.
            run.journal.flush()
            sync_files(run.folder, CONTRACTS, COPIES)
            run.tell("run", run.id, "running", checked.protocol.name if checked.protocol else "")
            ending = await life.live(records)
            await _end(run, life, ending)
            return ending
        finally:
            await endpoint.close()
            await connections.close()


async def _end(run: Run, life: Life, ending: Ending) -> None:
    """The last record, then the reports: they read what the journal says."""
    outputs = life.outputs() if ending.fate == "succeeded" else {}
    try:
        run.record(
            j.Finished(
                fate=ending.fate, reason=ending.reason, holes=run.holes, outputs=encode(outputs)
            )
        )
        run.journal.close()
    except (JournalFault, DiskFull) as fault:
        ending.reason = (
            f"{ending.reason}; {fault}" if str(fault) not in ending.reason else ending.reason
        )
    made, failed = await asyncio.to_thread(make_reports, run.folder)
    for path in made:
        run.tell("report", text=str(path))
    for line in failed:
        run.log(line)
    run.tell(
        "finished", run.id, ending.fate, ending.reason, holes=run.holes, outputs=encode(outputs),
        folder=str(run.folder),
    )  # fmt: skip


@contextlib.contextmanager
def _signals(loop: asyncio.AbstractEventLoop, control: Control):
    """Ctrl-C, SIGTERM and SIGHUP abort the run while it lives."""
    names = {"SIGINT": "Ctrl-C", "SIGTERM": "SIGTERM", "SIGHUP": "SIGHUP"}
    taken: list[int] = []
    for name, by in names.items():
        number = getattr(signal, name, None)
        if number is None:
            continue
        with contextlib.suppress(NotImplementedError, RuntimeError, ValueError):
            loop.add_signal_handler(number, control.ask, "abort", by)
            taken.append(number)
    try:
        yield
    finally:
        for number in taken:
            loop.remove_signal_handler(number)
