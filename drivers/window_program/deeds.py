"""From what somebody did to steps: which presses are of the program, what each hit, what was typed.

A button is cut out along its border, or wider until it is found only once; a field that was typed into
changes, so what stands beside it is taken, and the way from there to where it was clicked.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...system.start import later
from .buttons import Where
from .match import Box, Picture, Template, look_for, overlap, unfit
from .watching import Deed, Key, Look, Press
from .windows import called

with later("cv2"):
    import cv2

LEAST, MOST = (14, 10), (420, 120)
"""Width and height of what is taken for a button, in pixels."""
BUTTON = ((40, 240), (20, 60))
"""Widths and heights of usual buttons; a word of one is smaller, a bar of them wider."""
ROUND = ((60, 24), (100, 32), (160, 44), (240, 70))
"""What is cut out round a press that no border surrounds."""
LINES = ((60, 16), (110, 18))
"""The same in a menu or a list, whose other lines may be drawn otherwise the next time."""
BESIDE_PX, GAP_PX = 260, 28
"""How far beside a field its label may be, and how wide a space in it."""
ERASES = ("backspace", "delete", "home", "end")


class NotCut(Exception):
    """A press whose surroundings are not distinctive; the text says why."""


@dataclass(slots=True)
class Hit:
    """A press in the program: what was cut out, where, and in which kind of window."""

    press: Press
    where: Where
    bounds: Box
    popup: bool = False
    typed: str | None = None
    keys: list[str] = field(default_factory=list)


def hits(deeds: Sequence[Deed], title: str) -> tuple[list[Hit], list[str]]:
    """The presses in the program with what was typed after each, and what cannot be repeated.

    Keys before the first press, and after a press elsewhere, are not the program's.
    """
    found: list[Hit] = []
    left: list[str] = []
    inside = False
    for deed in deeds:
        if isinstance(deed, Press):
            hit = _hit(deed, title)
            inside = hit is not None
            if hit is not None:
                found.append(hit)
        elif inside and not _note(found[-1], deed):
            left.append(
                f"a key with ctrl or alt ({deed.text or deed.name}); work it with the mouse"
            )
    return found, left


def _hit(press: Press, title: str) -> Hit | None:
    look = press.before
    window = look.window_at(press.x, press.y)
    main = next(iter(called(title, look.windows)), None)
    if window is None or main is None or not (window.id == main.id or window.is_over(main)):
        return None
    x, y, width, height = (round(n * look.ratio) for n in window.box)
    rows, columns = look.picture.shape[:2]
    left, top = max(0, x), max(0, y)
    bounds = left, top, min(x + width, columns) - left, min(y + height, rows) - top
    return Hit(press, "main" if window.id == main.id else "dialog", bounds, window.popup)


def _note(hit: Hit, key: Key) -> bool:
    """Add a key to what was done after a press; False for one that no step can press."""
    if key.name == "backspace" and hit.typed and not key.with_others:
        hit.typed = hit.typed[:-1]
    elif (key.with_others and key.text == "a") or (key.name in ERASES and not hit.keys):
        pass  # a step that types replaces what a field holds
    elif key.with_others:
        return False
    elif key.text:
        hit.typed = (hit.typed or "") + key.text
    else:
        hit.keys.append(key.name)
    return True


def cut_out(hit: Hit, later: Look | None = None) -> tuple[Box, tuple[int, int]]:
    """The box in the picture to record, and where to click from its middle; raises NotCut.

    Of the main window something is preferred that is still found in a `later` look: what a list shows
    changes with what was chosen in it.
    """
    look = hit.press.before
    x, y = round(hit.press.x * look.ratio), round(hit.press.y * look.ratio)
    frames = list(_frames(look.picture, hit.bounds, x, y))
    if hit.typed is None:
        boxes = [*frames, *_round(hit.bounds, x, y, ROUND)]
        if hit.popup:
            boxes = [*_round(hit.bounds, x, y, LINES), *boxes]
    else:
        boxes = [box for frame in frames for box in _beside(look.picture, hit.bounds, frame)]
    why, usable = "nothing distinctive is near it", None
    stays = later is not None and hit.where == "main" and later.window_at(hit.press.x, hit.press.y)
    for box in boxes:
        wrong = _wrong(look.picture, look.picture, hit.bounds, box)
        if wrong is not None:
            why = wrong
            continue
        usable = usable or box
        if (
            later is None
            or not stays
            or _wrong(look.picture, later.picture, hit.bounds, box) is None
        ):
            usable = box
            break
    if usable is None:
        raise NotCut(f"what was pressed at {hit.press.x},{hit.press.y} cannot be told apart: {why}")
    return usable, (round(x - usable[0] - usable[2] / 2), round(y - usable[1] - usable[3] / 2))


def _wrong(picture: Picture, shown: Picture, bounds: Box, box: Box) -> str | None:
    """Why a box of a picture would not be found in what is shown of its window; None if it would."""
    x, y, w, h = box
    part = picture[y : y + h, x : x + w]
    if (why := unfit(part)) is not None:
        return why
    left, top, width, height = bounds
    window = shown[top : top + height, left : left + width]
    sight = look_for(window, [Template("it", part)], 1.0)["it"]
    if sight.sure is None or overlap(sight.sure.box, (x - left, y - top, w, h)) < 0.5:
        return sight.words()
    return None


def _frames(picture: Picture, bounds: Box, x: int, y: int) -> Iterator[Box]:
    """Boxes that lines enclose round a place: of usual buttons first, then the smallest."""
    left, top, width, height = bounds
    window = picture[top : top + height, left : left + width]
    edges = cv2.Canny(cv2.cvtColor(window, cv2.COLOR_RGB2GRAY), 20, 60)
    closed = cv2.dilate(edges, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(closed, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    found = {tuple(int(n) for n in cv2.boundingRect(contour)) for contour in contours}
    usual = lambda w, h: all(a <= n <= b for n, (a, b) in zip((w, h), BUTTON, strict=True))  # noqa: E731
    for bx, by, w, h in sorted(found, key=lambda box: (not usual(*box[2:]), box[2] * box[3])):
        fits = LEAST[0] <= w <= MOST[0] and LEAST[1] <= h <= MOST[1]
        if fits and bx <= x - left < bx + w and by <= y - top < by + h:
            yield left + bx, top + by, w, h


def _round(bounds: Box, x: int, y: int, sizes: Sequence[tuple[int, int]]) -> Iterator[Box]:
    """Boxes of a fixed size round a place, kept inside the window."""
    left, top, width, height = bounds
    for w, h in sizes:
        w, h = min(w, width), min(h, height)
        yield (
            min(max(left, x - w // 2), left + width - w),
            min(max(top, y - h // 2), top + height - h),
            w, h,
        )  # fmt: skip


def _beside(picture: Picture, bounds: Box, frame: Box) -> Iterator[Box]:
    """What stands beside a field that does not change with it: on its left, or above it."""
    left, top, width, _ = bounds
    x, y, w, h = frame
    if (
        label := _ink(picture, max(left, x - BESIDE_PX), y, x - 2, y + h, nearest="right")
    ) is not None:
        yield label
    above = _ink(picture, x, max(top, y - h - 4), min(x + w, left + width), y - 2, nearest="left")
    if above is not None:
        yield above


def _ink(
    picture: Picture, left: int, top: int, right: int, bottom: int, *, nearest: str
) -> Box | None:
    """The words at one end of a strip, with a little round them."""
    if right - left < LEAST[0] or bottom - top < LEAST[1]:
        return None
    strip = cv2.cvtColor(picture[top:bottom, left:right], cv2.COLOR_RGB2GRAY)
    columns = np.flatnonzero(cv2.Canny(strip, 60, 150).any(axis=0))
    if not len(columns):
        return None
    words: Any = np.split(columns, np.flatnonzero(np.diff(columns) > GAP_PX) + 1)
    word = words[-1] if nearest == "right" else words[0]
    start, stop = max(left, left + int(word[0]) - 4), min(right, left + int(word[-1]) + 5)
    return start, top, stop - start, bottom - top
