"""The analyser's program as a state machine read off the screen: nothing is clicked unseen.

idle, busy, dialog (a window of its own that we did not open, or opened), error (a known sign of
one), hung (it does not respond). Calls block: it runs in its own thread.
"""

import contextlib
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from .buttons import Button, Buttons
from .by_name import found_in, look_by_name
from .check_box import ticked
from .controls import Controls
from .desktop import open_controls, open_windows
from .hands import Hands, Hangs, NotClicked
from .looking import look_in
from .match import Hit, Sighting, common_scale, differs, look_for
from .permission import Permission
from .view import Trouble, View, view_of
from .windows import NoScreen, Windows

LOOK_S = 0.15
PING_S = 1.0
CHANGE_S = 1.0
CLOSE_S = 10.0

State = Literal["idle", "busy", "dialog", "error", "hung"]


@dataclass(frozen=True, slots=True)
class Seen:
    """The program's state, a description, and the name of the error sign, if any."""

    state: State
    words: str
    sign: str = ""


@dataclass(frozen=True, slots=True)
class Aim:
    """A verified place under the mouse: one press away from a click."""

    name: str
    x: int
    y: int
    view: View


class Program:
    """Looks at the program and clicks in it; raises Trouble, NoScreen or NotClicked with the reason."""

    def __init__(self, buttons: Buttons, title: str) -> None:
        self.buttons = buttons
        self.title = title
        self.scale: float | None = None
        self.permission = Permission()
        self.last_view: View | None = None
        self._before: View | None = None  # when a button of the main window was last aimed at
        self._hands = Hands()
        self._controls: Controls | None = open_controls() if buttons.by_name else None
        self._windows: Windows = open_windows()
        self._lock = threading.RLock()
        self._ending = self._closed = False

    def close(self) -> None:
        """Once a look that is under way has ended; one that takes longer closes when it has."""
        self._ending = True
        if self._lock.acquire(timeout=CLOSE_S):
            self._end()
            self._lock.release()

    def alone(self, act: Callable[[], object]) -> object:
        """Do something while no other thread looks or clicks."""
        with self._lock:
            try:
                return act()
            finally:
                if self._ending:
                    self._end()

    def _end(self) -> None:
        if not self._closed:
            self._closed = True
            self._windows.close()

    def view(self) -> View:
        """A fresh look."""
        screen = self._hands.picture()
        ratio = self._hands.picture_scale(screen)
        self.last_view = view_of(self.title, self._windows, screen, ratio)
        return self.last_view

    def locate(self) -> dict[str, Sighting]:
        """All buttons of the main window, and with them the size at which it is drawn."""
        view = self.view()
        names = self.buttons.named("main")
        by_name = self._look_by_name(view, names)
        pictured = [self.buttons.template(n) for n in names if n not in by_name]
        sights = look_for(view.picture, pictured)
        self.scale = common_scale(sights.values())
        return {name: (sights | by_name)[name] for name in names}

    def seen(self, main: str = "measure") -> Seen:
        """What the program is doing; it is idle when the button `main` can be clicked, if there is one."""
        view = self.view()
        if view.main is not None and self._windows.alive(view.main, PING_S) is False:
            return Seen("hung", f"the program {view.main.title!r} does not respond")
        others = [*self.buttons.named("busy"), *([main] if main else [])]
        signs = self._look(view, [*self.buttons.named("error", "banner"), *others])
        error = self._error(signs, view)
        if error is not None:
            return Seen("error", self._error_words(error, view), error)
        if any(signs[name].hits for name in self.buttons.named("busy")):
            return Seen("busy", "the program shows that it is busy")
        if view.dialogs:
            return Seen("dialog", f"a window {view.dialogs[0].title!r} is open over the program")
        grey = bool(main) and self._the_one(main, signs[main], view).grey
        return Seen("busy", f"its button `{main}` is greyed out") if grey else Seen("idle", "")

    def _error(self, signs: dict[str, Sighting], view: View) -> str | None:
        """The error sign that is seen, together with the button that closes it if one was recorded.

        A sign alone is no error: a peak of the spectrum resembles a warning triangle, and a status bar
        says "Last error: none". A modal error has a window of its own, wherever windows can be listed.
        """
        closes = signs.get("error_close")
        modal = (view.main is None or bool(view.dialogs)) and (closes is None or bool(closes.hits))
        names = self.buttons.named("error", "banner") if modal else self.buttons.named("banner")
        return next((n for n in names if n != "error_close" and signs[n].hits), None)

    def _error_words(self, name: str, view: View) -> str:
        title = f" in a window {view.dialogs[0].title!r}" if view.dialogs else ""
        says = self.buttons.button(name).says
        return f"the program shows an error{title}" + (f": {says}" if says else "")

    def wait_for(self, name: str, timeout_s: float) -> tuple[View, Hit]:
        """Look until a button is there, once and not greyed out; an error sign ends the wait."""
        end = time.monotonic() + timeout_s
        while True:
            view = self.view()
            try:
                hit = self._the_one(name, self._look(view, [name])[name], view)
                if not hit.grey:
                    return view, hit
                trouble = Trouble("busy", f"{name} is greyed out")
            except Trouble as fault:
                trouble = fault
            if time.monotonic() >= end:
                raise Trouble(trouble.state, f"{trouble}, after {timeout_s:g} s of looking")
            if name != "error_close":
                self._no_error(view)
            time.sleep(LOOK_S)

    def wait_until_gone(self, name: str, timeout_s: float) -> None:
        """Look until a button is no longer there; raises Trouble."""
        end = time.monotonic() + timeout_s
        while self._look(self.view(), [name])[name].hits:
            if time.monotonic() >= end:
                raise Trouble(
                    "dialog", f"{name} was clicked and is still there after {timeout_s:g} s"
                )
            time.sleep(LOOK_S)

    def _no_error(self, view: View) -> None:
        error = self._error(self._look(view, self.buttons.named("error", "banner")), view)
        if error is not None:
            raise Trouble("error", self._error_words(error, view))

    def _look(self, view: View, names: list[str]) -> dict[str, Sighting]:
        """What is seen of some buttons at the program's size; found again if that has changed."""
        names = list(dict.fromkeys(names))
        by_name = self._look_by_name(view, names)
        pictured = [name for name in names if name not in by_name]
        if self.scale is None:
            self._find_scale(view)
        sights = look_in(view, self.buttons, pictured, self.scale)
        missing = "measure" in sights and not sights["measure"].hits and not view.dialogs
        if missing and self._find_scale(view):
            sights = look_in(view, self.buttons, pictured, self.scale)
        sights = {n: self._not_from_before(n, sight, view) for n, sight in sights.items()}
        return {name: (sights | by_name)[name] for name in names}

    def _look_by_name(self, view: View, names: list[str]) -> dict[str, Sighting]:
        """What is seen of those buttons that are controls with a name."""
        wanted = self.buttons.controls(names)
        if not wanted or self._controls is None:
            return {}
        return look_by_name(view, self.buttons, wanted, self._controls)

    def read(self, name: str) -> str | None:
        """The text of a control: what a field holds, or a label says; None where it is not there once."""
        control = self.buttons.controls([name])[name]
        assert self._controls is not None
        found = found_in(self.view(), control, self.buttons.button(name).where, self._controls)
        return found[0].text if len(found) == 1 else None

    def _not_from_before(self, name: str, sight: Sighting, view: View) -> Sighting:
        """A part of a dialog cannot have stood there when the click was made that opens the dialog."""
        before = self._before
        of_dialog = self.buttons.button(name.removesuffix(".on")).where == "dialog"
        if not of_dialog or view.dialogs or before is None or before.dialogs:
            return sight
        if (before.corner, before.picture.shape) != (view.corner, view.picture.shape):
            return sight
        fresh = [hit for hit in sight.hits if _changed(before, view, hit)]
        if len(fresh) == len(sight.hits):
            return sight
        return Sighting(name, tuple(fresh), replace(sight.hits[0], doubt="what stood there before"))

    def _find_scale(self, view: View) -> bool:
        """Learn the size from the main window's buttons; True where it is another than before."""
        names = self.buttons.named("main")
        by_name = self.buttons.controls(names)
        main = [self.buttons.template(n) for n in names if n not in by_name]
        found = common_scale(look_for(view.picture, main).values())
        changed = found is not None and found != self.scale
        self.scale = found if found is not None else self.scale
        return changed

    def _the_one(self, name: str, sight: Sighting, view: View) -> Hit:
        if sight.sure is not None:
            return sight.sure
        state = "twice" if sight.hits else "unseen"
        cover = f"; {view.cover}" if view.cover else ""
        raise Trouble(state, sight.words() + cover)

    def aim(self, name: str, timeout_s: float) -> Aim:
        """Find a button, put the mouse over it, and see that a click would reach the program.

        A program that hangs is waited for as well, and looked at anew.
        """
        end = time.monotonic() + timeout_s
        while True:
            view, hit = self.wait_for(name, max(0.0, end - time.monotonic()))
            button: Button = self.buttons.button(name.removesuffix(".on"))
            if button.where == "main":
                self._before = view
            x, y = hit.centre
            place = view.on_screen(x + button.at[0] * hit.scale, y + button.at[1] * hit.scale)
            aim = Aim(name, *place, view)
            self._hands.move(*place)
            try:
                self._check(aim)
            except Hangs:
                if time.monotonic() >= end:
                    raise
            else:
                return aim

    def _check(self, aim: Aim) -> None:
        if self.permission.halted:
            raise NotClicked("it was stopped")
        main = aim.view.main
        if main is None:
            return
        below = self._windows.at(aim.x, aim.y)
        if below not in (main.id, *(d.id for d in aim.view.dialogs)):
            raise NotClicked(f"at {aim.x},{aim.y} something else now covers {aim.name}")
        if self._windows.alive(main, PING_S) is False:
            raise Hangs(
                f"the program {main.title!r} does not respond: a click would take effect later"
            )

    def press(self, aim: Aim) -> None:
        """Click at the aimed place; raises NotClicked if it certainly did not click."""
        self._check(aim)
        self._hands.press_mouse(aim.x, aim.y)
        with contextlib.suppress(
            NotClicked, NoScreen, Trouble
        ):  # the click was made, whatever becomes of the mouse
            self._park()

    def _park(self) -> None:
        """Take the mouse off the button, which would be drawn otherwise under it, but not out of the
        window, which may then lose the keyboard: into the lower left corner."""
        view = self.view()
        windows = [*view.dialogs[:1], view.main]
        if windows[0] is not None:
            x, y, _, height = windows[0].box
            self._hands.move(max(6, x + 3), max(6, y + height - 4))

    def click(self, name: str, timeout_s: float) -> None:
        """Aim, click, and give the program a moment to show it."""
        aim = self.aim(name, timeout_s)
        self.press(aim)
        with contextlib.suppress(Trouble, NoScreen):  # the click was made; the next look tells more
            self._changed_since(aim.view)

    def step(self, word: str, what: str, timeout_s: float) -> None:
        """Do one step that was written down, with its texts filled in."""
        match word:
            case "click":
                self.click(what, timeout_s)
            case "type":
                self.type(what)
            case "press":
                self.key(what)
            case "tick" | "untick":
                self.tick(what, word == "tick", timeout_s)
            case "wait":
                self.wait_for(what, timeout_s)
            case "gone":
                self.wait_until_gone(what, timeout_s)

    def shows(self, name: str | None, gone: str | None, title: str | None) -> bool:
        """Whether a picture is seen now, or not seen, or a window's title holds these words."""
        view = self.view()
        if title is not None:
            windows = [view.main, *view.dialogs]
            return any(title in window.title for window in windows if window is not None)
        wanted = name or gone or ""
        return bool(self._look(view, [wanted])[wanted].hits) == (name is not None)

    def _changed_since(self, view: View) -> bool:
        end = time.monotonic() + CHANGE_S
        while time.monotonic() < end:
            if differs(self.view().picture, view.picture):
                return True
            time.sleep(LOOK_S)
        return False

    def tick(self, name: str, wanted: bool, timeout_s: float) -> None:
        """Read a check box, click it once if need be, and read it again."""
        is_ticked, label = self._read_box(name, timeout_s)
        if is_ticked == wanted:
            return
        self.press(self.aim(label, timeout_s))
        end = time.monotonic() + timeout_s
        while self._read_box(name, timeout_s)[0] != wanted:
            if time.monotonic() >= end:
                raise Trouble("dialog", f"the box {name} was clicked and did not change")
            time.sleep(LOOK_S)

    def _read_box(self, name: str, timeout_s: float) -> tuple[bool, str]:
        """Whether a box is ticked, and under which name it is to be seen now."""
        if self.buttons.controls([name]):
            return self._box_by_name(name, timeout_s), name
        end = time.monotonic() + timeout_s
        while True:
            view = self.view()
            sights = self._look(view, [name, f"{name}.on"])
            hits = [h for s in sights.values() for h in s.hits]
            if hits:
                best = max(hits, key=lambda h: h.score)
                state = ticked(
                    view.picture,
                    best,
                    self.buttons.template(name),
                    self.buttons.template(f"{name}.on"),
                )
                if state is not None and not any(len(s.hits) > 1 for s in sights.values()):
                    return state, best.name
            if time.monotonic() >= end:
                words = "; ".join(s.words() for s in sights.values())
                raise Trouble("unseen", f"the box {name} cannot be read: {words}")
            self._no_error(view)
            time.sleep(LOOK_S)

    def _box_by_name(self, name: str, timeout_s: float) -> bool:
        """What a check box says of itself."""
        self.wait_for(name, timeout_s)
        control, where = self.buttons.controls([name])[name], self.buttons.button(name).where
        assert self._controls is not None
        found = found_in(self.view(), control, where, self._controls)
        if len(found) == 1 and found[0].ticked is not None:
            return found[0].ticked
        raise Trouble("unseen", f"the {control.words()} does not say whether it is ticked")

    def type(self, text: str) -> None:
        """Type into the field that was clicked; what it held is replaced."""
        if self.permission.halted:
            raise NotClicked("it was stopped")
        self._hands.type(text)

    def key(self, name: str) -> None:
        """Press a key."""
        if self.permission.halted:
            raise NotClicked("it was stopped")
        self._hands.press(name)

    def close_error(self, timeout_s: float) -> None:
        """Close a modal error by its recorded button, and see that it is gone."""
        if "error_close" not in self.buttons:
            raise Trouble("error", "no `error_close` was recorded; close it by hand")
        self.click("error_close", timeout_s)
        self.wait_until_gone("error_close", timeout_s)

    def leave_dialogs(self, timeout_s: float, late_s: float = 0.0) -> bool:
        """Close what an export left open: with Escape, then with `export_cancel`; True if any was.

        A dialog that was asked for and has not come yet is waited for, for `late_s`; one that is just
        closing by itself does not count.
        """
        end, late = time.monotonic() + timeout_s, time.monotonic() + late_s
        left, tried = False, 0
        while True:
            dialogs = self.view().dialogs
            if not dialogs and (left or time.monotonic() >= late):
                return left
            time.sleep(CHANGE_S if dialogs and not left else LOOK_S)
            view = self.view()
            if not view.dialogs:
                continue
            if not left:
                left, end = True, time.monotonic() + timeout_s
            elif time.monotonic() >= end:
                title = view.dialogs[0].title
                raise Trouble("dialog", f"the window {title!r} is still open after {timeout_s:g} s")
            self._leave(view, tried)
            tried += 1

    def _leave(self, view: View, tried: int) -> None:
        # Escape first: a dialog in which `export_cancel` was not recorded may have a "Choose" like it.
        cancel = "export_cancel"
        recorded = tried % 2 == 1 and cancel in self.buttons
        if recorded and self._look(view, [cancel])[cancel].sure:
            self.click(cancel, LOOK_S)
        else:
            self.key("escape")

    def knows_dialog(self) -> bool:
        """Whether a dialog is open that shows something which was recorded in a dialog."""
        view = self.view()
        names = self.buttons.named("dialog")
        return bool(view.dialogs and names) and any(
            sight.hits for sight in self._look(view, names).values()
        )

    def confirm(self, names: tuple[str, ...], appears_s: float, timeout_s: float) -> bool:
        """Confirm what a click may have opened, with one of these buttons; False if nothing opens."""
        end = time.monotonic() + appears_s
        while not (view := self.view()).dialogs:
            if time.monotonic() >= end:
                return False
            time.sleep(LOOK_S)
        self._no_error(view)
        recorded = [name for name in names if name in self.buttons]
        end = time.monotonic() + timeout_s
        while True:
            sights = self._look(self.view(), recorded) if recorded else {}
            for name in recorded:
                if sights[name].sure:
                    self.click(name, timeout_s)
                    self.wait_until_gone(name, timeout_s)
                    return True
            if not recorded or time.monotonic() >= end:
                raise Trouble(
                    "dialog",
                    f"a window {view.dialogs[0].title!r} opened that shows no {' or '.join(names)}; "
                    f"record the button that confirms it as {names[0]}",
                )
            time.sleep(LOOK_S)


def _changed(before: View, now: View, hit: Hit) -> bool:
    x, y, width, height = hit.box
    rows, columns = slice(y, y + height), slice(x, x + width)
    return differs(before.picture[rows, columns], now.picture[rows, columns])


__all__ = ["Aim", "Hangs", "NoScreen", "NotClicked", "Program", "Seen", "Trouble"]
