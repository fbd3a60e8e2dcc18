"""One look at the screen: the analyser's window, the dialogs over it, and their picture."""

from dataclasses import dataclass

from .match import Box, Picture, overlap
from .windows import Window, Windows, called

FULL_SCREEN = 0.95
FLAT = 2.0
"""Counts: a picture that varies less is a blank screen."""


class Trouble(Exception):
    """The program is not in the required state; `state` names it, the text explains it."""

    def __init__(self, state: str, words: str) -> None:
        super().__init__(words)
        self.state = state


@dataclass(frozen=True, slots=True)
class View:
    """The program's part of the screen; `corner` is its place there, `ratio` pixels a mouse step."""

    picture: Picture
    corner: tuple[int, int]
    ratio: float
    main: Window | None
    dialogs: tuple[Window, ...]
    cover: str

    def dialog_box(self) -> Box:
        """The part of the picture that the open dialogs fill; all of it where none is open."""
        height, width = self.picture.shape[:2]
        if not self.dialogs:
            return 0, 0, width, height
        x, y, w, h = (round(n * self.ratio) for n in _around([d.box for d in self.dialogs]))
        left, top = max(0, x - self.corner[0]), max(0, y - self.corner[1])
        return left, top, min(w, width - left), min(h, height - top)

    def on_screen(self, x: float, y: float) -> tuple[int, int]:
        """A place of the picture as the mouse counts."""
        return round((x + self.corner[0]) / self.ratio), round((y + self.corner[1]) / self.ratio)


def view_of(title: str, windows: Windows, screen: Picture, ratio: float) -> View:
    """The part of the screen that shows the program; raises Trouble if it cannot be identified."""
    if not title:
        _not_blank(screen)
        return View(screen, (0, 0), ratio, None, (), "")
    listed = windows.listed()
    mains = called(title, listed)
    if not mains:
        titles = ", ".join(repr(w.title) for w in listed if w.title)[:200] or "none with a title"
        raise Trouble(
            "away", f"no window on the screen is called {title!r}; the titles are {titles}. Start the "
            f"analyser's program, or bring it back if it is minimised",
        )  # fmt: skip
    if len(mains) > 1:
        places = " and ".join(f"{w.title!r} at {w.box[0]},{w.box[1]}" for w in mains)
        raise Trouble(
            "twice", f"{len(mains)} windows are called {title!r}: {places}; close all but one, or give "
            f"a longer `title`",
        )  # fmt: skip
    _not_blank(screen)
    main = mains[0]
    above = listed[: listed.index(main)]
    area = screen.shape[0] * screen.shape[1] / ratio**2
    dialogs = tuple(w for w in above if _is_over(w, main, area) and overlap(w.box, main.box) > 0)
    box = _clipped(_around([main.box, *(d.box for d in dialogs)]), screen, ratio)
    x, y, width, height = box
    if width < 20 or height < 20:
        raise Trouble("away", f"the window {main.title!r} is outside the screen; bring it back")
    picture = screen[y : y + height, x : x + width]
    return View(picture, (x, y), ratio, main, dialogs, _cover(above, main, area))


def _is_over(window: Window, main: Window, area: float) -> bool:
    """Whether it is the program's own; a locked screen is drawn like a menu, but everywhere."""
    everywhere = window.popup and window.box[2] * window.box[3] >= FULL_SCREEN * area
    return window.is_over(main) and not everywhere


def _not_blank(screen: Picture) -> None:
    if float(screen[::7, ::7].std()) < FLAT:
        raise Trouble("blank", "the screen is a single colour: it is blank, asleep or locked")


def _cover(above: list[Window], main: Window, area: float) -> str:
    """A description of what may hide the program: a locked screen, or another program's window."""
    for window in above:
        if _is_over(window, main, area) or overlap(window.box, main.box) <= 0:
            continue
        if window.box[2] * window.box[3] >= FULL_SCREEN * area:
            return f"{window.title or 'a window'!r} covers the whole screen: is it locked?"
        return f"the window {window.title!r} covers it"
    return ""


def _around(boxes: list[Box]) -> Box:
    left, top = min(b[0] for b in boxes), min(b[1] for b in boxes)
    right, bottom = max(b[0] + b[2] for b in boxes), max(b[1] + b[3] for b in boxes)
    return left, top, right - left, bottom - top


def _clipped(box: Box, screen: Picture, ratio: float) -> Box:
    left, top = max(0, round(box[0] * ratio)), max(0, round(box[1] * ratio))
    right = min(screen.shape[1], round((box[0] + box[2]) * ratio))
    bottom = min(screen.shape[0], round((box[1] + box[3]) * ratio))
    return left, top, right - left, bottom - top
