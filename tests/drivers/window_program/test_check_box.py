"""A check box is read right also where it is not just where it was recorded, and not guessed at."""

import cv2
import numpy as np
import pytest

from labrun.drivers.window_program.check_box import ticked
from labrun.drivers.window_program.match import Hit, Template


def box(
    tick: bool, scale: float = 1.0, off: tuple[int, int] = (0, 0), thick: int = 2
) -> np.ndarray:
    """A square with words beside it, drawn at a size, the square `off` from its place."""
    picture = np.full((round(26 * scale), round(150 * scale), 3), 235, np.uint8)
    x, y, side = round(6 * scale) + off[0], round(5 * scale) + off[1], round(16 * scale)
    cv2.rectangle(picture, (x, y), (x + side, y + side), (30, 30, 30), 1)
    if tick:
        corners = [(0.2, 0.55), (0.45, 0.85), (0.85, 0.2)]
        line = np.array([[x + a * side, y + b * side] for a, b in corners], np.int32)
        cv2.polylines(
            picture, [line], False, (30, 30, 30), max(1, round(thick * scale)), cv2.LINE_AA
        )
    at = round(30 * scale), round(18 * scale)
    cv2.putText(
        picture, "Separate", at, cv2.FONT_HERSHEY_SIMPLEX, 0.5 * scale, (30,) * 3, 1, cv2.LINE_AA
    )
    return picture


OFF, ON = Template("box", box(False)), Template("box.on", box(True))


def read(picture: np.ndarray) -> bool | None:
    whole = (0, 0, picture.shape[1], picture.shape[0])
    return ticked(picture, Hit("box", 0.9, 1.0, whole, 1.0, 0.0), OFF, ON)


@pytest.mark.parametrize("tick", [True, False])
@pytest.mark.parametrize("scale", [0.7, 1.0, 1.6, 2.0])
@pytest.mark.parametrize("off", [(0, 0), (3, -2), (-3, 2)])
def test_a_box_is_read_at_any_size_and_a_little_off_its_place(tick, scale, off):
    assert read(box(tick, scale, off)) is tick


@pytest.mark.parametrize("thick", [1.5, 3])
def test_a_tick_may_be_thicker_or_thinner(thick):
    assert read(box(True, 2.0, thick=thick)) is True


def test_a_box_that_is_half_filled_is_not_guessed_at():
    half = (box(True).astype(int) + box(False)) // 2

    assert read(half.astype(np.uint8)) is None


def test_two_recordings_that_do_not_differ_tell_nothing():
    whole = Hit("box", 0.9, 1.0, (0, 0, 150, 26), 1.0, 0.0)

    assert ticked(box(True), whole, OFF, OFF) is None
