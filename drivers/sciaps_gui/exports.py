"""Export one shot through the program's dialogs, check and store its spectrum, then delete."""

import functools
import time
from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from ..analyser.cache import Cache
from ..analyser.export_arrival import NO_ROOM, Arrived, NotArrived, Wanted, arrived, has_name
from ..analyser.exporting import Exporting
from ..analyser.folder import FolderFault, SharedFolder
from ..analyser.shot_log import Shot, ShotLog
from ..driver import ActionFailed, GoalContext
from ..window_program.buttons import Buttons
from ..window_program.faults import failure_of
from ..window_program.program import NoScreen, NotClicked, Program, Trouble
from .settings import SciapsGuiSettings

AGAIN_S = 3.0
T = TypeVar("T")


class Analyser(Protocol):
    """What an export needs from its driver."""

    settings: SciapsGuiSettings

    @property
    def program(self) -> Program: ...
    @property
    def shot_log(self) -> ShotLog: ...
    @property
    def exporting(self) -> Exporting: ...
    @property
    def cache(self) -> Cache: ...
    @property
    def buttons(self) -> Buttons: ...
    async def on_screen(self, act: Callable[[], T]) -> T: ...
    async def ready(self, goal: GoalContext, asked: str) -> None: ...
    async def tried(self, asked: str, happened: Any, act: Callable[[], T]) -> T: ...
    async def sync(self, goal: GoalContext, happened: Any) -> None: ...
    def expect_dialog(self, of: str) -> None: ...
    async def picture(self) -> str: ...
    def failed(self, asked: str, error: str, words: str, happened: Any) -> ActionFailed: ...


class Exports:
    """The driver's part that deals with the export dialog and the export folder."""

    def __init__(self, driver: Analyser) -> None:
        self._driver = driver
        self._settings = driver.settings
        self._folder = SharedFolder(self._settings.exports)

    async def spectrum(self, goal: GoalContext, shot: Shot) -> bytes:
        """Store the shot's proved spectrum on this machine; only then may its cache entry be deleted."""
        listed = await self._listed(shot)
        came = await self._earlier(shot) or await self._made(goal, shot)
        found = self._driver.exporting.keep(shot, came, frozenset(listed), await self._cache())
        goal.feedback(0.9, f"{found.channels} channels stored")
        if self._settings.delete == "file":
            await self._delete_file(shot)
        elif self._settings.delete == "button":
            await self._delete_by_button(goal, shot)
        if self._settings.sync:
            await self._driver.sync(goal, "yes")
        return found.data

    async def _listed(self, shot: Shot) -> set[str]:
        """What the program's cache holds; raises ActionFailed if this shot is not in it."""
        listed = await self._cache()
        if shot.entry in listed:
            return listed
        known = f"its entry {shot.entry}" if shot.entry else "an entry of it"
        raise self._failed(
            "UnknownShot",
            f"{known} is not in {self._settings.cache}, so no export could be shown to be of {shot.name}; "
            f"nothing was clicked", "no",
        )  # fmt: skip

    async def _cache(self) -> set[str]:
        try:
            return await self._driver.cache.names()
        except FolderFault as fault:
            raise self._failed("Rejected", f"{fault}; nothing was deleted", "unknown") from fault

    @property
    def _program(self):
        return self._driver.program

    @property
    def _dialog_s(self) -> float:
        return self._settings.dialog_s

    async def _earlier(self, shot: Shot) -> list[Arrived]:
        """What an earlier attempt left in the folder after all."""
        if shot.asked is None or not shot.typed:
            return []
        try:
            return await arrived(self._folder, self._wanted(shot), AGAIN_S)
        except NotArrived:
            return []

    async def _made(self, goal: GoalContext, shot: Shot) -> list[Arrived]:
        await self._driver.ready(goal, "export")
        before = await self._room()
        name = f"{shot.name}_{time.strftime('%Y%m%d_%H%M%S')}"
        shot = self._driver.shot_log.asked(shot, before, name)
        self._driver.expect_dialog(shot.name)
        await self._steps(goal, name)
        self._driver.expect_dialog("")
        goal.feedback(0.6, "waiting for the complete file")
        try:
            return await arrived(self._folder, self._wanted(shot), self._settings.export_s)
        except NotArrived as fault:
            seen = await self._error_words()
            error = "DiskFull" if fault.full else "DialogOpen" if seen else "Timeout"
            raise self._failed(error, f"{fault}{seen}; nothing was deleted", "unknown") from fault

    async def _room(self) -> set[str]:
        """What is in the export folder; raises ActionFailed if it is missing or full."""
        try:
            free = await self._folder.free_bytes()
            names = await self._folder.names()
        except FolderFault as fault:
            raise self._failed("Rejected", f"{fault}; nothing was clicked", "no") from fault
        if free is not None and free < NO_ROOM:
            raise self._failed(
                "DiskFull",
                f"{self._folder.place} has only {free} bytes free; free some space and try again. Nothing "
                f"was clicked", "no",
            )  # fmt: skip
        return names

    async def _steps(self, goal: GoalContext, name: str) -> None:
        steps = self._driver.buttons.steps()
        texts = {"name": name, "folder": self._settings.export_path or self._folder.place}
        for n, (word, what) in enumerate(steps):
            goal.feedback(0.1 + 0.5 * n / len(steps), f"{word} {what}")
            try:
                step = functools.partial(
                    self._program.step, word, what.format(**texts), self._dialog_s
                )
                await self._driver.on_screen(step)
            except (Trouble, NoScreen, NotClicked) as fault:
                raise await self._broken_off(f"{word} {what}", fault) from fault
        word, last = steps[-1]
        if word == "click" and self._driver.buttons.button(last).where == "dialog":
            await self._driver.tried(
                "export", "unknown", lambda: self._program.wait_until_gone(last, self._dialog_s)
            )

    async def _broken_off(self, step: str, fault: Exception) -> ActionFailed:
        """Close the dialog, so that the next command finds the program as it should be."""
        error, words = failure_of(fault)  # type: ignore[arg-type]
        picture = await self._driver.picture()
        try:
            if isinstance(fault, Trouble) and fault.state == "error":
                await self._driver.on_screen(lambda: self._program.close_error(self._dialog_s))
            late_s = self._settings.busy_s if _may_come_late(fault) else 0.0
            leave = functools.partial(self._program.leave_dialogs, self._dialog_s, late_s)
            if await self._driver.on_screen(leave) or not late_s:
                self._driver.expect_dialog("")
            left = "its dialogs were closed"
        except (Trouble, NoScreen, NotClicked) as further:
            left = f"its dialog may still be open ({further})"
        return self._failed(error, f"at `{step}`: {words}; {left}{picture}", "no")

    async def _error_words(self) -> str:
        """Read and close a modal error that came instead of the file."""
        try:
            seen = await self._driver.on_screen(self._program.seen)
            if seen.state != "error":
                return ""
            picture = await self._driver.picture()
            await self._driver.on_screen(lambda: self._program.close_error(self._dialog_s))
        except (Trouble, NoScreen, NotClicked) as fault:
            return f"; {fault}"
        return f"; {seen.words}{picture}"

    def _wanted(self, shot: Shot) -> Wanted:
        named = any(
            "{name}" in what for word, what in self._driver.buttons.steps() if word == "type"
        )
        return Wanted(
            before=shot.asked or frozenset(), pattern=self._settings.spectrum,
            channels=self._driver.exporting.channels(),
            ours=(lambda name: has_name(name, shot.typed)) if named else (lambda name: True),
            settle_s=self._driver.exporting.settle_s(self._settings.settle_s),
        )  # fmt: skip

    async def _delete_file(self, shot: Shot) -> None:
        """Remove exactly the entry that was exported from the cache, by its name."""
        if shot.entry is None:
            return
        try:
            await self._driver.cache.remove(shot.entry)
        except OSError as fault:
            words = f"{shot.name} is exported and stored, but {shot.entry} could not be deleted: {fault}"
            raise self._failed("Rejected", words, "yes") from fault

    async def _delete_by_button(self, goal: GoalContext, shot: Shot) -> None:
        """Delete the program's selected entry, then check that it was the exported one."""
        before = await self._driver.cache.names()
        if shot.entry is None or shot.entry not in before:
            return
        await self._driver.ready(goal, "delete")
        self._driver.expect_dialog("delete")
        await self._driver.tried("delete", "yes", self._click_delete)
        self._driver.expect_dialog("")
        gone = before - await self._driver.cache.names_when_gone(shot.entry, self._dialog_s)
        if gone != {shot.entry}:
            words = ", ".join(sorted(gone)) or "nothing"
            raise self._failed(
                "Rejected",
                f"{shot.name} is exported and stored, but the program deleted {words} instead of "
                f"{shot.entry}; check which entry is selected in its list", "yes",
            )  # fmt: skip

    def _click_delete(self) -> None:
        self._program.click("delete", self._dialog_s)
        if "delete_yes" in self._driver.buttons:
            self._program.confirm(("delete_yes",), self._dialog_s, self._dialog_s)

    def _failed(self, error: str, words: str, happened: str) -> ActionFailed:
        return self._driver.failed("export", error, words, happened)


def _may_come_late(fault: Exception) -> bool:
    """Whether a dialog that was asked for has not been seen yet."""
    return isinstance(fault, Trouble) and fault.state == "unseen"
