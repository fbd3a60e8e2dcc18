"""Keeps any contract with a program that has only a window, by steps that its lab writes down.

A `once` action is in a log on disk before its first step, and is never begun a second time. Nothing
counts as done until its proof is seen; what was clicked and not proved is unknown.
"""

import asyncio
import functools
import time
from fnmatch import fnmatch
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

from ...schemas.contract import RESERVED_ERRORS
from ...schemas.messages import FileContent
from ..analyser.folder import FolderFault, SharedFolder, see_that_it_is_there
from ..analyser.shot_log import AlreadyBegun, Shot, ShotLog
from ..driver import ActionFailed, Driver, GoalContext, Place
from ..find import DriverFault
from .buttons import ButtonsFault, read_buttons
from .config import ActionSteps, Proof, read_config
from .controls import Control
from .desktop import window_on_screen
from .faults import failure_of, put_picture
from .program import NoScreen, NotClicked, Program, Trouble

LOOK_S = 0.25
SEEN = ("click", "tick", "untick", "wait", "gone")
HARMLESS_IF_FAILED = ("click", "wait", "gone", "type", "press")
"""A first step that fails like this has clicked nothing; a box may have been clicked before it fails."""


class WindowProgram(Driver):
    """Implements whichever contract its lab names; runs in the session whose screen shows the program."""

    any_contract: ClassVar[bool] = True
    extra: ClassVar[str | None] = "gui"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        if place.contract is None:
            raise ValueError("window_program needs a contract")
        self.contract_kept = place.contract
        self.settings = read_config(place.config, place.contract)
        try:
            self._buttons = read_buttons(Path(self.settings.buttons).expanduser(), needed=())
        except ButtonsFault as fault:
            raise DriverFault(str(fault)) from fault
        self._check_buttons()
        self._title = self._buttons.title if self.settings.title is None else self.settings.title
        self.alone = window_on_screen(self._title)
        self._program: Program | None = None
        for name in place.contract.actions:
            setattr(self, name, functools.partial(self._do, name))

    def _check_buttons(self) -> None:
        """Raise DriverFault for a picture that a step needs and that was not recorded."""
        for name, one in self.settings.actions.items():
            boxes = [
                w for step in one.steps for word, w in step.words() if word in ("tick", "untick")
            ]
            for box in boxes:
                if box in self._buttons and not self._buttons.button(box).tickable:
                    raise DriverFault(f"config.actions.{name}: record {box}.on, ticked, as well")
            wanted = [what for step in one.steps for word, what in step.words() if word in SEEN]
            wanted += (
                [what for what in (one.proof.shows, one.proof.gone) if what] if one.proof else []
            )
            reads = one.proof.reads if one.proof else None
            if reads is not None and not self._buttons.controls([reads]):
                raise DriverFault(
                    f"config.actions.{name}.proof.reads: {reads} has no `control` in "
                    f"{self._buttons.folder}: only a control's text can be read"
                )
            for what in wanted:
                if "{" not in what and what not in self._buttons:
                    raise DriverFault(
                        f"config.actions.{name}: {what} was not recorded; record it with `labrun "
                        f"record-program --buttons -o {self._buttons.folder} --where {what}=dialog`"
                    )

    async def open(self) -> None:
        for name, one in self.settings.actions.items():
            if one.proof is not None and one.proof.new is not None and "{" not in one.proof.new:
                word = f"actions.{name}.proof.new"
                await see_that_it_is_there(word, SharedFolder(one.proof.new))
        self._program = await asyncio.to_thread(Program, self._buttons, self._title)
        self._log = ShotLog(self.place.folder / "clicks.sqlite")

    async def close(self) -> None:
        if self._program is not None:
            self._program.permission.halt()
            await asyncio.to_thread(self._program.close)
            self._log.close()

    async def safe(self) -> None:
        """Make no more clicks; then do the actions of the contract's safe state that have steps."""
        assert self._program is not None, "the driver is not open"
        self._program.permission.halt()
        for name in self.contract_kept.safe_state:
            one = self.settings.actions.get(name)
            if one is not None and one.steps:
                try:
                    await self._do(name, GoalContext(f"safe:{name}"))
                except ActionFailed as fault:
                    raise OSError(fault.message) from fault
                finally:
                    self._program.permission.halt()

    async def _do(self, name: str, goal: GoalContext, **params: Any) -> dict[str, Any]:
        one = self.settings.actions.get(name)
        if one is None:
            return await self._last(name)
        assert self._program is not None, "the driver is not open"
        self._program.permission.allow(goal.cancelled.is_set)
        once = self.contract_kept.actions[name].effect == "once"
        await self._idle(name)
        texts = {**params, "name": f"{self.place.device}_{time.strftime('%Y%m%d_%H%M%S')}"}
        before = await self._before(name, one.proof, texts)
        begun = self._begin(name, goal, before) if once else None
        await self._steps(name, one, goal, texts, begun)
        found = await self._proved(name, one, texts, before)
        if begun is not None:
            self._log.fired(begun, found)
        return await self._result(one, goal, texts, found)

    async def _last(self, name: str) -> dict[str, Any]:
        """The answer of a probe: the newest goal that was begun and proved, null if that is unclear."""
        newest = self._log.newest()
        if newest is not None and newest.fate == "begun":
            newest = await self._proved_since(name, newest)
        known = newest is not None and newest.fate == "fired"
        results = self.contract_kept.actions[name].returns.get("properties", {})
        return dict.fromkeys(results) | {"goal_id": newest.goal if newest and known else None}

    async def _proved_since(self, probe: str, shot: Shot) -> Shot | None:
        """Look once more for a proof that a killed server did not wait for."""
        asking = [n for n, action in self.contract_kept.actions.items() if action.probe == probe]
        one = self.settings.actions.get(asking[0]) if len(asking) == 1 else None
        if one is None or one.proof is None or one.proof.new is None:
            return shot
        if "{" in one.proof.new + one.proof.called:
            return shot
        found, _ = await self._seen(asking[0], one.proof, {}, set(shot.before or ()))
        if found:
            self._log.fired(shot, found)
        return self._log.newest()

    def _begin(self, name: str, goal: GoalContext, before: set[str]) -> Shot:
        try:
            return self._log.begin(goal.id, time.time(), before)
        except AlreadyBegun as fault:
            raise self._failed(name, "Rejected", str(fault), "unknown") from fault
        except OSError as fault:
            raise self._failed(name, "Rejected", f"{fault}; nothing was clicked", "no") from fault

    async def _idle(self, name: str) -> None:
        """Wait until the program responds and no window of unknown origin is open over it."""
        assert self._program is not None
        end = time.monotonic() + self.settings.busy_s
        while True:
            try:
                seen = await self._on_screen(functools.partial(self._program.seen, ""))
                if seen.state == "error":
                    dialog_s = self.settings.dialog_s
                    await self._on_screen(functools.partial(self._program.close_error, dialog_s))
                    continue
            except (Trouble, NoScreen, NotClicked) as fault:
                error, words = failure_of(fault)
                raise self._failed(name, error, f"{words}; nothing was clicked", "no") from fault
            if seen.state == "idle":
                return
            if seen.state == "dialog" or time.monotonic() > end:
                error = "DialogOpen" if seen.state == "dialog" else "Busy"
                raise self._failed(name, error, f"{seen.words}; nothing was clicked", "no")
            await asyncio.sleep(LOOK_S)

    async def _steps(
        self, name: str, one: ActionSteps, goal: GoalContext, texts: dict[str, Any],
        begun: Shot | None,
    ) -> None:  # fmt: skip
        assert self._program is not None
        done = 0
        for done, (word, what) in enumerate(w for step in one.steps for w in step.words()):
            goal.feedback(done / (len(one.steps) + 1), f"{word} {what}")
            filled = what.format(**texts)
            if word in SEEN and filled not in self._buttons:
                happened = "unknown" if done else "no"
                if begun is not None and not done:
                    self._log.denied(begun)
                raise self._failed(
                    name, "Rejected", f"{word} {filled}: it was not recorded", happened
                )
            try:
                await self._on_screen(functools.partial(self._step, goal, word, filled))
            except (Trouble, NoScreen, NotClicked) as fault:
                error, words = failure_of(fault)
                happened = "no" if not done and word in HARMLESS_IF_FAILED else "unknown"
                if begun is not None and happened == "no":
                    self._log.denied(begun)
                words = f"at `{word} {filled}`: {words}" + await self._picture()
                raise self._failed(name, error, words, happened) from fault

    def _step(self, goal: GoalContext, word: str, filled: str) -> None:
        if goal.cancelled.is_set():
            raise NotClicked("it was stopped")
        assert self._program is not None
        self._program.step(word, filled, self.settings.dialog_s)

    async def _before(self, name: str, proof: Proof | None, texts: dict[str, Any]) -> set[str]:
        """What looks like the proof before the first step, and so is none: names, or a text."""
        if proof is not None and proof.reads is not None:
            return {(await self._seen(name, proof, texts, set()))[0]} - {""}
        if proof is None or proof.new is None:
            return set()
        try:
            return await SharedFolder(proof.new.format(**texts)).names()
        except FolderFault as fault:
            raise self._failed(name, "Rejected", f"{fault}; nothing was clicked", "no") from fault

    async def _proved(
        self, name: str, one: ActionSteps, texts: dict[str, Any], before: set[str]
    ) -> str | None:
        """Wait for the proof; the name of what is new, if that is it."""
        if one.proof is None:
            return None
        end = time.monotonic() + one.within_s
        seen, still_since = ("", 0), time.monotonic()
        while True:
            now = await self._seen(name, one.proof, texts, before)
            if one.proof.reads is not None:
                # A text that was there before is none until another one was seen.
                before, now = (before, ("", 0)) if now[0] in before else (set(), now)
            if now != seen:
                seen, still_since = now, time.monotonic()
            settled = (
                one.proof.new is None or time.monotonic() - still_since > self.settings.settle_s
            )
            if now[0] and settled:
                return now[0]
            if time.monotonic() > end:
                wanted = one.proof.model_dump(exclude_none=True)
                raise self._failed(
                    name, "Timeout",
                    f"its steps were done, and after {one.within_s:g} s there is no proof: {wanted}"
                    + await self._picture(), "unknown",
                )  # fmt: skip
            await asyncio.sleep(LOOK_S)

    async def _seen(
        self, name: str, proof: Proof, texts: dict[str, Any], before: set[str]
    ) -> tuple[str, int]:
        """What of the proof is there now: its name, and its size; empty if nothing is."""
        assert self._program is not None
        if proof.new is not None:
            folder = SharedFolder(proof.new.format(**texts))
            called = proof.called.format(**texts)
            try:
                new = sorted(n for n in await folder.names() - before if fnmatch(n, called))
                size = sum((await folder.files(new[0])).values()) if len(new) == 1 else 0
            except FolderFault:
                return "", 0
            if len(new) > 1:
                raise self._failed(
                    name, "Lost",
                    f"{' and '.join(new)} are new in {folder.place}: it is unclear which one is of this "
                    f"goal; none is taken", "unknown",
                )  # fmt: skip
            return (new[0], size) if new else ("", 0)
        if proof.reads is not None and proof.says is not None:
            said = await self._on_screen(functools.partial(self._read, proof.reads))
            fits = said is not None and Control(name=proof.says.format(**texts)).fits(said, "")
            return (said, 0) if said and fits else ("", 0)
        shows = functools.partial(self._program.shows, proof.shows, proof.gone, proof.title)
        try:
            return ("it", 0) if await self._on_screen(shows) else ("", 0)
        except (Trouble, NoScreen):
            return "", 0

    def _read(self, name: str) -> str | None:
        assert self._program is not None
        try:
            return self._program.read(name)
        except (Trouble, NoScreen):
            return None

    async def _result(
        self, one: ActionSteps, goal: GoalContext, texts: dict[str, Any], found: str | None
    ) -> dict[str, Any]:
        result: dict[str, Any] = {key: text.format(**texts) for key, text in one.returns.items()}
        if one.file is not None and one.proof is not None and one.proof.new is not None and found:
            data = await SharedFolder(one.proof.new.format(**texts)).read(found)
            path, digest = str(texts.get(one.file, found)), sha256(data).hexdigest()
            goal.files[one.file] = FileContent(path=path, sha256=digest, data=data)
            result |= {one.file: path, "sha256": digest}
        return result

    async def _on_screen(self, act: Any) -> Any:
        assert self._program is not None
        return await asyncio.to_thread(self._program.alone, act)

    async def _picture(self) -> str:
        assert self._program is not None
        return await asyncio.to_thread(
            put_picture, self._program.last_view, self.place.folder / "seen"
        )

    def _failed(self, asked: str, error: str, words: str, happened: Any) -> ActionFailed:
        known = self.contract_kept.actions[asked].errors
        name = error if error in known or error in RESERVED_ERRORS else "Rejected"
        title = self._title or "the screen"
        return ActionFailed(
            name,
            f"{self.place.device} (the program {title!r}), asked to {asked}: {words}",
            happened,
        )
