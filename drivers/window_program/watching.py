"""Watch somebody work a program: every press of the mouse, what is typed, and how it looked before.

Pictures are taken all the time, so that a button is seen as it was before the mouse came near it.
"""

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Protocol

from .hands import Hands
from .match import Picture
from .windows import NoScreen, Window, Windows

LOOK_S = 0.15
KEPT = 8
AWAY_PX = 60
"""A button under the mouse may be drawn otherwise."""
DRAWN_S = 0.3
"""How long after a press a picture may still be the old one."""


@dataclass(frozen=True, slots=True)
class Look:
    """The screen at a moment: its windows, topmost first, and where the mouse was."""

    at: float
    mouse: tuple[int, int]
    picture: Picture
    ratio: float
    windows: tuple[Window, ...]

    def window_at(self, x: int, y: int) -> Window | None:
        """The topmost window there."""
        return next((w for w in self.windows if _inside(w, x, y)), None)


@dataclass(frozen=True, slots=True)
class Press:
    """The left mouse button, and the screen before it."""

    x: int
    y: int
    before: Look


@dataclass(frozen=True, slots=True)
class Key:
    """A key: the text that it types, or the name of another key; `with_others`: ctrl, alt, ..."""

    text: str = ""
    name: str = ""
    with_others: bool = False


Deed = Press | Key


class Input(Protocol):
    """What a desktop tells of mouse and keyboard, whoever they belong to."""

    def listen(self, take: "Taker") -> None:
        """Call it for each press and key, in a thread of its own, until `close`."""
        ...

    def close(self) -> None: ...


class Taker(Protocol):
    def pressed(self, x: int, y: int) -> None: ...

    def typed(self, key: Key) -> None: ...


class Watch:
    """From `with Watch(...):` on, `deeds` grows."""

    def __init__(self, windows: Windows, heard: Input) -> None:
        self.deeds: list[Deed] = []
        self._hands, self._windows, self._input = Hands(), windows, heard
        self._looks: deque[Look] = deque(maxlen=KEPT)
        self._over = threading.Event()
        self._lock = threading.Lock()
        self._last_press = 0.0
        self._eyes = threading.Thread(target=self._look_on, daemon=True)

    def __enter__(self) -> "Watch":
        self._looks.append(self._taken())
        self._eyes.start()
        self._input.listen(self)
        return self

    def __exit__(self, *_: object) -> None:
        self._input.close()
        self._over.set()
        self._eyes.join(5)
        self._windows.close()

    def last(self) -> Look:
        """The newest look."""
        return self._looks[-1]

    def pressed(self, x: int, y: int) -> None:
        now, looks = time.monotonic(), list(self._looks)
        with self._lock:
            windows = tuple(self._windows.listed())
        there = {window.id for window in windows}
        hit = next((w.id for w in windows if _inside(w, x, y)), None)
        fresh = [
            one
            for one in looks
            if one.at > self._last_press + DRAWN_S
            and (below := one.window_at(x, y)) is not None
            and (below.id == hit or below.id not in there)  # or this press has closed it
        ] or [self._taken()]
        away = [one for one in fresh if max(abs(one.mouse[0] - x), abs(one.mouse[1] - y)) > AWAY_PX]
        self.deeds.append(Press(x, y, (away or fresh)[-1]))
        self._last_press = now

    def typed(self, key: Key) -> None:
        self.deeds.append(key)

    def _look_on(self) -> None:
        while not self._over.wait(LOOK_S):
            try:
                self._looks.append(self._taken())
            except NoScreen:
                continue

    def _taken(self) -> Look:
        with self._lock:
            at, mouse = time.monotonic(), self._hands.where()
            windows = tuple(self._windows.listed())
            picture = self._hands.picture()
            return Look(at, mouse, picture, self._hands.picture_scale(picture), windows)


def _inside(window: Window, x: int, y: int) -> bool:
    left, top, width, height = window.box
    return left <= x < left + width and top <= y < top + height
