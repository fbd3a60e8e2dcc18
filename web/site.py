"""Everything that one `labrun web` has, put together once and closed in order."""

from __future__ import annotations

import platform
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from .. import __version__
from .models.settings import About

if TYPE_CHECKING:
    from ..engine.lab import LoadedLab
    from .bench.acting import Acting
    from .bench.arming import Arming
    from .bench.bench import Bench
    from .bench.jogging import Jogging
    from .bench.stopping import Stopping
    from .demo.trouble import Trouble
    from .guard.control import Control
    from .guard.fault import FaultLog
    from .guard.once import Keys
    from .guard.sessions import Sessions
    from .live.launching import Launching
    from .live.resuming import Resuming
    from .live.runs import Runs
    from .live.telling import Telling
    from .push.push import Push
    from .results.again import Again
    from .results.reducing import Reducing
    from .results.results import Results
    from .settings_file import SettingsFile
    from .shelf.looking import Looking
    from .shelf.making import Making
    from .shelf.overview import Overview
    from .shelf.rehearsals import Rehearsals
    from .shelf.shelf import Shelf


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line says. `state` is the folder of the server's own working state."""

    protocols: Path
    runs: Path
    state: Path
    lab: Path | None = None
    host: str = "127.0.0.1"
    port: int = 8321
    token: str | None = None
    demo: bool = False
    page: Path = field(default_factory=lambda: Path(__file__).parent / "app-dist")


@dataclass(slots=True)
class Site:
    """The parts of a server; each knows only those parts that it was given."""

    options: Options
    lab: LoadedLab
    sessions: Sessions
    keys: Keys
    faults: FaultLog
    settings: SettingsFile
    control: Control
    push: Push
    shelf: Shelf
    overview: Overview
    making: Making
    looking: Looking
    rehearsals: Rehearsals
    bench: Bench
    acting: Acting
    arming: Arming
    jogging: Jogging
    stopping: Stopping
    runs: Runs
    launching: Launching
    telling: Telling
    resuming: Resuming
    results: Results
    reducing: Reducing
    again: Again
    trouble: Trouble | None = None

    def about(self) -> About:
        """What this server is."""
        return About(
            labrun=__version__, python=platform.python_version(), lab=self.lab.lab.name,
            lab_file=str(self.lab.path) if self.lab.path else None,
            simulated=self.lab.lab.simulated, protocols=str(self.options.protocols),
            runs=str(self.options.runs), demo=self.options.demo,
        )  # fmt: skip
