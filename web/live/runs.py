"""All runs of a folder: live ones are followed, finished ones are opened when somebody looks."""

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

from ...engine.control_server import FILE
from ...engine.reports import make_reports
from ...engine.run_folder import JOURNAL
from ...engine.run_folder import is_live as has_engine
from ..guard.refusal import Refusal, not_found
from ..models.push import Notice, RunLog, RunPatch
from ..models.push import Watched as WatchedTold
from ..models.runs import PointDetail, RunSummary
from ..models.told import Said
from ..push.push import Push
from ..shelf.timings import Timings
from .point import point_detail
from .quick import quick_summary
from .watched import Watched

TICK_S = 0.1
SCAN_EVERY = 10
"""Ticks between two looks at the folder."""
KEEP_OPEN_S = 600.0
KEEP_OPEN = 8

Paused = Callable[[Watched], Awaitable[None]]


class Runs:
    """`folder` holds the runs; what changes is pushed."""

    def __init__(
        self, folder: Path, timings: Timings, push: Push, shelf: Path | None = None
    ) -> None:
        self.folder = folder
        self.reserved: dict[str, str] = {}
        """Device -> the launch that is about to use it."""
        self.pause_due: Paused | None = None
        self._shelf = shelf
        self._timings = timings
        self._push = push
        self._open: dict[str, Watched] = {}
        self._known: dict[str, tuple[int, RunSummary]] = {}
        self._task: asyncio.Task[None] | None = None
        self._opening = asyncio.Lock()

    async def open(self) -> None:
        """Look once, so that what is live is known before anybody asks; then go on looking."""
        await self._scan()
        self._task = asyncio.create_task(self._watch())

    async def close(self) -> None:
        """Follow nothing any more; runs go on."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await asyncio.gather(*(run.close() for run in self._open.values()))

    # --- who asks

    def live(self) -> list[Watched]:
        """Those whose engine answers."""
        return [run for run in self._open.values() if run.live]

    def is_live(self, id: str) -> bool:
        """True while a run's engine is there, also before the watch has seen its folder."""
        run = self._open.get(id)
        if run is None:
            return has_engine(self.place(id))
        return run.live or run.fate == "starting"

    def used_by(self, device: str) -> str | None:
        """The run, or launch, that has a device."""
        for run in self.live():
            if device in run.picture.roles.values():
                return run.id
        return self.reserved.get(device)

    def all(self) -> list[RunSummary]:
        """What is known now, newest first."""
        told = {id: summary for id, (_, summary) in self._known.items()}
        told |= {id: self._named(run.summary()) for id, run in list(self._open.items())}
        return sorted(told.values(), key=lambda run: run.began_at, reverse=True)

    async def summaries(self) -> list[RunSummary]:
        """All of them, after a look at the folder."""
        await self._scan()
        return self.all()

    def by_id(self) -> dict[str, RunSummary]:
        """The newest, for the snapshot: lists of thousands are asked for by GET."""
        return {run.id: run for run in self.all()[:100]}

    def one(self, id: str) -> RunSummary | None:
        """One of them, for a patch."""
        if id in self._open:
            return self._named(self._open[id].summary())
        return self._known[id][1] if id in self._known else None

    def place(self, id: str) -> Path:
        """The folder of a run; raises Refusal (404)."""
        folder = self.folder / id
        named = id.isprintable() and Path(id).name == id and not id.startswith(".")
        if not named or not _is_file(folder / JOURNAL):
            raise not_found("run", id[:80], "GET /runs lists what there is")
        return folder

    async def opened(self, id: str) -> Watched:
        """A run with all that is in its journal by now."""
        folder = self.place(id)
        async with self._opening:
            run = self._open.get(id)
            if run is None:
                run = Watched(folder, self._timings, self._changed)
                await run.load()
                await run.hear()
                self._open[id] = run
        await run.read()
        return run

    async def watched(self, id: str) -> WatchedTold:
        """For a browser that watches it."""
        try:
            run = await self.opened(id)
        except Refusal as refusal:
            return WatchedTold(ok=False, text=str(refusal))
        await self._patch(run)
        return WatchedTold(ok=True, run=run.detail())

    async def point(self, run: Watched, loop: str, within: str, key: str) -> PointDetail:
        """Everything about one iteration."""
        return await asyncio.to_thread(point_detail, run, loop, within, key)

    async def report(self, id: str) -> Said:
        """Make its report and figures again."""
        folder = self.place(id)
        made, failed = await asyncio.to_thread(make_reports, folder)
        words = [f"made {path.name}" for path in made] + failed
        return Said(text="; ".join(words) or "there is nothing to draw")

    # --- looking

    def _changed(self, id: str) -> None:
        self._push.touch("runs", id)

    def _named(self, run: RunSummary) -> RunSummary:
        """The file as the shelf calls it."""
        return run.model_copy(update={"file": self.shelf_name(run.file)})

    def shelf_name(self, file: str) -> str:
        """A protocol's file as its name on the shelf, where it lies there."""
        path = Path(file)
        if self._shelf is not None and path.is_absolute() and path.is_relative_to(self._shelf):
            return path.relative_to(self._shelf).as_posix()
        return file

    async def _watch(self) -> None:
        ticks = 0
        while True:
            began = time.monotonic()
            ticks += 1
            if ticks % SCAN_EVERY == 0:
                await self._scan()
                await self._forget()
            for run in list(self._open.values()):
                if run.live:
                    await run.read()
                    await self._pause_when_due(run)
                if run.picture.changed:
                    await self._patch(run)
            await asyncio.sleep(max(0.01, TICK_S - (time.monotonic() - began)))

    async def _patch(self, run: Watched) -> None:
        """Tell what has changed in a run, to those who watch it."""
        if not run.picture.changed:
            return
        nodes, points, lines = run.picture.take_changes()
        run.seq += 1
        self._push.touch("runs", run.id)
        if self._push.watched(run.id):
            told = run.picture.log.lines(lines, run.inputs.outline)
            patch = RunPatch(run=run.id, seq=run.seq, head=run.head(), nodes=nodes, points=points)
            await self._push.run_patch(patch)
            if told:
                await self._push.run_log(RunLog(run=run.id, lines=told))

    async def _pause_when_due(self, run: Watched) -> None:
        if run.pausing is None or self.pause_due is None:
            return
        loop, key = run.pausing
        tables = [t for t in run.picture.tables.values() if t.loop == loop and key in t.slots]
        if any(table.ended[table.slots[key]] for table in tables) or run.picture.finished:
            run.pausing = None
            await self.pause_due(run)

    async def _scan(self) -> None:
        """Find new runs, those that came to life, and those that have ended."""
        found = await asyncio.to_thread(self._look, dict(self._known))
        for id, (signature, summary, live) in found.items():
            if id in self._open:
                run = self._open[id]
                if live:
                    await run.hear()
                if run.news:
                    run.picture.changed.head = True
                continue
            if summary is not None and not live:
                if self._known.get(id, (0, None))[0] != signature:
                    self._known[id] = (signature, summary)
                    self._changed(id)
                continue
            with contextlib.suppress(Refusal):  # gone in between
                await self.opened(id)
        for id in [id for id in self._known if id not in found]:
            del self._known[id]
            self._changed(id)
        for id in [id for id in self._open if id not in found]:
            await self._open.pop(id).close()
            self._changed(id)

    def _look(
        self, known: dict[str, tuple[int, RunSummary]]
    ) -> dict[str, tuple[int, RunSummary | None, bool]]:
        """Run -> size of its journal, its summary if it is finished, whether it says it is live."""
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
            summary = before[1] if before is not None and before[0] == signature else None
            if summary is None and folder.name not in self._open and not live:
                summary = quick_summary(folder)
            found[folder.name] = (signature, summary, live)
        return found

    async def _forget(self) -> None:
        """Close runs that nobody has looked at for a while."""
        now = time.monotonic()
        idle = [
            run for run in self._open.values()
            if not run.live and not self._push.watched(run.id)
            and run.picture.finished is not None and now - run.used_at > KEEP_OPEN_S
        ]  # fmt: skip
        for run in sorted(idle, key=lambda run: run.used_at)[: max(0, len(idle) - KEEP_OPEN)]:
            await self._open.pop(run.id).close()

    def tell(self, text: str, run: str | None = None) -> None:
        """A notice to everybody."""
        self._push.notice(Notice(level="problem", text=text, run=run))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for any file
        return False
