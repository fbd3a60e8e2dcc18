"""The windows on the screen: where the analyser's is, what lies over it, and whether it answers.

X11 by Xlib (which pyautogui brings along), Windows by user32. A program that hangs keeps its
clicks for later, so it is asked for a sign of life before any click is made.
"""

import sys
from dataclasses import dataclass
from typing import Protocol

from .match import Box


@dataclass(frozen=True, slots=True)
class Window:
    """A visible top-level window; `owned` where it belongs to another one, as dialogs do."""

    id: int
    title: str
    box: Box
    owned: bool


class Windows(Protocol):
    """What is asked of a desktop."""

    def listed(self) -> list[Window]:
        """All visible windows, the topmost first."""
        ...

    def alive(self, window: Window, timeout_s: float) -> bool | None:
        """Whether its program answers; None where it cannot be asked."""
        ...

    def at(self, x: int, y: int) -> int | None:
        """The id of the top-level window that a click there would reach."""
        ...

    def close(self) -> None:
        """Let go of the desktop."""
        ...


class NoScreen(OSError):
    """There is no screen to look at; the sentence says why."""


def open_windows() -> Windows:
    """The desktop of this machine; raises NoScreen."""
    if sys.platform == "win32":
        from .windows_user32 import User32Windows

        return User32Windows()
    from .windows_x11 import X11Windows

    return X11Windows()
