"""Start runs, and let them go on: each in an engine of its own, found again after a restart."""

import asyncio
import json
import os
import subprocess
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from ...drivers.presence import alive
from ...engine.control_server import FILE
from ..bench.bench import Bench
from ..clock import now_iso
from ..durable import write_durable
from ..guard.headers import Deadline
from ..guard.refusal import Refusal, not_found
from ..models.protocols import CheckText, Hazard
from ..models.runs import Launch, LaunchState, ResumeRun, StartRun
from ..models.settings import Settings
from ..shelf.form import hazards_of
from ..shelf.looking import Looking
from ..shelf.shelf import Shelf
from .engine import UP_S, last_words, run_told, start_engine
from .inputs import LAUNCH
from .runs import Runs
from .watched import Watched

ANSWER_S = 2.0
LOOK_S = 0.03
OVER_S = 0.5
KEPT_S = 24 * 3600.0
LONGEST_ARGUMENT = 100_000


@dataclass(slots=True)
class _Launched:
    """An engine that was started, as far as this server knows it."""

    id: str
    pid: int
    log: Path
    devices: list[str]
    said: Launch | None
    process: "subprocess.Popen[bytes] | None" = None
    run: str | None = None
    state: Literal["starting", "running", "failed", "ended"] = "starting"
    message: str = ""

    def told(self) -> LaunchState:
        state = self.state
        if state == "running" and not self.is_alive:
            state = "ended"
        return LaunchState(id=self.id, run=self.run, state=state, message=self.message)

    @property
    def is_alive(self) -> bool:
        if self.process is not None:
            return self.process.poll() is None
        return alive(self.pid)


class Launching:
    """`state` keeps a small file for each launch, `lab` is the lab file that runs get."""

    def __init__(
        self, shelf: Shelf, looking: Looking, bench: Bench, runs: Runs, state: Path, lab: Path,
        settings: Callable[[], Settings], changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._shelf = shelf
        self._looking = looking
        self._bench = bench
        self._runs = runs
        self._state = state
        self._lab = lab
        self._settings = settings
        self._changed = changed
        self._launched: dict[str, _Launched] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def open(self) -> None:
        """Find the launches of an earlier server again."""
        for path in self._state.glob("*.json") if self._state.is_dir() else ():
            if time.time() - path.stat().st_mtime > KEPT_S:
                path.unlink()
                path.with_suffix(".log").unlink(missing_ok=True)
                continue
            told = json.loads(path.read_bytes())
            said = Launch.model_validate(told["said"]) if told["said"] else None
            found = _Launched(
                told["id"], told["pid"], path.with_suffix(".log"), told["devices"], said
            )
            self._launched[found.id] = found
            self._follow(found)

    async def close(self) -> None:
        """Follow no more; engines go on."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def states(self) -> dict[str, LaunchState]:
        """All launches of the last day."""
        return {id: one.told() for id, one in self._launched.items()}

    def known(self, id: str) -> LaunchState | None:
        """One of them, or None."""
        return self._launched[id].told() if id in self._launched else None

    def launch(self, id: str) -> LaunchState:
        """One of them; raises Refusal (404)."""
        found = self.known(id)
        if found is None:
            raise not_found("launch", id)
        return found

    async def start(self, asked: StartRun, by: str, key: str, deadline: Deadline) -> LaunchState:
        """Check, and start an engine."""
        text = self._shelf.read(asked.protocol)
        if asked.revision is not None and asked.revision != text.revision:
            raise Refusal(
                409, "CHANGED", f"{asked.protocol} was saved since you looked at it",
                "look at it again, then start it",
            )  # fmt: skip
        look = CheckText(text=text.text, name=asked.protocol, params=asked.params, bind=asked.bind)
        checked = await self._looking.for_a_run(look)
        self._check_list(checked.hazards, asked.checklist)
        devices = sorted({role.device for role in checked.roles if role.device is not None})
        self._check_devices(devices)
        arguments = ["run", str(self._shelf.folder / asked.protocol), "--lab", str(self._lab)]
        arguments += ["--runs", str(self._runs.folder)]
        arguments += _options("-p", {n: text_of(v) for n, v in asked.params.items()})
        arguments += _options("--bind", asked.bind) + _options("--answer", asked.answers)
        said = Launch(
            operator=asked.operator or by, note=asked.note, checklist=asked.checklist, at=now_iso()
        )
        deadline.check()
        return await self._launch(arguments, key, devices, said)

    async def resume(
        self, id: str, asked: ResumeRun, by: str, key: str, deadline: Deadline
    ) -> LaunchState:
        """Let a run go on in a new engine."""
        run = await self._runs.opened(id)
        await _until_gone(run)
        if run.fate == "starting":
            raise Refusal(409, "LIVE", f"{run.id} is starting", "wait until its engine is heard")
        checked = run.inputs.checked
        if checked is not None and checked.survey is not None:
            self._check_list(hazards_of(checked), asked.checklist)
        devices = sorted(set(run.picture.roles.values()) & set(self._bench.stations))
        self._check_devices(devices)
        arguments = ["resume", str(run.folder), *_options("--answer", asked.answers)]
        arguments += _options("-p", {n: text_of(v) for n, v in asked.params.items()})
        if asked.protocol is not None:
            self._shelf.read(asked.protocol)
            arguments += ["--changed", str(self._shelf.folder / asked.protocol)]
        arguments += ["--yes"] if asked.yes else []
        deadline.check()
        return await self._launch(arguments, key, devices, None, run)

    # --- before

    def _check_list(self, hazards: list[Hazard], ticked: list[str]) -> None:
        """Raise Refusal (422) where a point of the checklist of a danger is not ticked."""
        lists = self._settings().checklists
        wanted = [point for one in hazards for point in lists.get(one.danger, [])]
        missing = [point for point in dict.fromkeys(wanted) if point not in ticked]
        if missing:
            raise Refusal(
                422, "CHECKLIST", f"not ticked: {', '.join(missing)}",
                "tick what is so, and start again", details={"missing": missing},
            )  # fmt: skip

    def _check_devices(self, devices: list[str]) -> None:
        """Raise Refusal where a device is lost, or used by somebody."""
        for name in devices:
            station = self._bench.station(name)
            user = self._bench.user(name)
            if user is not None:
                raise Refusal(
                    409, "HELD", f"{name} is used by {user}", details={"run": user, "device": name}
                )
            station.reached()
            if station.turn.locked():
                raise Refusal(409, "BUSY", f"{name} is busy with an action by hand")

    # --- the engine

    async def _launch(
        self, arguments: list[str], key: str, devices: list[str], said: Launch | None,
        run: Watched | None = None,
    ) -> LaunchState:  # fmt: skip
        _check_arguments(arguments)
        id = sha256(key.encode()).hexdigest()[:16]
        log = self._state / f"{id}.log"
        self._runs.reserved |= dict.fromkeys(devices, "a run that is starting")
        try:
            process = await asyncio.to_thread(start_engine, arguments, log, self._shelf.folder)
        except OSError as fault:
            self._release(devices)
            raise Refusal(500, "NO_ENGINE", f"no engine could be started: {fault}") from fault
        found = _Launched(id, process.pid, log, devices, said, process)
        self._launched[id] = found
        told = {
            "id": id, "pid": process.pid, "devices": devices,
            "said": said.model_dump() if said is not None else None,
        }  # fmt: skip
        write_durable(self._state / f"{id}.json", json.dumps(told).encode())
        task = self._follow(found)
        await asyncio.wait({task}, timeout=ANSWER_S)
        return found.told()

    def _follow(self, found: _Launched) -> "asyncio.Task[None]":
        return self._begin(self._until_up(found))

    def _begin(self, work: Coroutine[Any, Any, None]) -> "asyncio.Task[None]":
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _until_up(self, found: _Launched) -> None:
        """Until the engine has told its run, or ended; then it is the run that is followed."""
        until = time.monotonic() + UP_S
        try:
            while time.monotonic() < until:
                living = found.is_alive
                found.run = run_told(found.log)
                if found.run is not None:
                    found.state = "running" if living else "ended"
                    await self._arrived(found)
                    self._begin(self._until_over(found))
                    return
                if not living:
                    break
                await asyncio.sleep(LOOK_S)
            found.state, found.message = "failed", last_words(found.log)
        finally:
            self._release(found.devices)
            self._changed(found.id)

    async def _until_over(self, found: _Launched) -> None:
        """Until the engine has ended; one that was our child leaves nothing behind then."""
        while True:
            if not found.is_alive:
                self._changed(found.id)
                return
            await asyncio.sleep(OVER_S)

    async def _arrived(self, found: _Launched) -> None:
        """The run is there: write down what its starter said, and begin to listen."""
        assert found.run is not None
        folder = self._runs.folder / Path(found.run).name
        if found.said is not None and folder.is_dir() and not (folder / LAUNCH).exists():
            data = found.said.model_dump_json(indent=1).encode()
            await asyncio.to_thread(write_durable, folder / LAUNCH, data)
        try:
            run = await self._runs.opened(folder.name)
        except Refusal:
            return  # gone again: its folder was taken away
        run.learn_launch()
        if (folder / FILE).exists():
            await run.hear()

    def _release(self, devices: list[str]) -> None:
        for device in devices:
            self._runs.reserved.pop(device, None)


async def _until_gone(run: Watched) -> None:
    """Wait a moment for an engine that writes its report; raises Refusal while one is there."""
    until = time.monotonic() + ANSWER_S
    while run.live and run.picture.finished is not None:
        if time.monotonic() > until:
            break
        await asyncio.sleep(LOOK_S)
    if run.live:
        words = "is still writing its report" if run.picture.finished else "is running"
        raise Refusal(409, "LIVE", f"{run.id} {words}", "wait until it is over")


def _options(option: str, given: dict[str, str]) -> list[str]:
    return [part for name, value in given.items() for part in (option, f"{name}={value}")]


def _check_arguments(arguments: list[str]) -> None:
    """Raise Refusal (422) for a text that no process can be given."""
    for text in arguments:
        try:
            fits = "\0" not in text and len(os.fsencode(text)) <= LONGEST_ARGUMENT
        except UnicodeEncodeError:
            fits = False
        if not fits:
            name = ascii(text[:60])
            raise Refusal(
                422, "INVALID", f"{name} is too long, or has a character that is none in it",
                f"parameters and answers are text of at most {LONGEST_ARGUMENT:,} bytes",
            )  # fmt: skip


def text_of(value: Any) -> str:
    """A value as the command line has it."""
    return value if isinstance(value, str) else json.dumps(value)
