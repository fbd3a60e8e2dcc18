"""The windows on the screen: where the analyser's is, what covers it, and whether it responds.

X11 through Xlib (which comes with pyautogui), Windows through user32. A program that hangs queues
its clicks, so it is checked for a sign of life before any click is made.
"""

from dataclasses import dataclass
from typing import Protocol

from .match import Box


@dataclass(frozen=True, slots=True)
class Window:
    """A visible top-level window; `owned` if it belongs to another one, as dialogs do.

    `popup`: a menu or a list that has dropped down; `program` tells whose it is, where that is known.
    """

    id: int
    title: str
    box: Box
    owned: bool
    popup: bool = False
    program: int = 0

    def is_over(self, main: "Window") -> bool:
        """Whether it is a dialog, or a menu or list of the program whose main window is given."""
        return self.owned or (self.popup and self.program == main.program)


class Windows(Protocol):
    """What a desktop provides."""

    def listed(self) -> list[Window]:
        """All visible windows, the topmost first."""
        ...

    def alive(self, window: Window, timeout_s: float) -> bool | None:
        """Whether its program responds; None if that cannot be checked."""
        ...

    def at(self, x: int, y: int) -> int | None:
        """The id of the top-level window that a click there would reach."""
        ...

    def close(self) -> None:
        """Release the desktop."""
        ...


class NoScreen(OSError):
    """There is no screen to look at; the text says why."""
