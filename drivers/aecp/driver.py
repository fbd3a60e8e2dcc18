"""Implements libs_analyzer@1 with the paper's own analyser server, unchanged.

The server knows no goals, does not number shots and cannot report what it did, so the driver keeps
a log. A measurement whose answer was lost is unknown, unless the program's cache folder is visible
and has one new entry. The server deletes its cache with every export: exported spectra are kept.
"""

import asyncio
import math
import time
from dataclasses import replace
from typing import Any, ClassVar

from ..analyser.export_arrival import Arrived, NotArrived, Wanted, arrived
from ..analyser.exporting import Exporting
from ..analyser.folder import FolderFault, folder_at, see_that_it_is_there
from ..analyser.settings import settings_of
from ..analyser.shot_log import AlreadyBegun, Shot, ShotLog
from ..analyser.spectrum_store import SpectrumStore
from ..driver import ActionFailed, Driver, GoalContext, Place
from .answers import Meaning, meaning_of, text_of, times_in
from .link import AnalyserLink, AnswerLost, NotSent
from .settings import AecpSettings

CACHE_LATE_S = 20.0
"""The server gives a shot 15 s to appear in the cache; a little later than that it never will."""
LOOK_S = 0.2
CALM_S = 8.0
BUTTONS = 8
LOST_IN_A_ROW = 3
CLOCKS_AGREE_S = 5.0
"""A name's time is that of the request's arrival, in whole seconds; between two exports lie more."""


class Aecp(Driver):
    """One action is one event; see `answers` for what its answers mean."""

    contract: ClassVar[str] = "libs_analyzer@1"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.settings = settings_of(place, AecpSettings)
        self._link = AnalyserLink(self.settings.url)
        self.alone = f"the analyser server {self.settings.url}"
        self._exports = folder_at(self.settings.exports)
        self._cache = folder_at(self.settings.cache) if self.settings.cache else None
        self._spectra_kept = SpectrumStore(place.folder / "spectra")
        self._measuring = False
        self._awaited: tuple[int, int] | None = None  # the shot and the connection of its answer

    async def open(self) -> None:
        self._shot_log = ShotLog(self.place.folder / "shots.sqlite")
        self._exporting = Exporting(
            self.place.device, self._shot_log, self._spectra_kept, self.settings.channels
        )
        try:
            await see_that_it_is_there("exports", self._exports)
            if self._cache is not None:
                await see_that_it_is_there("cache", self._cache)
            await self._link.open(self.settings.connect_s)
            await self._set_export_path()
        except BaseException:  # a cancel as well
            await self.close()
            raise

    async def close(self) -> None:
        await self._link.close()
        self._shot_log.close()

    async def status(self) -> dict[str, Any]:
        return {"armed": self._measuring, "shots": self._shot_log.count(), "interlock": "unknown"}

    async def safe(self) -> None:
        """The laser fires only on command, so: send no command, and wait for what runs to end.

        The server cannot lock the laser; raises OSError if it does not report IDLE.
        """
        end = time.monotonic() + CALM_S
        while self._link.idle is not True:
            if time.monotonic() > end:
                said = "is silent" if self._link.idle is None else "still reports RUNNING"
                raise OSError(
                    f"the analyser server at {self.settings.url} {said}; it cannot be stopped from "
                    f"here: use the switch on the analyser"
                )
            await asyncio.sleep(LOOK_S)

    async def measure(self, goal: GoalContext) -> dict[str, Any]:
        before = await self._cache_before()
        shot = self._begun(goal, before)
        self._measuring = True
        self._awaited = shot.number, self._link.connections
        try:
            answer = await self._link.ask(
                "measure", "data", self.settings.measure_s, late=lambda a: self._note_late(shot, a)
            )
        except NotSent as fault:
            self._shot_log.denied(shot)
            raise self._failed("measure", "Rejected", f"{fault}; nothing was sent", "no") from fault
        except AnswerLost as fault:
            return await self._cleared_up(goal, shot, fault)
        finally:
            self._measuring = False
        meaning = meaning_of(text_of(answer))
        if meaning is not None:
            return await self._refused(goal, shot, text_of(answer), meaning)
        return await self._succeeded(shot)

    async def _succeeded(self, shot: Shot) -> dict[str, Any]:
        """The server takes any change in its cache for a shot; where we can see the cache, we check."""
        new = await self._new_entries(shot)
        if new is None or len(new) == 1:
            self._shot_log.fired(shot, new[0] if new else None)
            return {"shot_id": shot.name}
        if new:
            raise self._failed(
                "measure", "Lost",
                f"it reports success, and {' and '.join(new)} are new in its cache: one is from another "
                f"click, and it is unclear which one belongs to this shot", "yes",
            )  # fmt: skip
        raise self._failed(
            "measure", "Lost",
            f"it reports success, but {self.settings.cache} has no new entry: it takes any change there "
            f"for a shot, even a deletion", "unknown",
        )  # fmt: skip

    async def _cache_before(self, asked: str = "measure") -> set[str] | None:
        try:
            return None if self._cache is None else await self._cache.names()
        except FolderFault as fault:
            raise self._failed(asked, "Rejected", f"{fault}; nothing was sent", "no") from fault

    def _begun(self, goal: GoalContext, before: set[str] | None) -> Shot:
        if goal.cancelled.is_set():
            raise self._failed("measure", "Rejected", "it was stopped; nothing was sent", "no")
        lost = sorted(self._lost())
        if len(lost) >= LOST_IN_A_ROW:
            raise self._failed(
                "measure", "Rejected",
                f"the spectra of {', '.join(lost)} did not arrive whole, and another shot would be lost, "
                f"too; nothing was sent. The server clicks Delete half a second after it has begun an "
                f"export: see what its program does then, and continue with `reconnect`", "no",
            )  # fmt: skip
        try:
            return self._shot_log.begin(goal.id, time.time(), before)
        except AlreadyBegun as fault:
            raise self._failed("measure", "Rejected", str(fault), "unknown") from fault
        except OSError as fault:
            raise self._failed("measure", "Rejected", f"{fault}; nothing was sent", "no") from fault

    async def _cleared_up(self, goal: GoalContext, shot: Shot, fault: AnswerLost) -> dict[str, Any]:
        """After a lost answer only the cache folder can show it: one new entry is this shot."""
        goal.feedback(None, f"{fault}; checking the cache")
        if await self._settled(shot):
            return {"shot_id": shot.name}
        seen = (
            "the cache cannot be seen from here"
            if self._cache is None
            else "the cache has no new entry"
        )
        raise self._failed(
            "measure", "Lost",
            f"{fault}; {seen}, so it is unknown whether the laser fired. Check the list in the "
            f"analyser's program", "unknown",
        )  # fmt: skip

    async def _refused(
        self, goal: GoalContext, shot: Shot, text: str, meaning: Meaning
    ) -> dict[str, Any]:
        if meaning.happened == "no":
            self._shot_log.denied(shot)
        elif await self._settled(shot):
            return {"shot_id": shot.name}
        raise self._failed(
            "measure", meaning.error, f"it answered {text!r}: {meaning.now}", meaning.happened
        )

    async def _settled(self, shot: Shot) -> bool:
        """Wait until the cache shows that this shot was fired (True), or no longer can (False)."""
        while True:
            new = await self._new_entries(shot)
            if new is not None and len(new) == 1:
                self._shot_log.fired(shot, new[0])
                return True
            if not self._may_still_show(shot):
                kept = self._shot_log.shot(shot.name)
                return kept is not None and kept.fate == "fired"
            await asyncio.sleep(LOOK_S)

    def _may_still_show(self, shot: Shot) -> bool:
        known = self._shot_log.shot(shot.name)
        if known is None or known.fate != "begun":
            return False
        age = time.time() - shot.at
        if self._cache is not None and age < CACHE_LATE_S:
            return True
        answer_may_come = self._awaited == (shot.number, self._link.connections)
        return answer_may_come and self._link.up.is_set() and age < 2 * self.settings.measure_s

    async def _new_entries(self, shot: Shot) -> list[str] | None:
        """What is new in the cache since before this shot; None if the cache cannot be seen."""
        if self._cache is None or shot.before is None:
            return None
        try:
            return sorted(await self._cache.names() - shot.before)
        except FolderFault:
            return None

    def _note_late(self, shot: Shot, answer: tuple[Any, ...]) -> None:
        """An answer that came after the wait was given up still shows what happened."""
        self._awaited = None
        meaning = meaning_of(text_of(answer))
        if meaning is None and self._cache is None:
            self._shot_log.fired(shot, None)
        elif meaning is not None and meaning.happened == "no":
            self._shot_log.denied(shot)

    async def last_shot(self, goal: GoalContext) -> dict[str, Any]:
        newest = self._shot_log.newest()
        if newest is not None and newest.fate == "begun":
            await self._settled(newest)
            newest = self._shot_log.newest()
        if newest is None or newest.fate == "begun":
            # An empty log may be a new one, and the server itself remembers nothing.
            return {"shot_id": None, "goal_id": None}
        return {"shot_id": newest.name, "goal_id": newest.goal}

    async def export(self, goal: GoalContext, *, shot: str, file: str) -> dict[str, Any]:
        wanted_shot = self._exporting.shot_to_export(shot)
        data = self._exporting.kept_file(wanted_shot)
        if data is None:
            data = (await self._spectrum(goal, wanted_shot)).data
        return self._exporting.handed_over(goal, data, file)

    async def _spectrum(self, goal: GoalContext, shot: Shot) -> Arrived:
        """The shot's proved spectrum, stored on this machine."""
        came = await self._earlier_export(shot)
        if came:  # it has emptied its list since
            return self._exporting.keep(shot, came, None, None)
        shot, listed = await self._listed(shot)
        came = await self._export(goal, shot)
        self._shot_log.learn("lost", "")
        after = await self._cache_before("export") if listed is not None else None
        return self._exporting.keep(shot, came, listed, after)

    def _lost(self) -> list[str]:
        """Shots in a row whose spectrum did not arrive whole."""
        return (self._shot_log.fact("lost") or "").split()

    async def _listed(self, shot: Shot) -> tuple[Shot, frozenset[str] | None]:
        """The shot, and what its cache holds, None if it cannot be seen; it must hold this shot."""
        listed = await self._cache_before("export")
        if listed is None or shot.before is None:
            return shot, None
        new = sorted(listed - shot.before)
        if shot.entry is None and len(new) == 1:
            self._shot_log.fired(shot, new[0])
            shot = replace(shot, entry=new[0])
        if shot.entry not in listed:
            raise self._failed(
                "export", "UnknownShot",
                f"{shot.entry or 'an entry of it'} is not in {self.settings.cache}, so no export could be "
                f"shown to be of {shot.name}; nothing was sent", "no",
            )  # fmt: skip
        return shot, frozenset(listed)

    async def _earlier_export(self, shot: Shot) -> list[Arrived]:
        """What an export whose answer was lost left behind; the server cannot repeat it."""
        if shot.asked is None or not await self._names_since(shot.asked):
            return []
        try:
            return await arrived(self._exports, self._wanted(shot), self.settings.export_s / 2)
        except NotArrived:
            return []

    async def _names_since(self, before: frozenset[str]) -> set[str]:
        try:
            return await self._exports.names() - before
        except FolderFault as fault:
            raise self._failed("export", "Rejected", f"{fault}; nothing was sent", "no") from fault

    async def _export(self, goal: GoalContext, shot: Shot) -> list[Arrived]:
        before = await self._names_since(frozenset())
        shot = self._shot_log.asked(shot, before, f"{time.time():.3f}")
        meaning, said = None, "'success'"
        try:
            answer = await self._link.ask("export", "data", self.settings.export_s)
            said, meaning = repr(text_of(answer)), meaning_of(text_of(answer))
        except NotSent as fault:
            raise self._failed("export", "Rejected", f"{fault}; nothing was sent", "no") from fault
        except AnswerLost as fault:
            said = str(fault)
        if meaning is not None and meaning.happened == "no":
            raise self._failed("export", meaning.error, f"it answered {said}: {meaning.now}", "no")
        goal.feedback(0.5, "waiting for the complete file")
        try:
            return await arrived(self._exports, self._wanted(shot), self.settings.export_s)
        except NotArrived as fault:
            self._shot_log.learn("lost", " ".join({*self._lost(), shot.name}))
            error = "DiskFull" if fault.full else meaning.error if meaning else "Timeout"
            raise self._failed(
                "export", error,
                f"it answered {said}, but in {self.settings.exports} {fault}{await self._clock_words(shot)}. "
                f"It clicks Delete half a second after it has begun the export: keep what is there, and "
                f"check the disk and the program", "unknown",
            ) from fault  # fmt: skip

    def _wanted(self, shot: Shot) -> Wanted:
        begun = [float(at) + self.settings.clock_s for at in shot.typed]
        return Wanted(
            before=shot.asked or frozenset(),
            pattern=self.settings.spectrum,
            channels=self._exporting.channels(),
            ours=lambda name: self._apart(name, begun) <= CLOCKS_AGREE_S,
            settle_s=self.settings.settle_s,
            breaks_off=True,  # it clicks Delete, whether or not the program still writes
        )

    def _apart(self, name: str, begun: list[float]) -> float:
        """Seconds between a time in a name and one of these."""
        return min((abs(at - b) for at in times_in(name) for b in begun), default=math.inf)

    async def _clock_words(self, shot: Shot) -> str:
        """A hint where what came bears another time than that of the request."""
        new = await self._names_since(shot.asked or frozenset())
        apart = [at - float(t) for name in new for at in times_in(name) for t in shot.typed]
        nearest = min(apart, key=abs, default=None)
        if nearest is None or abs(nearest - self.settings.clock_s) <= CLOCKS_AGREE_S:
            return ""
        return (
            f" (a name there says that it was begun {nearest:+.0f} s from the request: it is another "
            f"export's; or, if that computer's clock is off by so much, write `clock_s: {nearest:.0f}`)"
        )

    async def disarm(self, goal: GoalContext) -> dict[str, Any]:
        try:
            await self.safe()
        except OSError as fault:
            raise self._failed("disarm", "Timeout", str(fault), "unknown") from fault
        return {}

    async def locate(self, goal: GoalContext) -> dict[str, Any]:
        try:
            answer = await self._link.ask("find_buttons", "data", self.settings.locate_s)
        except (NotSent, AnswerLost) as fault:
            raise self._failed(
                "find_buttons", "ButtonNotFound",
                f"{fault}; its search ends like this when a template is missing: see its window", "no",
            ) from fault  # fmt: skip
        places = answer[0] if answer else None
        wrong = _fault_in_places(places)
        if wrong is not None:
            raise self._failed("find_buttons", "ButtonNotFound", wrong, "no")
        return {}

    async def reconnect(self, goal: GoalContext) -> dict[str, Any]:
        try:
            await self._link.renew(self.settings.connect_s)
            await self._set_export_path()
            self._shot_log.learn("lost", "")
        except OSError as fault:
            raise self._failed("reconnect", "Timeout", str(fault), "unknown") from fault
        return {}

    async def _set_export_path(self) -> None:
        """Set the server's export folder, if the lab names it; raises OSError."""
        path = self.settings.export_path
        if path is None or path == self._link.export_path:
            return
        try:
            answer = await self._link.ask("change_export_path", path, self.settings.connect_s)
        except (NotSent, AnswerLost) as fault:
            raise OSError(f"change_export_path {path!r} at {self.settings.url}: {fault}") from fault
        if text_of(answer) != "success":
            raise OSError(
                f"the analyser server at {self.settings.url} was asked to export into {path!r} and "
                f"answered {text_of(answer)!r}; `export_path` is the folder's path on its machine"
            )

    def _failed(self, asked: str, error: str, words: str, happened: Any) -> ActionFailed:
        where = f"{self.place.device} (analyser server {self.settings.url}), asked to {asked}"
        return ActionFailed(error, f"{where}: {words}", happened)


def _fault_in_places(places: Any) -> str | None:
    """Its search takes the best match for every button, however bad; two at one place reveal that."""
    try:
        points = [(int(x), int(y)) for x, y in places]
    except (TypeError, ValueError):
        return f"it answered {places!r}, where the places of {BUTTONS} buttons are expected"
    if len(points) != BUTTONS:
        return f"it found {len(points)} buttons, where {BUTTONS} are expected"
    if len(set(points)) < len(points):
        twice = next(p for p in points if points.count(p) > 1)
        return f"it found two buttons at {twice[0]},{twice[1]}: at least one of them is not visible"
    return None
