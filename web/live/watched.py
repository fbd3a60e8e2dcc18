"""One run that is open: its journal followed, its engine heard, its state for whoever asks."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...engine.control_server import FILE, NotLive
from ...engine.run_folder import JOURNAL
from ..clock import iso
from ..models.runs import (
    Fate,
    Launch,
    LogWindow,
    Loop,
    NeedsYou,
    Now,
    Points,
    RunDetail,
    RunHead,
    RunSummary,
)
from ..shelf.timings import Timings
from .counts import Table
from .endpoint import listen
from .engine import began_at
from .follower import Damaged, Follower
from .inputs import Inputs, read_inputs, read_launch
from .outline import Found
from .pace import eta, per_minute
from .picture import Changed, Picture, Underway

BIG = 256 * 1024
"""Bytes of a journal beyond which reading it is left to a thread."""
SLICE = 4 * BIG
ANSWER_S = 5.0
"""More than connecting to an engine may take."""


class Watched:
    """Follows one run. `live` while its engine's endpoint is heard; `changed` when there is news."""

    def __init__(self, folder: Path, timings: Timings, changed: Callable[[str], None]) -> None:
        self.id = folder.name
        self.folder = folder
        self.seq = 0
        self.live = False
        self.pausing: tuple[str, str] | None = None
        """The loop and key of the iteration after which it is to pause."""
        self.inputs = Inputs("", "", None, None, Launch())
        self.picture = Picture(folder / JOURNAL, None)
        self.damage = ""
        self.used_at = time.monotonic()
        self._timings = timings
        self._tell = changed
        self._follower = Follower(folder / JOURNAL)
        self._feedback: dict[str, tuple[float | None, str]] = {}
        self._reading = asyncio.Lock()
        self._listening: asyncio.Task[None] | None = None
        self._answered = asyncio.Event()
        self._loaded = False
        self._told_fate = ""

    # --- reading

    async def load(self) -> None:
        """Read the run's inputs once, and its journal as far as it goes."""
        async with self._reading:
            if not self._loaded:
                self.inputs = await asyncio.to_thread(read_inputs, self.folder)
                self.picture = Picture(self.folder / JOURNAL, self.inputs.outline)
                self._loaded = True
        await self.read()
        self.picture.changed = Changed()  # nobody has seen anything that it could differ from

    async def read(self) -> bool:
        """Take what is new in the journal; whether there was anything."""
        self.used_at = time.monotonic()
        async with self._reading:
            news = False
            while not self.damage and (behind := self._follower.behind) > 0:
                before = self._follower.number
                if behind > BIG:
                    await asyncio.to_thread(self._take, SLICE)
                else:
                    self._take(None)
                if self._follower.number == before:
                    break  # a torn last line
                news = True
            if news and self.picture.finished is not None:
                self._timings.learn(self.id, self.picture.times)
            if self.picture.changes and news:
                await self._look_at_change()
        return news

    def _take(self, most: int | None) -> None:
        try:
            for offset, record in self._follower.records(most):
                self.picture.take(offset, record)
        except Damaged as damage:
            self.damage = f"{damage}; what came before it is shown"
        except OSError as fault:
            self.damage = f"the journal cannot be read: {fault.strerror}"

    async def _look_at_change(self) -> None:
        """The run goes on with another protocol: its steps are drawn anew from the start."""
        inputs = await asyncio.to_thread(read_inputs, self.folder)
        if inputs.text == self.inputs.text:
            return
        self.inputs = inputs
        self.picture = Picture(self.folder / JOURNAL, inputs.outline)
        self._follower = Follower(self.folder / JOURNAL)
        await asyncio.to_thread(self._take, None)

    # --- the engine

    async def hear(self) -> None:
        """Listen to the engine, where there is one; returns when it answers, or does not."""
        if (self._listening is None or self._listening.done()) and (self.folder / FILE).exists():
            self._answered.clear()
            self._listening = asyncio.create_task(self._hear())
            async with asyncio.timeout(ANSWER_S):
                await self._answered.wait()

    async def over(self) -> None:
        """Wait until the engine has hung up."""
        if self._listening is not None:
            await asyncio.wait({self._listening})

    async def close(self) -> None:
        """Listen no more."""
        if self._listening is not None:
            self._listening.cancel()
            await asyncio.gather(self._listening, return_exceptions=True)

    async def _hear(self) -> None:
        with contextlib.suppress(NotLive):
            try:
                await listen(self.folder, self._heard, self._up)
            finally:
                self._answered.set()
                if self.live:
                    self.live = False
                    self._feedback.clear()
                    await self.read()
                    if self.picture.finished is None:
                        self.picture.close()
                    self._news()

    def _up(self) -> None:
        self.live = True
        self._answered.set()
        self._news()

    def _heard(self, event: dict[str, Any]) -> None:
        kind = event["event"]
        if kind == "feedback":
            progress = event.get("data", {}).get("progress")
            self._feedback[event["path"]] = (progress, event.get("text", ""))
        elif kind == "goal" and event.get("state") != "sent":
            self._feedback.pop(event["path"], None)
        elif kind == "iteration" and event["state"] == "begun":
            self._total(event)
        self._news()

    def _total(self, event: dict[str, Any]) -> None:
        found = self.inputs.outline.find(event["path"]) if self.inputs.outline else None
        total = event.get("data", {}).get("total")
        if found is not None and total is not None:
            within = "/".join(key for _, key in found.loops)
            self.picture.table(found.step.told.path, within).total = total

    def _news(self) -> None:
        self.picture.changed.head = True
        self._tell(self.id)

    # --- telling

    @property
    def fate(self) -> Fate:
        """What the run is now."""
        if self.damage and not self.picture.started:
            return "unreadable"
        if self.picture.finished is not None:
            return self.picture.fate
        if self.live:
            return self.picture.fate
        return "interrupted" if self._coming_up is None else "starting"

    @property
    def _coming_up(self) -> float | None:
        """When an engine has begun that is not heard yet."""
        return began_at(self.folder)

    def summary(self) -> RunSummary:
        """As the list of runs tells it."""
        picture = self.picture
        loops = [t for t in picture.tables.values() if "*" not in t.loop and t.loop[:4] == "main"]
        totals = [table.total for table in loops]
        over = self._eta()
        fate, began = self.fate, self._coming_up
        reason = (picture.finished or {}).get("reason", "") or self.damage
        if fate == "interrupted":
            reason = reason or "its engine is gone: resume it"
        at = picture.started.get("began") or picture.started.get("at", "")
        return RunSummary(
            id=self.id, protocol=picture.started.get("protocol") or self.inputs.title,
            file=self.inputs.file, fate=fate, reason=reason, live=self.live,
            began_at=at or (iso(began) if began is not None else ""),
            ended_at=picture.ended_at or None, done=sum(table.done for table in loops),
            failed=sum(table.counts.get("failed", 0) for table in loops),
            total=sum(t or 0 for t in totals) if totals and None not in totals else None,
            holes=picture.holes, resumes=picture.resumes, operator=self.inputs.launch.operator,
            questions=len(picture.questions), now=self._now_text(),
            eta=None if over is None else (iso(over[0]), iso(over[1])),
        )  # fmt: skip

    def head(self) -> RunHead:
        """Everything that changes, but for steps and points."""
        picture = self.picture
        first = next((t for t in picture.tables.values() if "*" not in t.loop), None)
        return RunHead(
            **self.summary().model_dump(), phase=picture.phase, pausing=self.pausing is not None,
            loops=self._loops(), under_way=[self._now(one) for one in picture.under_way.values()],
            open_questions=list(picture.questions.values()), needs_you=self._needs_you(),
            per_minute=per_minute(first) if first is not None and self.live else None,
            retries=picture.retries, lines=len(picture.log),
        )  # fmt: skip

    def detail(self) -> RunDetail:
        """All of it."""
        picture = self.picture
        return RunDetail(
            **self.head().model_dump(),
            outline=self.inputs.outline.nodes if self.inputs.outline is not None else [],
            nodes=picture.states(),
            params=picture.params, roles=picture.roles,
            outputs=(picture.finished or {}).get("outputs", {}), launch=self.inputs.launch,
            protocol_text=self.inputs.text, changes=picture.changes, seq=self.seq,
        )  # fmt: skip

    @property
    def news(self) -> bool:
        """Whether it is another thing by now than when this was asked last, without any record."""
        before, self._told_fate = self._told_fate, self.fate
        return before != self._told_fate

    def learn_launch(self) -> None:
        """What its starter said has been written down."""
        self.inputs.launch = read_launch(self.folder)
        self._news()

    def points(self, loop: str, within: str, offset: int, limit: int) -> Points:
        """A window of a loop's iterations in the order of their items."""
        table = self.picture.tables.get((loop, within)) or Table(loop, within)
        items = self.picture.items(loop)
        total = table.total if table.total is not None else (items.total if items else None)
        end = max(total or 0, max(table.by_index, default=-1) + 1)
        window = range(min(offset, end), min(offset + limit, end))
        places = [items.place(index) for index in window] if items else [(None, None)] * len(window)
        return Points(
            loop=loop, total=total, offset=offset, index=list(window),
            x_mm=[x for x, _ in places], y_mm=[y for _, y in places], **table.columns(window),
        )  # fmt: skip

    def log(
        self, after: int | None, before: int | None, limit: int, *, problems: bool,
        device: str | None, find: str,
    ) -> LogWindow:  # fmt: skip
        """A window of the log."""
        return self.picture.log.window(
            self.inputs.outline, after, before, limit,
            problems=problems, device=device, find=find,
        )  # fmt: skip

    def _loops(self) -> list[Loop]:
        outline = self.inputs.outline
        found = []
        for node in outline.nodes if outline is not None else []:
            if not node.loop:
                continue
            tables = [t for t in self.picture.tables.values() if t.loop == node.path]
            items = self.picture.items(node.path)
            newest = next((t for t in reversed(tables) if t.current is not None), None)
            current = newest.keys[newest.current] if newest and newest.current is not None else None
            total = items.total if items else None
            if "*" not in node.path and tables:
                total = tables[0].total if tables[0].total is not None else total
            found.append(
                Loop(
                    path=node.path, title=node.title, total=total,
                    done=sum(t.done for t in tables),
                    succeeded=sum(t.counts.get("ok", 0) for t in tables),
                    failed=sum(t.counts.get("failed", 0) for t in tables),
                    skipped=sum(t.counts.get("skipped", 0) for t in tables),
                    current=current, placed=bool(items and items.placed),
                )
            )  # fmt: skip
        return found

    def _now(self, one: Underway) -> Now:
        found: Found | None = one.found
        loop, key = found.loops[-1] if found is not None and found.loops else (None, None)
        label = f"{one.record['device']}.{one.record['action']}"
        spread = self._timings.spread(label)
        progress, message = self._feedback.get(one.path, (None, ""))
        return Now(
            id=one.record["id"], path=one.path,
            node=found.step.told.path if found is not None else "", loop=loop, key=key,
            device=one.record["device"], action=one.record["action"], attempt=one.attempt,
            since=one.record["at"], progress=progress, message=message,
            usual_s=None if spread is None else (spread.low, spread.high),
        )  # fmt: skip

    def _now_text(self) -> str:
        if not self.live:
            return ""
        if self.picture.questions:
            return next(iter(self.picture.questions.values())).text
        if self.picture.paused:
            return "paused"
        doing = [
            f"{o.record['device']}.{o.record['action']}" for o in self.picture.under_way.values()
        ]
        return ", ".join(sorted(set(doing)))

    def _eta(self) -> tuple[float, float] | None:
        if not self.live or self.picture.finished is not None or self.picture.paused:
            return None
        tables = [t for t in self.picture.tables.values() if "*" not in t.loop]
        return next((over for t in reversed(tables) if (over := eta(t)) is not None), None)

    def _needs_you(self) -> NeedsYou | None:
        """The next step that asks a person: it comes when the loop before it is over."""
        outline, over = self.inputs.outline, self._eta()
        if outline is None or over is None:
            return None
        behind = self.picture.nodes.keys() | self.picture.passed().keys()
        for node in outline.nodes:
            waiting = node.path not in behind and node.path.startswith("main/")
            if node.kind in ("confirm", "ask") and waiting and "*" not in node.path:
                return NeedsYou(text=node.title, low=iso(over[0]), high=iso(over[1]))
        return None
