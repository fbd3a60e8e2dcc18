"""Eyes and hands: a picture of the screen, the mouse, the keyboard.

pyautogui is loaded here and nowhere else: it needs a screen as soon as it is imported. Putting the
mouse into a corner of the screen by hand stops everything (its fail-safe).
"""

import logging
import os
import sys
import time
from typing import Any

from ...system.extras import not_installed
from .match import Picture
from .quiet import have_cookies, quiet_libraries
from .windows import NoScreen

PAUSE_S = 0.05
LOG = logging.getLogger("labrun")


class NotClicked(Exception):
    """The mouse button was certainly not pressed; the text says why."""


class Hangs(NotClicked):
    """The program did not respond when it was to be clicked; it may do so again."""


class Hands:
    """The mouse and keyboard of one screen; raises NoScreen if there is none."""

    def __init__(self) -> None:
        self._gui = _pyautogui()

    def picture(self) -> Picture:
        """The whole screen; raises NoScreen if it is locked or gone."""
        import numpy as np
        from PIL import ImageGrab

        try:
            image = ImageGrab.grab(xdisplay=os.environ.get("DISPLAY") or None)
        except (OSError, RuntimeError) as fault:
            raise NoScreen(
                f"the screen cannot be captured: {fault}; it may be locked, or its session ended"
            ) from fault
        return np.asarray(image.convert("RGB"))

    def picture_scale(self, picture: Picture) -> float:
        """Pixels of a picture for one step of the mouse: 2 on screens that count points."""
        return picture.shape[1] / self._gui.size()[0]

    def where(self) -> tuple[int, int]:
        """Where the mouse is."""
        x, y = self._gui.position()
        return int(x), int(y)

    def move(self, x: int, y: int) -> None:
        """Move the mouse there; raises NotClicked if it does not stay."""
        self._safely(lambda: self._gui.moveTo(x, y))
        time.sleep(PAUSE_S)
        self._check_place(x, y)

    def press_mouse(self, x: int, y: int) -> None:
        """Click where the mouse was sent: once, never again by itself, and only if it is still there."""
        self._safely(self._check_corner)
        self._check_place(x, y)
        self._gui.mouseDown(_pause=False)
        time.sleep(PAUSE_S)
        self._gui.mouseUp(_pause=False)

    def type(self, text: str) -> None:
        """Replace a field's content with this text.

        Select-all is not Ctrl+A everywhere (in Tk and Emacs-like fields that goes to the start), and
        Shift+Home selects nothing on Windows while NumLock is on; one of the two empties any field.
        """
        for selected in (("end",), ("shift", "home")), (("ctrl", "a"),):
            for keys in selected:
                self._safely(lambda k=keys: self._gui.hotkey(*k))
            self._safely(lambda: self._gui.press("backspace"))
        self._safely(lambda: self._gui.write(text, interval=0.01))

    def press(self, key: str) -> None:
        """Press one key, by pyautogui's name for it."""
        self._safely(lambda: self._gui.press(key))

    def _check_place(self, x: int, y: int) -> None:
        here = self.where()
        if max(abs(here[0] - x), abs(here[1] - y)) > 1:
            raise NotClicked(
                f"the mouse was sent to {x},{y} but is at {here[0]},{here[1]}: someone else is moving it"
            )

    def _check_corner(self) -> None:
        self._gui.failSafeCheck()

    def _safely(self, act: Any) -> None:
        try:
            act()
        except self._gui.FailSafeException:
            raise NotClicked(
                "the mouse is in a corner of the screen, which stops the driver; move it away to continue"
            ) from None


def _pyautogui() -> Any:
    if sys.platform.startswith("linux"):
        have_cookies()
    # mouseinfo, a toy of pyautogui's, ends the whole process where tkinter is missing.
    sys.modules.setdefault("mouseinfo", None)  # type: ignore[arg-type]
    try:
        with quiet_libraries():
            import pyautogui
    except ImportError as fault:
        raise NoScreen(
            f"mouse and keyboard cannot be used: {not_installed(fault, 'gui') or fault}"
        ) from fault
    except Exception as fault:  # Xlib and KeyError where there is no display, at import
        LOG.info("pyautogui cannot be used", exc_info=True)
        raise NoScreen(
            f"there is no screen to work on ({_said(fault)}); start the device server on the "
            f"analyser's own desktop"
        ) from fault
    _close_leftovers()
    pyautogui.FAILSAFE = True
    pyautogui.PAUSE = PAUSE_S
    return pyautogui


def _said(fault: Exception) -> str:
    if isinstance(fault, KeyError) and fault.args == ("DISPLAY",):
        return "DISPLAY is not set"
    return f"{type(fault).__name__}: {fault}"


def _close_leftovers() -> None:
    """On import pyscreeze looks for a program called scrot, and leaves its pipes open."""
    asked = getattr(sys.modules.get("pyscreeze"), "whichProc", None)
    for pipe in (getattr(asked, "stdout", None), getattr(asked, "stderr", None)):
        if pipe is not None:
            pipe.close()
