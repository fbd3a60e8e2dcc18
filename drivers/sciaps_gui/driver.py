"""Implements libs_analyzer@1 with an analyser's desktop program, by keyboard and mouse.

One goal is one click: it is in the shot log before it is made, and is never repeated. The one new
entry in the program's cache, by its name, shows whether it fired. Exported spectra are copied and
checked before anything is deleted.
"""

import asyncio
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from ..analyser.cache import Cache
from ..analyser.exporting import Exporting
from ..analyser.folder import FolderFault, SharedFolder, see_that_it_is_there
from ..analyser.settings import settings_of
from ..analyser.shot_log import AlreadyBegun, Shot, ShotLog
from ..analyser.spectrum_store import SpectrumStore
from ..driver import ActionFailed, Driver, GoalContext, Place
from ..find import DriverFault
from ..window_program.buttons import Buttons, ButtonsFault, read_buttons
from ..window_program.desktop import window_on_screen
from ..window_program.faults import failure_of, put_picture
from ..window_program.program import Aim, Hangs, NoScreen, NotClicked, Program, Seen, Trouble
from .exports import Exports
from .settings import SciapsGuiSettings

LOOK_S = 0.25
CALM_S = 8.0
CONFIRM_S = 2.0
"""How long after a click on `sync` its window is waited for; one that comes later is met by `ready`."""
ANSWER_S = 45.0
"""How long the probe waits for a shot that may still appear."""

T = TypeVar("T")


class SciapsGui(Driver):
    """Runs on the analyser's own computer, in the session whose screen shows the program."""

    contract: ClassVar[str] = "libs_analyzer@1"
    extra: ClassVar[str | None] = "gui"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.settings = settings_of(place, SciapsGuiSettings)
        try:
            self._buttons: Buttons = read_buttons(Path(self.settings.buttons).expanduser())
        except ButtonsFault as fault:
            raise DriverFault(str(fault)) from fault
        self._cache = Cache(self.settings.cache, self.settings.cache_entry)
        self._title = self._buttons.title if self.settings.title is None else self.settings.title
        self.alone = window_on_screen(self._title)
        self._spectra_kept = SpectrumStore(place.folder / "spectra")
        self._program: Program | None = None
        self._measuring = False

    async def open(self) -> None:
        await see_that_it_is_there("cache", SharedFolder(self.settings.cache))
        await see_that_it_is_there("exports", SharedFolder(self.settings.exports))
        self._program = await asyncio.to_thread(Program, self._buttons, self._title)
        self._shot_log = ShotLog(self.place.folder / "shots.sqlite")
        self._exporting = Exporting(
            self.place.device, self._shot_log, self._spectra_kept, self.settings.channels
        )
        self._exports = Exports(self)

    async def close(self) -> None:
        if self._program is not None:
            self._program.permission.halt()
            await asyncio.to_thread(self._program.close)
            self._shot_log.close()

    @property
    def program(self) -> Program:
        assert self._program is not None, "the driver is not open"
        return self._program

    @property
    def shot_log(self) -> ShotLog:
        return self._shot_log

    @property
    def exporting(self) -> Exporting:
        return self._exporting

    @property
    def cache(self) -> Cache:
        return self._cache

    @property
    def buttons(self) -> Buttons:
        return self._buttons

    async def on_screen(self, act: Callable[[], T]) -> T:
        """Look or click, in a thread, one at a time."""
        return await asyncio.to_thread(lambda: self.program.alone(act))  # type: ignore[return-value]

    async def status(self) -> dict[str, Any]:
        return {"armed": self._measuring, "shots": self._shot_log.count(), "interlock": "unknown"}

    async def safe(self) -> None:
        """Make no more clicks, and wait for a shot that is under way.

        The laser fires only on a click. If `disarm` was recorded it is clicked, too. Raises
        OSError if a click may still take effect.
        """
        self.program.permission.halt()
        newest = self._shot_log.newest()
        if newest is not None and newest.fate == "begun":
            await self._calm(newest)
        if "disarm" in self._buttons:
            self.program.permission.allow()
            try:
                await self.on_screen(lambda: self.program.click("disarm", self.settings.dialog_s))
            except (Trouble, NoScreen, NotClicked) as fault:
                raise OSError(f"its button `disarm` could not be clicked: {fault}") from fault
            finally:
                self.program.permission.halt()

    async def _calm(self, shot: Shot) -> None:
        """Wait until a begun shot is over: it shows in the cache, or its time has passed."""
        end = time.monotonic() + CALM_S
        while time.time() - shot.at < self.settings.measure_s:
            if await self._found(shot):
                return
            if time.monotonic() > end:
                raise OSError(
                    f"a shot was clicked {time.time() - shot.at:.0f} s ago and has left nothing in the "
                    f"cache yet; it cannot be stopped from here: use the switch on the analyser"
                )
            await asyncio.sleep(LOOK_S)

    async def measure(self, goal: GoalContext) -> dict[str, Any]:
        self.program.permission.allow(goal.cancelled.is_set)
        aim = await self._aimed(goal)
        shot = self._begun(goal, await self._cache_before())
        self._measuring = True
        try:
            await self._press(goal, shot, aim)
            return await self._watched(goal, shot)
        finally:
            self._measuring = False

    async def _aimed(self, goal: GoalContext) -> Aim:
        """Aim at `measure` in an idle program; one that hangs just then is waited for."""
        end = time.monotonic() + self.settings.busy_s

        def aim() -> Aim | None:
            try:
                return self.program.aim("measure", 0.0)
            except Hangs:
                if time.monotonic() > end:
                    raise
                return None

        while True:
            await self.ready(goal, "measure")
            aimed = await self.tried("measure", "no", aim)
            if aimed is not None:
                return aimed

    async def _cache_before(self) -> set[str]:
        try:
            return await self._cache.names()
        except FolderFault as fault:
            raise self.failed(
                "measure", "Rejected", f"{fault}; nothing was clicked", "no"
            ) from fault

    def _begun(self, goal: GoalContext, before: set[str]) -> Shot:
        try:
            return self._shot_log.begin(goal.id, time.time(), before)
        except AlreadyBegun as fault:
            raise self.failed("measure", "Rejected", str(fault), "unknown") from fault
        except OSError as fault:
            raise self.failed(
                "measure", "Rejected", f"{fault}; nothing was clicked", "no"
            ) from fault

    async def _press(self, goal: GoalContext, shot: Shot, aim: Aim) -> None:
        def press() -> None:
            if goal.cancelled.is_set():  # a stop came while it waited, looked and aimed
                raise NotClicked("it was stopped")
            self.program.press(aim)

        try:
            await self.on_screen(press)
        except NotClicked as fault:
            self._shot_log.denied(shot)
            raise self.failed(
                "measure", "Rejected", f"{fault}; nothing was clicked", "no"
            ) from fault

    async def _watched(self, goal: GoalContext, shot: Shot) -> dict[str, Any]:
        """Follow one click until the cache shows its shot; never click again, whatever happens."""
        left_s, hung_s = self.settings.measure_s, self.settings.hang_s
        looked = time.monotonic()
        while True:
            if await self._found(shot):
                await self._quiet(goal)
                return {"shot_id": shot.name}
            seen = await self._look()
            now = time.monotonic()
            if seen.state == "hung" and hung_s > 0:
                hung_s -= now - looked
                goal.feedback(None, f"{seen.words}; the click waits there and is not repeated")
            else:
                left_s -= now - looked
            looked = now
            if seen.state == "error":
                await self._closed_error(shot, seen)
            if left_s <= 0 or hung_s < 0:
                raise self._nothing_came(seen)
            await asyncio.sleep(LOOK_S)

    def _nothing_came(self, seen: Seen) -> ActionFailed:
        """After one click and no entry it is unknown whether the laser fired."""
        words = f"it was clicked once, and {self.settings.cache} has no new entry"
        if seen.state == "dialog":
            return self.failed("measure", "DialogOpen", f"{words}: {seen.words}", "unknown")
        if seen.state == "hung":
            return self.failed("measure", "Timeout", f"{words}: {seen.words}", "unknown")
        return self.failed(
            "measure", "Lost", f"{words} after {self.settings.measure_s:g} s", "unknown"
        )

    async def _closed_error(self, shot: Shot, seen: Seen) -> None:
        """A modal error after the click: read, closed, and reported with the lab's meaning for it."""
        picture = await self.picture()
        try:
            await self.on_screen(lambda: self.program.close_error(self.settings.dialog_s))
            closed = "it was closed"
        except (Trouble, NoScreen, NotClicked) as fault:
            closed = f"it could not be closed: {fault}"
        if await self._found(shot):
            raise self.failed(
                "measure", "DialogOpen", f"{seen.words}; it fired; {closed}{picture}", "yes"
            )
        happened = self._buttons.button(seen.sign).happened
        if happened == "no":
            self._shot_log.denied(shot)
        raise self.failed("measure", "DialogOpen", f"{seen.words}; {closed}{picture}", happened)

    async def _look(self) -> Seen:
        """The state; if it cannot be seen, reports a dialog, since something hides the program."""
        try:
            return await self.on_screen(self.program.seen)
        except (Trouble, NoScreen) as fault:
            return Seen("dialog", str(fault))

    async def _found(self, shot: Shot, asked: str = "measure") -> bool:
        """Whether the cache shows this shot; raises ActionFailed if it shows more than one."""
        try:
            new = sorted(await self._cache.names() - (shot.before or frozenset()))
        except FolderFault:
            return False
        if len(new) > 1:
            raise self.failed(
                asked, "Lost",
                f"{' and '.join(new)} are new in the cache after one click: one is from another click, "
                f"and it is unclear which one belongs to this shot", "yes",
            )  # fmt: skip
        if new:
            self._shot_log.fired(shot, new[0])
        return bool(new)

    async def _quiet(self, goal: GoalContext) -> None:
        """With the shot stored, wait a while until the program is ready for the next command."""
        end = time.monotonic() + self.settings.busy_s
        while (seen := await self._look()).state in ("busy", "hung") and time.monotonic() < end:
            goal.feedback(0.9, seen.words)
            await asyncio.sleep(LOOK_S)

    async def last_shot(self, goal: GoalContext) -> dict[str, Any]:
        newest = self._shot_log.newest()
        end = time.monotonic() + ANSWER_S
        while newest is not None and newest.fate == "begun":
            try:
                if await self._found(newest):
                    newest = self._shot_log.newest()
                    break
            except ActionFailed:  # several are new: it certainly happened, but its entry is unclear
                break
            late = time.time() - newest.at > self.settings.measure_s + self.settings.hang_s
            if late or time.monotonic() > end:
                break
            await asyncio.sleep(LOOK_S)
        if newest is None or newest.fate == "begun":
            return {"shot_id": None, "goal_id": None}
        return {"shot_id": newest.name, "goal_id": newest.goal}

    async def export(self, goal: GoalContext, *, shot: str, file: str) -> dict[str, Any]:
        self.program.permission.allow(goal.cancelled.is_set)
        wanted = self._exporting.shot_to_export(shot)
        data = self._exporting.kept_file(wanted)
        if data is None:
            if wanted.entry is None and await self._found(wanted, "export"):
                wanted = self._exporting.shot_to_export(shot)
            data = await self._exports.spectrum(goal, wanted)
        return self._exporting.handed_over(goal, data, file)

    async def disarm(self, goal: GoalContext) -> dict[str, Any]:
        try:
            await self.safe()
        except OSError as fault:
            raise self.failed("disarm", "Timeout", str(fault), "unknown") from fault
        return {}

    async def locate(self, goal: GoalContext) -> dict[str, Any]:
        self.program.permission.allow(goal.cancelled.is_set)
        sights = await self.tried("find its buttons", "no", self.program.locate)
        lost = [sight.words() for sight in sights.values() if sight.sure is None]
        if lost:
            view = self.program.last_view
            cover = f"; {view.cover}" if view is not None and view.cover else ""
            words = "; ".join(lost) + cover + await self.picture()
            raise self.failed("find its buttons", "ButtonNotFound", words, "no")
        goal.feedback(1.0, "; ".join(sight.words() for sight in sights.values()))
        return {}

    async def reconnect(self, goal: GoalContext) -> dict[str, Any]:
        self.program.permission.allow(goal.cancelled.is_set)
        await self.ready(goal, "reconnect")
        await self.sync(goal, "unknown")
        return {}

    async def sync(self, goal: GoalContext, happened: Any) -> None:
        """Click `sync`, if it was recorded, and confirm the window that it may open."""
        if "sync" not in self._buttons:
            return
        await self.ready(goal, "sync")
        dialog_s = self.settings.dialog_s
        await self.tried("sync", happened, lambda: self.program.click("sync", dialog_s))
        self.expect_dialog("sync")
        try:
            await self.tried("sync", happened, lambda: self._confirm_sync(min(dialog_s, CONFIRM_S)))
        except ActionFailed:
            await self.tried("sync", happened, lambda: self.program.leave_dialogs(dialog_s))
            raise

    def _confirm_sync(self, appears_s: float) -> None:
        self.program.confirm(("sync_yes", "delete_yes"), appears_s, self.settings.dialog_s)

    def expect_dialog(self, of: str) -> None:
        """Note on disk that a window of our own may be open from now on, or none any more."""
        self._shot_log.learn("dialog", of)

    async def ready(self, goal: GoalContext, asked: str) -> None:
        """Wait until the program is idle; a known error is closed, an unknown dialog is not touched."""
        end = time.monotonic() + self.settings.busy_s
        while True:
            seen: Seen = await self.tried(asked, "no", self.program.seen)
            if seen.state == "idle":
                return
            words = f"{seen.words}; nothing was clicked"
            if seen.state == "dialog":
                if not await self._left_own_dialog(asked):
                    raise self.failed(asked, "DialogOpen", words + await self.picture(), "no")
            elif seen.state == "error":
                goal.feedback(None, f"{seen.words}; closing it")
                await self.tried(
                    asked, "no", lambda: self.program.close_error(self.settings.dialog_s)
                )
            elif time.monotonic() > end:
                error = "Busy" if seen.state == "busy" else "Rejected"
                raise self.failed(asked, error, f"{words}, after {self.settings.busy_s:g} s", "no")
            await asyncio.sleep(LOOK_S)

    async def _left_own_dialog(self, asked: str) -> bool:
        """Close a window that an earlier click of ours opened, and that came late or outlived a kill."""
        of = self._shot_log.fact("dialog")
        if not of or not await self.tried(asked, "no", self.program.knows_dialog):
            return False
        dialog_s = self.settings.dialog_s
        if of == "sync":
            await self.tried(asked, "no", lambda: self._confirm_sync(dialog_s))
        else:
            await self.tried(asked, "no", lambda: self.program.leave_dialogs(dialog_s))
        self.expect_dialog("")
        return True

    async def tried(self, asked: str, happened: Any, act: Callable[[], T]) -> T:
        """Do something on the screen; trouble there becomes an error of the contract."""
        try:
            return await self.on_screen(act)
        except (Trouble, NoScreen, NotClicked) as fault:
            error, words = failure_of(fault)
            raise self.failed(asked, error, words + await self.picture(), happened) from fault

    async def picture(self) -> str:
        """Save the last picture beside the shot log; returns a note that says where."""
        view = self.program.last_view
        return await asyncio.to_thread(put_picture, view, self.place.folder / "seen")

    def failed(self, asked: str, error: str, words: str, happened: Any) -> ActionFailed:
        title = self._title or "the screen"
        where = f"{self.place.device} (the program {title!r}), asked to {asked}"
        return ActionFailed(error, f"{where}: {words}", happened)
