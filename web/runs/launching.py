"""Start and resume runs, each in a separate engine that is found again after a restart."""

import asyncio
import json
import os
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from ...engine.control.server import FILE
from ...engine.run.labels import LAUNCH
from ...system.files import remove, write_whole
from ...system.process import alive
from ...system.tasks import end, in_time, spawn
from ..access.headers import Deadline
from ..devices.devices import DeviceLinks
from ..library.form import hazards_of
from ..library.library import Library
from ..library.text_check import TextCheck
from ..local.clock import now_iso
from ..local.refusal import Refusal, not_found
from ..local.room import no_room
from ..models.protocols import CheckText, Hazard
from ..models.runs import Launch, LaunchState, ResumeRun, StartRun
from ..models.settings import Settings
from .engine import UP_S, last_words, run_told, start_engine
from .open_run import OpenRun
from .runs import Runs

ANSWER_S = 2.0
LOOK_S = 0.03
OVER_S = 0.5
KEPT_S = 24 * 3600.0
LONGEST_ARGUMENT = 100_000


@dataclass(slots=True)
class _Launched:
    """A started engine, as far as this server knows it."""

    id: str
    pid: int
    log: Path
    devices: list[str]
    said: Launch | None
    process: "subprocess.Popen[bytes] | None" = None
    run: str | None = None
    state: Literal["starting", "running", "failed", "ended"] = "starting"
    message: str = ""
    known: asyncio.Event = field(default_factory=asyncio.Event)
    """Set once its run is known, or that there will be none."""

    def state_now(self) -> LaunchState:
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
    """`state` holds a small file for each launch, `lab` is the lab file that runs get."""

    def __init__(
        self, library: Library, text_check: TextCheck, device_links: DeviceLinks, runs: Runs,
        state: Path, lab: Path, settings: Callable[[], Settings], changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._library = library
        self._text_check = text_check
        self._device_links = device_links
        self._runs = runs
        self._state = state
        self._lab = lab
        self._settings = settings
        self._changed = changed
        self._launched: dict[str, _Launched] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def open(self) -> None:
        """Find the launches of an earlier server process."""
        for path in self._state.glob("*.json") if self._state.is_dir() else ():
            if time.time() - path.stat().st_mtime > KEPT_S:
                remove(path)
                remove(path.with_suffix(".log"))
                continue
            record = json.loads(path.read_bytes())
            said = Launch.model_validate(record["said"]) if record["said"] else None
            found = _Launched(
                record["id"],
                record["pid"],
                path.with_suffix(".log"),
                record["devices"],
                said,
            )
            self._launched[found.id] = found
            self._follow(found)

    async def close(self) -> None:
        """Stop following; engines continue."""
        await end(*self._tasks)

    def ids(self) -> list[str]:
        """Those of all launches of the last day."""
        return list(self._launched)

    def known(self, id: str) -> LaunchState | None:
        """One of them, or None."""
        return self._launched[id].state_now() if id in self._launched else None

    def launch(self, id: str) -> LaunchState:
        """One of them; raises Refusal (404)."""
        found = self.known(id)
        if found is None:
            raise not_found("launch", id)
        return found

    async def start(self, asked: StartRun, by: str, key: str, deadline: Deadline) -> LaunchState:
        """Check, and start an engine."""
        text = self._library.read(asked.protocol)
        if asked.revision is not None and asked.revision != text.revision:
            raise Refusal(
                409, "CHANGED", f"{asked.protocol} was saved since you looked at it",
                "review it, then start it",
            )  # fmt: skip
        look = CheckText(text=text.text, name=asked.protocol, params=asked.params, bind=asked.bind)
        checked = await self._text_check.for_a_run(look)
        self.check_list(checked.hazards, asked.checklist)
        devices = sorted({role.device for role in checked.roles if role.device is not None})
        await self._check_devices(devices)
        self._check_room()
        arguments = ["run", str(self._library.folder / asked.protocol), "--lab", str(self._lab)]
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
        """Resume a run in a new engine."""
        run = await self._runs.opened(id)
        await _until_gone(run)
        if run.fate == "starting":
            raise Refusal(409, "LIVE", f"{run.id} is starting", "wait until its engine answers")
        checked = run.inputs.checked
        if checked is not None and checked.survey is not None:
            self.check_list(hazards_of(checked), asked.checklist)
        devices = sorted(set(run.picture.roles.values()) & set(self._device_links.links))
        await self._check_devices(devices)
        self._check_room()
        arguments = ["resume", str(run.folder), "--by", by, *_options("--answer", asked.answers)]
        arguments += _options("-p", {n: text_of(v) for n, v in asked.params.items()})
        if asked.protocol is not None:
            self._library.read(asked.protocol)
            arguments += ["--changed", str(self._library.folder / asked.protocol)]
        arguments += ["--yes"] if asked.yes else []
        arguments += _holes(run, asked)
        deadline.check()
        return await self._launch(arguments, key, devices, None, run)

    # --- before

    def check_list(self, hazards: list[Hazard], ticked: list[str]) -> None:
        """Raise Refusal (422) if a checklist point of a danger is not ticked."""
        lists = self._settings().checklists
        wanted = [point for one in hazards for point in lists.get(one.danger, [])]
        missing = [point for point in dict.fromkeys(wanted) if point not in ticked]
        if missing:
            raise Refusal(
                422, "CHECKLIST", f"not ticked: {', '.join(missing)}",
                "tick what is done, and start again", details={"missing": missing},
            )  # fmt: skip

    async def _check_devices(self, devices: list[str]) -> None:
        """Raise Refusal if a device is lost or in use."""
        for name in devices:
            await self._device_links.device_link(name).until_free()
        for name in devices:
            device_link = self._device_links.device_link(name)
            user = self._device_links.user(name)
            if user is not None:
                raise Refusal(
                    409, "HELD", f"{name} is used by {user}", details={"run": user, "device": name}
                )
            device_link.reachable_client()
            device_link.check_turn()

    def no_room(self) -> str:
        """Why the disk takes no run; empty if it does."""
        return no_room(self._runs.folder)

    def _check_room(self) -> None:
        """Raise Refusal (507) if the disk is full, or about to be."""
        if why := self.no_room():
            raise Refusal(507, "DISK_FULL", why, "make room, and start again")

    # --- the engine

    async def _launch(
        self, arguments: list[str], key: str, devices: list[str], said: Launch | None,
        run: OpenRun | None = None,
    ) -> LaunchState:  # fmt: skip
        _check_arguments(arguments)
        id = sha256(key.encode()).hexdigest()[:16]
        log = self._state / f"{id}.log"
        self._runs.reserved |= dict.fromkeys(devices, "a run that is starting")
        try:
            process = await asyncio.to_thread(start_engine, arguments, log, self._library.folder)
        except OSError as fault:
            self._release(devices)
            raise Refusal(500, "NO_ENGINE", f"no engine could be started: {fault}") from fault
        found = _Launched(id, process.pid, log, devices, said, process)
        self._launched[id] = found
        record = {
            "id": id, "pid": process.pid, "devices": devices,
            "said": said.model_dump() if said is not None else None,
        }  # fmt: skip
        self._follow(found)  # it frees the devices, even if the record cannot be written
        write_whole(self._state / f"{id}.json", json.dumps(record).encode())
        await in_time(found.known.wait(), ANSWER_S)
        return found.state_now()

    def _follow(self, found: _Launched) -> None:
        name = f"follow the engine of launch {found.id}"
        spawn(name, self._until_over(found), among=self._tasks)

    async def _until_over(self, found: _Launched) -> None:
        """Wait until the engine has ended; if it is our child, it is reaped."""
        await self._until_up(found)
        if found.run is not None:
            while found.is_alive:  # noqa: ASYNC110 - who is not our child tells us nothing
                await asyncio.sleep(OVER_S)
            self._changed(found.id)

    async def _until_up(self, found: _Launched) -> None:
        """Wait until the engine has reported its run, or ended; after that the run is followed."""
        until = time.monotonic() + UP_S
        try:
            while time.monotonic() < until:
                living = found.is_alive
                found.run = run_told(found.log)
                if found.run is not None:
                    found.state = "running" if living else "ended"
                    await self._arrived(found)
                    return
                if not living:
                    break
                await asyncio.sleep(LOOK_S)
            found.state, found.message = "failed", last_words(found.log)
        finally:
            self._release(found.devices)
            self._changed(found.id)
            found.known.set()

    async def _arrived(self, found: _Launched) -> None:
        """The run exists: store what its starter entered, and start listening."""
        assert found.run is not None
        folder = self._runs.folder / Path(found.run).name
        if found.said is not None and folder.is_dir() and not (folder / LAUNCH).exists():
            data = found.said.model_dump_json(indent=1).encode()
            await asyncio.to_thread(write_whole, folder / LAUNCH, data)
        try:
            run = await self._runs.opened(folder.name)
        except Refusal:
            return  # its folder was removed
        run.learn_launch()
        if (folder / FILE).exists():
            await run.hear()

    def _release(self, devices: list[str]) -> None:
        for device in devices:
            self._runs.reserved.pop(device, None)


async def _until_gone(run: OpenRun) -> None:
    """Wait a moment for an engine writing its report; raises Refusal while one is alive."""
    until = time.monotonic() + ANSWER_S
    while run.live and run.picture.finished is not None:
        if time.monotonic() > until:
            break
        await asyncio.sleep(LOOK_S)
    if run.live:
        words = "is still writing its report" if run.picture.finished else "is running"
        raise Refusal(409, "LIVE", f"{run.id} {words}", "wait until it has ended")


def _holes(run: OpenRun, asked: ResumeRun) -> list[str]:
    """The options that ask for holes again; raises Refusal (409) for what is none."""
    if not asked.holes:
        return []
    holes = run.picture.holes
    if not holes:
        raise Refusal(409, "NO_HOLES", f"{run.id} has no holes: no point of it failed")
    if asked.holes == "all":
        return ["--holes"]
    unknown = [one.key for one in asked.holes if (one.loop, one.within, one.key) not in holes]
    if unknown:
        raise Refusal(
            409, "NO_HOLES", f"the point {unknown[0]} is no hole: it has not failed, or is measured by now",
            "look at the run again, and choose among its holes",
        )  # fmt: skip
    paths = [holes[one.loop, one.within, one.key] for one in asked.holes]
    return [part for path in paths for part in ("--point", path)]


def _options(option: str, given: dict[str, str]) -> list[str]:
    return [part for name, value in given.items() for part in (option, f"{name}={value}")]


def _check_arguments(arguments: list[str]) -> None:
    """Raise Refusal (422) for a text that cannot be passed to a process."""
    for text in arguments:
        try:
            fits = "\0" not in text and len(os.fsencode(text)) <= LONGEST_ARGUMENT
        except UnicodeEncodeError:
            fits = False
        if not fits:
            name = ascii(text[:60])
            raise Refusal(
                422, "INVALID", f"{name} is too long, or contains an invalid character",
                f"parameters and answers are text of at most {LONGEST_ARGUMENT:,} bytes",
            )  # fmt: skip


def text_of(value: Any) -> str:
    """A value as on the command line."""
    return value if isinstance(value, str) else json.dumps(value)
