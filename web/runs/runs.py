"""All runs of a folder: live ones are followed, finished ones are opened on request."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Literal

from ...engine.control.server import FILE
from ...engine.run.folder import JOURNAL
from ...engine.run.folder import is_live as has_engine
from ...engine.runner.reports import make_reports
from ...system.tasks import end, keep
from ..library.timings import Timings
from ..local.refusal import Refusal, not_found
from ..models.base import Answer
from ..models.runs import PointDetail, RunSummary
from ..models.updates import Notice, RunLog, RunPatch, WatchedRun
from ..updates.updates import Updates
from .open_run import OpenRun
from .point import point_detail
from .quick import quick_summary
from .run_views import detail, head, summary

LOG = logging.getLogger("labrun")
TICK_S = 0.1
SCAN_S = 1.0
KEEP_OPEN_S = 600.0
KEEP_OPEN = 8

Paused = Callable[[OpenRun], Awaitable[None]]


class Runs:
    """`folder` holds the runs; changes are pushed."""

    def __init__(
        self, folder: Path, timings: Timings, updates: Updates, library: Path | None = None
    ) -> None:
        self.folder = folder
        self.reserved: dict[str, str] = {}
        """Device -> the launch that is about to use it."""
        self.pause_due: Paused | None = None
        self._library = library
        self._timings = timings
        self._updates = updates
        self._open: dict[str, OpenRun] = {}
        self._known: dict[str, tuple[int, RunSummary]] = {}
        self._followed: dict[str, asyncio.Task[None]] = {}
        self._scanning: asyncio.Task[None] | None = None
        self._one_scan = asyncio.Lock()
        self._opening = asyncio.Lock()

    async def open(self) -> None:
        """Scan once, so that live runs are known before the first request; then keep scanning."""
        await self._scan()
        self._scanning = keep("look at the folder of runs", self._keep_scanning)

    async def close(self) -> None:
        """Stop following; runs continue."""
        await end(self._scanning)
        await asyncio.gather(*(self._close(id) for id in list(self._open)))

    # --- queries

    def live_runs(self) -> list[OpenRun]:
        """Those whose engine answers."""
        return [run for run in self._open.values() if run.live]

    def is_live(self, id: str) -> bool:
        """True while a run's engine is alive, even before the scan has seen its folder."""
        run = self._open.get(id)
        if run is None:
            return has_engine(self.place(id))
        return run.live or run.fate == "starting"

    def used_by(self, device: str) -> str | None:
        """The run, or launch, that has a device."""
        for run in self.live_runs():
            if device in run.picture.roles.values():
                return run.id
        return self.reserved.get(device)

    def all(self) -> list[RunSummary]:
        """The runs known now, newest first."""
        summaries = {id: summary for id, (_, summary) in self._known.items()}
        summaries |= {id: self.named(summary(run)) for id, run in self._open.items()}
        return sorted(summaries.values(), key=lambda run: run.began_at, reverse=True)

    def followed(self) -> list[RunSummary]:
        """Those that are open: every live one is, and one that has just ended."""
        return [self.named(summary(run)) for run in self._open.values()]

    async def summaries(self) -> list[RunSummary]:
        """All of them, after a scan of the folder."""
        await self._scan()
        return self.all()

    def newest(self) -> list[str]:
        """The newest, for the snapshot: GET gives lists of thousands."""
        began = {id: known.began_at for id, (_, known) in self._known.items()}
        began |= {id: run.began_at for id, run in self._open.items()}
        return sorted(began, key=lambda id: began[id], reverse=True)[:100]

    def one(self, id: str) -> RunSummary | None:
        """One of them, for a patch."""
        if id in self._open:
            return self.named(summary(self._open[id]))
        return self._known[id][1] if id in self._known else None

    def place(self, id: str) -> Path:
        """The folder of a run; raises Refusal (404)."""
        folder = self.folder / id
        named = id.isprintable() and Path(id).name == id and not id.startswith(".")
        if not named or not _is_file(folder / JOURNAL):
            raise not_found("run", id[:80], "see the list of runs")
        return folder

    async def opened(self, id: str) -> OpenRun:
        """A run with everything in its journal so far."""
        folder = self.place(id)
        async with self._opening:
            run = self._open.get(id)
            if run is None:
                run = OpenRun(folder, self._timings, self._changed)
                await run.load()
                await run.hear()
                self._open[id] = run
                self._followed[id] = keep(f"follow {id}", partial(self._follow, run))
        await run.read()
        return run

    async def watch(self, id: str) -> WatchedRun:
        """For a browser that watches it."""
        try:
            run = await self.opened(id)
        except Refusal as refusal:
            return WatchedRun(ok=False, text=str(refusal))
        await self._patch(run)
        return WatchedRun(ok=True, run=detail(run))

    async def point(self, run: OpenRun, loop: str, within: str, key: str) -> PointDetail:
        """Everything about one iteration."""
        return await point_detail(run, loop, within, key)

    async def report(self, id: str) -> Answer:
        """Make its report and figures again."""
        folder = self.place(id)
        made, failed = await asyncio.to_thread(make_reports, folder)
        words = [f"made {path.name}" for path in made] + failed
        return Answer(text="; ".join(words) or "there is nothing to draw")

    # --- scanning

    def _changed(self, id: str) -> None:
        self._updates.touch("runs", id)

    def named(self, run: RunSummary) -> RunSummary:
        """With the name of its protocol file in the library, if it is there."""
        path = Path(run.file)
        if (
            self._library is None
            or not path.is_absolute()
            or not path.is_relative_to(self._library)
        ):
            return run
        return run.model_copy(update={"file": path.relative_to(self._library).as_posix()})

    async def _keep_scanning(self) -> None:
        while True:
            await asyncio.sleep(SCAN_S)
            await self._scan()
            await self._forget()

    async def _follow(self, run: OpenRun) -> None:
        """Push the changes of an open run."""
        while True:
            if run.live:
                await run.read()
                await self._pause_when_due(run)
            await self._patch(run)
            await asyncio.sleep(TICK_S)

    async def _patch(self, run: OpenRun) -> None:
        """Push the changes of a run to those who watch it."""
        if not run.picture.changed:
            return
        nodes, points, lines = run.picture.take_changes()
        run.seq += 1
        self._updates.touch("runs", run.id)
        if self._updates.is_watched(run.id):
            told_lines = run.picture.log.lines(lines, run.inputs.outline)
            patch = RunPatch(run=run.id, seq=run.seq, head=head(run), nodes=nodes, points=points)
            await self._updates.run_patch(patch)
            if told_lines:
                await self._updates.run_log(RunLog(run=run.id, lines=told_lines))

    async def _pause_when_due(self, run: OpenRun) -> None:
        if run.pausing is None or self.pause_due is None:
            return
        loop, key = run.pausing
        tables = [t for t in run.picture.tables.values() if t.loop == loop and key in t.slots]
        if any(table.ended[table.slots[key]] for table in tables) or run.picture.finished:
            run.pausing = None
            await self.pause_due(run)

    async def _scan(self) -> None:
        """Find new runs, runs that became live, and runs that have ended."""
        async with self._one_scan:
            found = await asyncio.to_thread(self._look, dict(self._known), set(self._open))
            for id, (signature, known, live) in found.items():
                if id in self._open:
                    if live:
                        await self._open[id].hear()
                    self._open[id].look_at_fate()
                elif known is None or live:
                    await self._open_found(id)
                elif self._known.get(id, (0, None))[0] != signature:
                    self._known[id] = (signature, self.named(known))
                    self._changed(id)
            for id in (self._known.keys() | self._open.keys()) - found.keys():
                if not _is_file(self.folder / id / JOURNAL):  # it may be newer than the scan
                    self._known.pop(id, None)
                    await self._close(id)
                    self._changed(id)

    async def _open_found(self, id: str) -> None:
        try:
            await self.opened(id)
        except Refusal:
            return  # removed meanwhile
        except Exception:  # whatever is wrong with this folder: the other runs have to be found
            LOG.exception("%s cannot be opened", id)

    def _look(
        self, known: dict[str, tuple[int, RunSummary]], opened: set[str]
    ) -> dict[str, tuple[int, RunSummary | None, bool]]:
        """Run -> size of its journal, its summary if finished, whether it claims to be live."""
        found: dict[str, tuple[int, RunSummary | None, bool]] = {}
        try:
            folders = list(self.folder.iterdir())
        except OSError:
            return found
        for folder in folders:
            try:
                stat = (folder / JOURNAL).stat()
            except OSError:
                continue
            signature = stat.st_size ^ stat.st_mtime_ns
            live = (folder / FILE).exists()
            before = known.get(folder.name)
            quick = before[1] if before is not None and before[0] == signature else None
            if quick is None and folder.name not in opened and not live:
                quick = quick_summary(folder)
            found[folder.name] = (signature, quick, live)
        return found

    async def _close(self, id: str) -> None:
        run = self._open.pop(id, None)
        if run is not None:
            await end(self._followed.pop(id))
            await run.close()

    async def _forget(self) -> None:
        """Close runs that nobody has viewed for a while."""
        now = time.monotonic()
        idle = [
            run for run in self._open.values()
            if not run.live and not self._updates.is_watched(run.id)
            and run.picture.finished is not None and now - run.used_at > KEEP_OPEN_S
        ]  # fmt: skip
        for run in sorted(idle, key=lambda run: run.used_at)[: max(0, len(idle) - KEEP_OPEN)]:
            await self._close(run.id)

    def tell(
        self, text: str, run: str | None = None, level: Literal["info", "problem"] = "problem"
    ) -> None:
        """A notice to everybody."""
        self._updates.notice(Notice(level=level, text=text, run=run))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for any file
        return False
