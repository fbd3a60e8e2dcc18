"""Everything that one `labrun web` has: put together part by part, opened, closed in the opposite order."""

import platform
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ... import __version__
from ...engine.dispatch.served_lab import serves_in
from ...engine.lab.lab import LoadedLab
from ...system.page import FOLDER as PAGE
from ..access.control import Control, Level
from ..access.fault import FaultLog
from ..access.once import Keys
from ..access.sessions import Sessions
from ..demo.trouble import Trouble
from ..devices.acting import Acting
from ..devices.arming import Arming
from ..devices.devices import DeviceLinks
from ..devices.history import Histories
from ..devices.jogging import Jogging
from ..devices.looking import Looking
from ..devices.stopping import Stopping
from ..library.library import Library
from ..library.new_protocol import NewProtocols
from ..library.overview import Overview
from ..library.rehearsals import Rehearsals
from ..library.text_check import TextCheck
from ..library.timings import Timings
from ..local.lab_here import lab_here
from ..local.refusal import Refusal
from ..local.settings_file import SettingsFile
from ..local.workers import Workers
from ..models.results import Reduction
from ..models.settings import About, Settings
from ..models.updates import Notice
from ..notify.notifying import Notifying
from ..results.again import Again
from ..results.reducing import Reducing
from ..results.results import Results
from ..runs.finding import Finding
from ..runs.launching import Launching
from ..runs.releasing import Releasing
from ..runs.resuming import Resuming
from ..runs.run_commands import RunCommands
from ..runs.runs import Runs
from ..runs.snapshots import Snapshots
from ..updates.updates import Source, Sources, Updates


@dataclass(frozen=True, slots=True)
class Options:
    """The command line."""

    protocols: Path
    runs: Path
    lab: Path | None = None
    host: str = "127.0.0.1"
    port: int = 8321
    token: str | None = None
    made_token: bool = False
    demo: bool = False
    check_timeout_s: float = 60.0
    page: Path = PAGE

    @property
    def state(self) -> Path:
        """The folder of the server's own working state."""
        return self.protocols / ".labrun" / "web"


class AppState:
    """The parts of a server; each knows only those parts that it is given."""

    def __init__(self, options: Options, lab: LoadedLab) -> None:
        state, folder = options.state, options.protocols
        served = lab_here(lab, state / "bench")
        assert served.path is not None
        self.options, self.lab = options, lab
        self.keys = Keys(state / "commands.sqlite")
        self._workers = workers = Workers()
        self.updates = updates = Updates()
        self.histories = Histories(state / "history.sqlite")
        timings = Timings(state / "timings.json")

        self.sessions = Sessions(state / "secret", options.token, made=options.made_token)
        self.faults = FaultLog(state / "faults.log")
        self.settings = SettingsFile(
            state / "settings.json", Settings(bench=lab.lab.name), lab=options.lab,
            served=served.path, notify=lab.lab.notify,
        )  # fmt: skip
        self.control = Control(updates.touch_control, lambda: self.arming.any(), self._tell)

        self.runs = runs = Runs(options.runs, timings, updates, folder)
        self.library = Library(folder, state, options.runs)
        self.commands = RunCommands(runs, self.library)
        self.finding = Finding(runs)
        self.results = Results(runs, workers.fits)
        self.again = Again(runs)
        self.reducing = Reducing(runs.place, runs.is_live, self._reduced)

        self.device_links = links = DeviceLinks(
            served, state / "bench" / "servers", self._device_changed, runs.used_by,
            lambda device: self.arming.by(device),
        )  # fmt: skip
        of = links.device_link
        self.arming = Arming(of, runs.used_by, self._arming_changed)
        touch_goal, touch_jog = partial(updates.touch, "goals"), partial(updates.touch, "jogs")
        self.acting = Acting(
            of, self.arming, state / "by-hand", touch_goal, self._device_changed,
            lambda: self.settings.read().by_hand_s,
        )  # fmt: skip
        self.jogging = Jogging(of, self.acting, self.arming, touch_jog)
        self.looking = Looking(of, runs.used_by, lambda: self.settings.read().look_every_s)
        self.snapshots = Snapshots(runs, self.looking)
        self.stopping = Stopping(
            list(links.links.values()), self.jogging, self.arming, self.commands.abort_all,
            self._tell,
        )  # fmt: skip

        self.text_check = TextCheck(
            workers.checks, folder, options.lab, state / "timings.json",
            timeout_s=options.check_timeout_s,
        )  # fmt: skip
        self.overview = Overview(self.library, self.text_check, runs.all)
        self.new_protocols = NewProtocols(self.library, lab, options.lab, runs.place)
        self.rehearsals = Rehearsals(workers.rehearsals, self.text_check, folder, options.lab)
        self.resuming = Resuming(runs, self.library, workers.fits)
        self.launching = Launching(
            self.library, self.text_check, links, runs, state / "launches", served.path,
            self.settings.read, partial(updates.touch, "launches"),
        )  # fmt: skip
        self.releasing = Releasing(
            self.library, workers.checks, options.runs, options.lab, self.launching.check_list
        )
        self.notifying = Notifying(
            lambda: self.settings.read().notify, runs.followed, links.states, options.runs,
            self._tell, lambda: self.settings.read().bench,
        )  # fmt: skip
        world = state / "bench" / "servers" / "world"
        self.trouble = Trouble(links, world) if options.demo else None

    async def open(self) -> None:
        """Look at the runs, then connect to the devices."""
        self.updates.open(self._sources())
        await self.runs.open()
        self._tell_the_shells()
        self.launching.open()
        self.device_links.open()
        self.notifying.open()

    async def close(self) -> None:
        """Stop the axes first; runs and their engines continue."""
        await self.stopping.close()
        await self.jogging.close()
        await self.acting.close()
        self.arming.disarm()
        for part in (
            self.notifying, self.commands, self.device_links, self.launching, self.runs,
            self.overview, self.reducing, self.releasing, self._workers, self.updates,
        ):  # fmt: skip
            await part.close()
        self.keys.close()
        self.histories.close()

    def _tell_the_shells(self) -> None:
        """Runs and calls of this user's shells, and of agents, find the lab's device servers here."""
        if self.lab.path is None or self.options.demo:
            return
        try:
            serves_in(self.lab, (self.options.state / "bench" / "servers").resolve())
        except OSError as fault:
            self._tell(f"runs from a shell will not find the devices that are served here: {fault}")

    def about(self) -> About:
        """What this server is."""
        return About(
            labrun=__version__, python=platform.python_version(), lab=self.lab.lab.name,
            lab_file=str(self.lab.path) if self.lab.path else None,
            simulated=self.lab.lab.simulated, protocols=str(self.options.protocols),
            runs=str(self.options.runs), demo=self.options.demo,
        )  # fmt: skip

    def _tell(self, text: str, level: Level = "problem") -> None:
        self.updates.notice(Notice(level=level, text=text))

    def _reduced(self, id: str, told: Reduction) -> None:
        good = told.state == "done"
        words = (
            "maps and classes are ready" if good else f"its spectra were not reduced: {told.text}"
        )
        notice = Notice(level="info" if good else "problem", text=f"{id}: {words}", run=id)
        self.updates.notice(notice)

    def _device_changed(self, device: str) -> None:
        self.updates.touch("devices", device)
        self.histories.note(self.device_links.state(device))

    def _arming_changed(self, device: str) -> None:
        self.updates.touch("devices", device)
        self.updates.touch_control()

    def _sources(self) -> Sources:
        """Where the push gets its state from."""
        links = self.device_links
        return Sources(
            kinds={
                "devices": Source(links.links.keys, links.state),
                "runs": Source(self.runs.newest, self.runs.one),
                "goals": Source(self.acting.newest, self.acting.known),
                "jogs": Source(self.jogging.ids, self.jogging.known),
                "launches": Source(self.launching.ids, self.launching.known),
            },
            control=self.control.state,
            bench=lambda: self.settings.read().bench,
            watch=self.runs.watch,
            signed_in=self._signed_in,
            beat=self._beat,
            session_closed=self.jogging.session_closed,
            stop=self.stopping.stop_all,
        )

    def _signed_in(self, environ: Mapping[str, Any]) -> bool:
        headers = environ["asgi.scope"]["headers"]
        return self.sessions.knows_raw({k.decode(): v.decode("latin-1") for k, v in headers})

    def _beat(self, id: str, session: str) -> None:
        try:
            self.jogging.beat(id, session)
        except Refusal:
            return  # a hold that has ended: late keep-alives are ignored


@asynccontextmanager
async def opened(options: Options, lab: LoadedLab) -> AsyncIterator[AppState]:
    """A server's parts, open while the block runs; raises OSError if its folders cannot be written."""
    options.state.mkdir(parents=True, exist_ok=True)
    options.runs.mkdir(parents=True, exist_ok=True)
    app_state = AppState(options, lab)
    try:
        await app_state.open()
        yield app_state
    finally:
        await app_state.close()
