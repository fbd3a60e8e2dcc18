"""`/labrun/run_protocol`: a whole protocol as one ROS action; feedback is its progress, cancel its abort."""

import asyncio
import json
import math
from collections.abc import Callable
from contextlib import aclosing
from importlib.resources import files
from pathlib import Path
from typing import Any

from ....engine.check import check_file
from ....engine.progress.progress import Progress
from ....engine.run.names import FileFault, inside
from ....schemas.event import Event
from ....system.tasks import end, keep
from ..interfaces.kinds import ActionKind
from ..interfaces.values import ValueFault, from_ros
from .engine_process import EngineProcess, start_run
from .goals import aborted, result_of
from .offer import Action, End, Refused, Values, Work

NAME = "/labrun/run_protocol"
SUFFIXES = (".yaml", ".yml", ".json")
FEEDBACK_S = 0.1
OPTIONS = {"params": "-p", "bind": "--bind", "answers": "--answer"}


class RunProtocol(Action):
    """Runs protocols from the folder or shipped ones; `before` frees the devices for it."""

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
        """Protocols registered by name in the lab, in any folder."""

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
        """The protocol's file; raises Refused. No other file outside the folder is ever opened."""
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
            f"there is no protocol {name!r} in {self._protocols}, and no shipped one has that name"
        )

    async def _checked(self, path: Path, options: dict[str, dict[str, str]]) -> None:
        checked = await asyncio.to_thread(
            check_file, path, lab=self._lab, params=options["-p"], bind=options["--bind"]
        )
        faults = [problem for problem in checked.problems if problem.severity == "error"]
        if faults:
            hear = "\n".join(
                f"{p.file}:{p.line}:{p.column}: {p.code}: {p.message}" for p in faults[:12]
            )
            raise Refused(f"{hear}\nNothing was sent to any device.")

    async def _followed(self, engine: EngineProcess, work: Work) -> End:
        hear = _Told(work)
        aborting = keep(
            f"the abort of {work.id}", lambda: self._abort_when_asked(engine, work, hear)
        )
        try:
            async with aclosing(engine.events()) as events:
                async for event in events:
                    hear.take(event)
        finally:
            await end(aborting)
        return self._ending(engine, work, hear)

    async def _abort_when_asked(self, engine: EngineProcess, work: Work, hear: "_Told") -> None:
        await work.cancelled.wait()
        await hear.named.wait()  # without a name it cannot be contacted
        await engine.abort(self._runs / hear.run, self._by)

    def _ending(self, engine: EngineProcess, work: Work, hear: "_Told") -> End:
        data = {"run": hear.run, "fate": hear.fate, "holes": hear.holes, "outputs": hear.outputs}
        if hear.fate == "succeeded":
            return End("SUCCEEDED", result_of(self, data))
        if hear.fate == "aborted" and work.cancelled.is_set():
            return End("CANCELED", result_of(self, data, "Canceled", "as asked"))
        if hear.fate:
            words = hear.words or f"the run {hear.fate}; {self._runs / hear.run / 'report.html'}"
            return aborted(
                self, "Stopped" if hear.fate == "aborted" else "Failed", words, "unknown", **data
            )
        words = engine.last_words() or "the engine ended without any output"
        happened = "unknown" if hear.run else "no"
        return aborted(self, "Lost" if hear.run else "NotStarted", words, happened, **data)


class _Told:
    """The events of a run so far."""

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
        """Process an event; changes are sent to the client, at most ten times a second."""
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
    """A goal's JSON object as command line options; raises Refused."""
    if given is None:
        return {}
    if not isinstance(given, dict):
        raise Refused(f'{name}_json must be a JSON object, such as {{"name": 1}}')
    odd = [key for key in given if not key or "=" in key or "\0" in f"{key}{given[key]}"]
    if odd:
        raise Refused(f"{name}_json: {odd[0]!r} is not a name, or its value is not a string")
    return {
        key: value if isinstance(value, str) else json.dumps(value) for key, value in given.items()
    }
