"""The windows on the screen: where the analyser's is, what covers it, and whether it responds.

X11 through Xlib (which comes with pyautogui), Windows through user32. A program that hangs queues
its clicks, so it is checked for a sign of life before any click is made.
"""

from dataclasses import dataclass
from typing import Protocol

from .match import Box


@dataclass(frozen=True, slots=True)
class Window:
    """A visible top-level window; `owned` if it belongs to another one, as dialogs do."""

    id: int
    title: str
    box: Box
    owned: bool


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
