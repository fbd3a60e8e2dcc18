"""One open run: follows its journal, listens to its engine, holds its state."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...engine.control.server import FILE, NotLive
from ...engine.journal.journal import CHUNK, Follower, JournalFault
from ...engine.run.folder import JOURNAL
from ...schemas.journal import JournalRecord
from ...system.tasks import end, in_time, spawn
from ..library.timings import Timings
from ..local.clock import iso
from ..models.runs import Fate, Launch
from .endpoint import listen
from .engine import began_at
from .inputs import Inputs, read_inputs, read_launch
from .picture import Changed, Picture

LOG = logging.getLogger("labrun")
ANSWER_S = 5.0
"""Longer than connecting to an engine may take."""

Records = list[tuple[int, JournalRecord]]


class OpenRun:
    """Follows one run. `live` while its engine's endpoint answers; `changed` is called on changes."""

    def __init__(self, folder: Path, timings: Timings, changed: Callable[[str], None]) -> None:
        self.id = folder.name
        self.folder = folder
        self.timings = timings
        self.seq = 0
        self.live = False
        self.pausing: tuple[str, str] | None = None
        """The loop and key of the iteration after which it is to pause."""
        self.paused_by = ""
        """Who wanted that."""
        self.inputs = Inputs("", "", None, None, Launch())
        self.picture = Picture(folder / JOURNAL, None)
        self.damage = ""
        self.feedback: dict[str, tuple[float | None, str]] = {}
        """Path of an action under way -> its progress and message."""
        self.used_at = time.monotonic()
        self._tell = changed
        self._follower = Follower(folder / JOURNAL)
        self._reading = asyncio.Lock()
        self._listening: asyncio.Task[None] | None = None
        self._answered = asyncio.Event()
        self._told_fate = ""

    # --- reading

    async def load(self) -> None:
        """Read the run's inputs, and its journal from the start; it is shown when that is done."""
        inputs = await asyncio.to_thread(read_inputs, self.folder)
        picture = Picture(self.folder / JOURNAL, inputs.outline)
        follower = Follower(self.folder / JOURNAL)
        await self._catch_up(picture, follower)
        if not self.picture.started:
            picture.changed = Changed()  # nobody has seen an earlier state yet
        self.inputs, self.picture, self._follower = inputs, picture, follower

    async def read(self) -> None:
        """Read new records of the journal."""
        self.used_at = time.monotonic()
        async with self._reading:
            changes = len(self.picture.changes)
            await self._catch_up(self.picture, self._follower)
            if len(self.picture.changes) > changes:
                await self.load()  # it continues with another protocol
                self.seq += 1  # a gap in the patches: whoever watches it asks for the whole

    async def _catch_up(self, picture: Picture, follower: Follower) -> None:
        """Take the new records here, where the picture is looked at; a thread only reads them."""
        while not self.damage and (behind := follower.behind) > 0:
            if behind > CHUNK:
                records = await asyncio.to_thread(self._records, follower)
            else:
                records = self._records(follower)
            if not records:
                return  # an incomplete last line
            self._take(picture, records)
            if picture.finished is not None:
                self.timings.learn(self.id, picture.times)

    def _records(self, follower: Follower) -> Records:
        records: Records = []
        try:
            records.extend(follower.records(CHUNK))  # keeps those before a fault
        except JournalFault as fault:
            self.damage = f"{fault} The records before it are shown."
        return records

    def _take(self, picture: Picture, records: Records) -> None:
        for offset, record in records:
            try:
                picture.read(offset, record)
            except Exception as fault:  # it is ours: the other runs are watched all the same
                LOG.exception("record %s of %s cannot be shown", record.n, self.id)
                self.damage = (
                    f"record {record.n} of the journal cannot be shown "
                    f"({type(fault).__name__}: {fault}); the records before it are shown"
                )
                return

    # --- the engine

    async def hear(self) -> None:
        """Listen to the engine, if there is one; returns once it has answered or failed to."""
        if (self._listening is None or self._listening.done()) and (self.folder / FILE).exists():
            self._answered.clear()
            self._listening = spawn(f"listen to the engine of {self.id}", self._hear())
            await in_time(self._answered.wait(), ANSWER_S)  # it is heard when it answers

    async def over(self) -> None:
        """Wait until the engine has disconnected."""
        if self._listening is not None:
            await asyncio.wait({self._listening})

    async def close(self) -> None:
        """Stop listening."""
        await end(self._listening)

    async def _hear(self) -> None:
        with contextlib.suppress(NotLive):
            try:
                await listen(self.folder, self._heard, self._up)
            finally:
                self._answered.set()
                if self.live:
                    self.live = False
                    self.feedback.clear()
                    await self.read()
                    if self.picture.finished is None:
                        self.picture.close()
                    self._has_changed()

    def _up(self) -> None:
        self.live = True
        self._answered.set()
        self._has_changed()

    def _heard(self, event: dict[str, Any]) -> None:
        kind = event["event"]
        if kind == "feedback":
            progress = event.get("data", {}).get("progress")
            self.feedback[event["path"]] = (progress, event.get("text", ""))
        elif kind == "goal" and event.get("state") != "sent":
            self.feedback.pop(event["path"], None)
        elif kind == "iteration" and event["state"] == "begun":
            self._total(event)
        self._has_changed()

    def _total(self, event: dict[str, Any]) -> None:
        found = self.inputs.outline.find(event["path"]) if self.inputs.outline else None
        total = event.get("data", {}).get("total")
        if found is not None and total is not None:
            self.picture.table(found.step.told.path, found.within).total = total

    def _has_changed(self) -> None:
        self.picture.changed.head = True
        self._tell(self.id)

    # --- its state

    @property
    def fate(self) -> Fate:
        """The run's current state."""
        if self.damage and not self.picture.started:
            return "unreadable"
        if self.picture.finished is not None or self.live:
            return self.picture.fate
        return "interrupted" if self.coming_up is None else "starting"

    @property
    def coming_up(self) -> float | None:
        """When an engine started that does not answer yet, in seconds since 1970."""
        return began_at(self.folder)

    @property
    def began_at(self) -> str:
        """When it was started, or when the engine that comes up was; empty if unknown."""
        started = self.picture.started
        known = "" if started is None else started.began or started.at
        began = None if known else self.coming_up
        return known if began is None else iso(began)

    def look_at_fate(self) -> None:
        """Tell of a change without a record: an engine is starting, or has gone."""
        before, self._told_fate = self._told_fate, self.fate
        if before != self._told_fate:
            self.picture.changed.head = True

    def learn_launch(self) -> None:
        """The starter's remarks have been stored."""
        self.inputs.launch = read_launch(self.folder)
        self._has_changed()
