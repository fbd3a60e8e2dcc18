"""Put a site together and open it, part by part; close it in the opposite order."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ..engine.lab import LoadedLab
from .bench.acting import Acting
from .bench.arming import Arming
from .bench.bench import Bench
from .bench.jogging import Jogging
from .bench.stopping import Stopping
from .guard.control import Control
from .guard.fault import FaultLog
from .guard.once import Keys
from .guard.refusal import Refusal
from .guard.sessions import Sessions
from .lab_here import lab_here
from .live.launching import Launching
from .live.resuming import Resuming
from .live.runs import Runs
from .live.telling import Telling
from .models.push import Notice
from .models.results import Reduction
from .models.settings import Settings
from .push.push import Push, Sources
from .results.again import Again
from .results.reducing import Reducing
from .results.results import Results
from .settings_file import SettingsFile
from .shelf.looking import Looking
from .shelf.making import Making
from .shelf.overview import Overview
from .shelf.rehearsals import Rehearsals
from .shelf.shelf import Shelf
from .shelf.timings import Timings
from .site import Options, Site
from .workers import Workers


@asynccontextmanager
async def opened(options: Options, lab: LoadedLab) -> AsyncIterator[Site]:
    """A site for as long as the block lasts; raises OSError where its folders cannot be written."""
    options.state.mkdir(parents=True, exist_ok=True)
    options.runs.mkdir(parents=True, exist_ok=True)
    workers = Workers()
    site = _site(options, lab, lab_here(lab, options.state / "bench"), workers)
    site.push.open(_sources(site))
    await site.runs.open()
    site.launching.open()
    site.bench.open()
    try:
        yield site
    finally:
        await _close(site, workers)


def _site(options: Options, lab: LoadedLab, served: LoadedLab, workers: Workers) -> Site:
    """Every part with those that it needs."""
    state, folder = options.state, options.protocols
    assert served.path is not None
    push = Push()

    def tell(text: str) -> None:
        push.notice(Notice(level="problem", text=text))

    def reduced(id: str, told: Reduction) -> None:
        good = told.state == "done"
        words = (
            "maps and classes are made" if good else f"its spectra were not reduced: {told.text}"
        )
        push.notice(Notice(level="info" if good else "problem", text=f"{id}: {words}", run=id))

    timings = Timings(state / "timings.json")
    settings = SettingsFile(state / "settings.json", _first_settings(lab))
    shelf = Shelf(folder, state, options.runs)
    looking = Looking(workers.checks, folder, options.lab, state / "timings.json")
    runs = Runs(options.runs, timings, push, folder)
    touch_device = partial(push.touch, "devices")
    armed: dict[str, Arming] = {}

    def armed_by(device: str) -> str | None:
        return armed["it"].by(device)

    def any_armed() -> bool:
        return armed["it"].any()

    bench = Bench(served, state / "bench" / "servers", touch_device, runs.used_by, armed_by)

    def arming_changed(device: str) -> None:
        push.touch("devices", device)
        push.touch_control()

    arming = armed["it"] = Arming(bench.station, runs.used_by, arming_changed)
    acting = Acting(
        bench.station, arming, state / "by-hand", partial(push.touch, "goals"), touch_device
    )
    jogging = Jogging(bench.station, acting, arming, partial(push.touch, "jogs"))
    telling = Telling(runs)
    stations = list(bench.stations.values())
    return Site(
        options=options, lab=lab,
        sessions=Sessions(state / "secret", options.token), keys=Keys(state / "commands.sqlite"),
        faults=FaultLog(state / "faults.log"),
        settings=settings, control=Control(push.touch_control, any_armed, tell), push=push,
        shelf=shelf, overview=Overview(shelf, looking, runs.all),
        making=Making(shelf, lab, options.lab, runs.place), looking=looking,
        rehearsals=Rehearsals(workers.rehearsals, looking, folder, options.lab),
        bench=bench, acting=acting, arming=arming, jogging=jogging,
        stopping=Stopping(lambda: stations, jogging, arming, telling.abort_all, tell),
        runs=runs,
        launching=Launching(
            shelf, looking, bench, runs, state / "launches", served.path, settings.read,
            partial(push.touch, "launches"),
        ),
        telling=telling, resuming=Resuming(runs, shelf, workers.fits),
        results=Results(runs, workers.fits), again=Again(runs),
        reducing=Reducing(runs.place, runs.is_live, reduced),
    )  # fmt: skip


def _first_settings(lab: LoadedLab) -> Settings:
    return Settings(bench=lab.lab.name)


def _sources(site: Site) -> Sources:
    """Where the push finds what it tells."""

    def device(name: str) -> Any:
        return site.bench.state(name) if name in site.bench.stations else None

    def signed_in(environ: Mapping[str, Any]) -> bool:
        headers = environ["asgi.scope"]["headers"]
        return site.sessions.knows_raw({k.decode(): v.decode("latin-1") for k, v in headers})

    def beat(id: str, session: str) -> None:
        try:
            site.jogging.beat(id, session)
        except Refusal:
            return  # a hold that is over: late keep-alives are of no account

    return Sources(
        all={
            "devices": lambda: {state.name: state for state in site.bench.states()},
            "runs": site.runs.by_id,
            "goals": site.acting.goals,
            "jogs": site.jogging.states,
            "launches": site.launching.states,
        },
        one={
            "devices": device,
            "runs": site.runs.one,
            "goals": site.acting.known,
            "jogs": site.jogging.known,
            "launches": site.launching.known,
        },
        control=site.control.state,
        bench=lambda: site.settings.read().bench,
        watch=site.runs.watched,
        signed_in=signed_in,
        beat=beat,
        gone=site.jogging.gone,
        stop=site.stopping.stop_all,
    )


async def _close(site: Site, workers: Workers) -> None:
    """Axes first; runs and their engines go on."""
    await site.stopping.close()
    await site.jogging.close()
    await site.acting.close()
    site.arming.disarm()
    await site.bench.close()
    await site.launching.close()
    await site.runs.close()
    await site.overview.close()
    await site.reducing.close()
    await workers.close()
    await site.push.close()
    site.keys.close()


def state_folder(protocols: Path) -> Path:
    """Where a server for these protocols keeps its own state."""
    return protocols / ".labrun" / "web"
