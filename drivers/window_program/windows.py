"""The windows on the screen: where the analyser's is, what covers it, and whether it responds.

X11 through Xlib (which comes with pyautogui), Windows through user32. A program that hangs queues
its clicks, so it is checked for a sign of life before any click is made.
"""

from collections.abc import Sequence
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


def called(title: str, listed: Sequence[Window]) -> list[Window]:
    """The main windows that `title` may mean: one, unless a person has to choose.

    Of several of one program it is the largest, if that has twice the area of each other one: a log of
    the same name, say.
    """
    mains = [w for w in listed if title in w.title and not w.owned and not w.popup]
    if len({w.program for w in mains}) == 1 and mains[0].program:
        area = {w.id: w.box[2] * w.box[3] for w in mains}
        largest = max(mains, key=lambda w: area[w.id])
        if all(area[largest.id] >= 2 * area[w.id] for w in mains if w != largest):
            return [largest]
    return mains


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
