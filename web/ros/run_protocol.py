"""`/labrun/run_protocol`: a whole protocol as one ROS action; feedback is its progress, cancel its abort."""

import asyncio
import json
import math
from collections.abc import Callable
from contextlib import aclosing
from importlib.resources import files
from pathlib import Path
from typing import Any

from ...engine.check import check_file
from ...engine.run_files import FileFault, inside
from ...engine.watch.progress import Progress
from ...schemas.event import Event
from .engine_process import EngineProcess, start_run
from .goals import aborted, result_of
from .kinds import ActionKind
from .offer import Action, End, Refused, Values, Work
from .values import ValueFault, from_ros

NAME = "/labrun/run_protocol"
SUFFIXES = (".yaml", ".yml", ".json")
FEEDBACK_S = 0.1
OPTIONS = {"params": "-p", "bind": "--bind", "answers": "--answer"}


class RunProtocol(Action):
    """Runs what lies in the folder of protocols, or ships; `before` frees the devices for it."""

    close_s = 60.0  # an abort runs `finally` and the safe state

    def __init__(
        self, kind: ActionKind, protocols: Path, runs: Path, lab: Path, state: Path,
        before: Callable[[], Any], by: str,
    ) -> None:  # fmt: skip
        self.name = NAME
        self.kind = kind
        self._protocols = protocols.resolve()
        self._runs = runs.resolve()
        self._lab = lab.resolve()
        self._state = state.resolve()
        self._before = before
        self._by = by
        self.registered: dict[str, Path] = {}
        """Protocols that bear a name of the lab's, wherever they lie."""

    async def carry(self, work: Work) -> End:
        """Check, start an engine, follow it."""
        try:
            asked = from_ros(self.kind.goal, work.values)
        except ValueFault as fault:
            raise Refused(str(fault)) from fault
        path = self.found(str(asked.get("protocol", "")))
        options = {option: _pairs(name, asked.get(name)) for name, option in OPTIONS.items()}
        await self._checked(path, options)
        await self._before()
        log = self._state / "launches" / f"{work.id}.log"
        try:
            engine = start_run(path, options, self._lab, self._runs, log)
        except OSError as fault:
            raise Refused(f"no engine could be started: {fault}") from fault
        work.begun.set()
        return await self._followed(engine, work)

    def found(self, name: str) -> Path:
        """The protocol's file; raises Refused. Nothing else outside the folder is ever opened."""
        if name in self.registered:
            return self.registered[name]
        try:
            path = inside(self._protocols, name).resolve()
        except FileFault as fault:
            raise Refused(f"protocol: {fault}") from fault
        if path.is_file() and path.is_relative_to(self._protocols) and path.suffix in SUFFIXES:
            return path
        shipped = Path(str(files("labrun.protocols")))
        for suffix in ("", *SUFFIXES):
            path = shipped / f"{name}{suffix}"
            if path.parent == shipped and path.suffix in SUFFIXES and path.is_file():
                return path
        raise Refused(
            f"there is no protocol {name!r} in {self._protocols}, and none ships by that name"
        )

    async def _checked(self, path: Path, options: dict[str, dict[str, str]]) -> None:
        checked = await asyncio.to_thread(
            check_file, path, lab=self._lab, params=options["-p"], bind=options["--bind"]
        )
        faults = [problem for problem in checked.problems if problem.severity == "error"]
        if faults:
            told = "\n".join(
                f"{p.file}:{p.line}:{p.column}: {p.code}: {p.message}" for p in faults[:12]
            )
            raise Refused(f"{told}\nNothing was sent to any device.")

    async def _followed(self, engine: EngineProcess, work: Work) -> End:
        told = _Told(work)
        aborting = asyncio.create_task(self._abort_when_asked(engine, work, told))
        try:
            async with aclosing(engine.events()) as events:
                async for event in events:
                    told.take(event)
        finally:
            aborting.cancel()
            await asyncio.gather(aborting, return_exceptions=True)
        return self._ending(engine, work, told)

    async def _abort_when_asked(self, engine: EngineProcess, work: Work, told: "_Told") -> None:
        await work.cancelled.wait()
        await told.named.wait()  # before it has a name there is nobody to ask
        await engine.abort(self._runs / told.run, self._by)

    def _ending(self, engine: EngineProcess, work: Work, told: "_Told") -> End:
        data = {"run": told.run, "fate": told.fate, "holes": told.holes, "outputs": told.outputs}
        if told.fate == "succeeded":
            return End("SUCCEEDED", result_of(self, data))
        if told.fate == "aborted" and work.cancelled.is_set():
            return End("CANCELED", result_of(self, data, "Canceled", "as asked"))
        if told.fate:
            words = told.words or f"the run {told.fate}; {self._runs / told.run / 'report.html'}"
            return aborted(
                self, "Stopped" if told.fate == "aborted" else "Failed", words, "unknown", **data
            )
        words = engine.last_words() or "the engine ended without a word"
        happened = "unknown" if told.run else "no"
        return aborted(self, "Lost" if told.run else "NotStarted", words, happened, **data)


class _Told:
    """What a run has told so far."""

    def __init__(self, work: Work) -> None:
        self.run = self.fate = self.words = ""
        self.holes = 0
        self.outputs: Any = None
        self.named = asyncio.Event()
        self._work = work
        self._progress = Progress()
        self._last = ("", "", -1)
        self._at = 0.0

    def take(self, event: Event) -> None:
        """Learn from an event; what is new is told to the client, ten times a second at most."""
        self._progress.take(event)
        if event.event == "run" and not self.run:
            self.run = event.path
            self.named.set()
        elif event.event == "finished":
            self.fate, self.words = event.state, event.text
            self.holes = int(event.data.get("holes", 0))
            self.outputs = event.data.get("outputs")
        now = asyncio.get_running_loop().time()
        feedback = self._feedback()
        new = (feedback["message"], feedback["phase"], feedback["done"])
        if new != self._last and (
            now - self._at >= FEEDBACK_S or feedback["done"] != self._last[2]
        ):
            self._last, self._at = new, now
            self._work.tell(feedback)

    def _feedback(self) -> Values:
        loop = next(iter(self._progress.loops.values()), None)
        done, total = (loop.done, loop.total or 0) if loop is not None else (0, 0)
        return {
            "progress": done / total if total else math.nan, "message": self._progress.now(),
            "run": self.run, "phase": self._progress.phase, "done": done, "total": total,
        }  # fmt: skip


def _pairs(name: str, given: Any) -> dict[str, str]:
    """A goal's JSON object as the command line has it; raises Refused."""
    if given is None:
        return {}
    if not isinstance(given, dict):
        raise Refused(f'{name}_json has to be a JSON object, such as {{"name": 1}}')
    odd = [key for key in given if not key or "=" in key or "\0" in f"{key}{given[key]}"]
    if odd:
        raise Refused(f"{name}_json: {odd[0]!r} is no name, or its value no text")
    return {
        key: value if isinstance(value, str) else json.dumps(value) for key, value in given.items()
    }
