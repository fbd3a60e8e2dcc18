"""What somebody pressed and typed becomes hits in the program, each cut out so that it is found again."""

import cv2
import numpy as np
import pytest

from labrun.drivers.window_program.deeds import NotCut, cut_out, hits
from labrun.drivers.window_program.watching import Key, Look, Press
from labrun.drivers.window_program.windows import Window, called

MAIN = Window(1, "Acme 2.0", (0, 0, 400, 300), owned=False, program=7)
MENU = Window(2, "", (250, 150, 100, 80), owned=False, popup=True, program=7)
OTHER = Window(3, "Terminal", (500, 0, 200, 300), owned=False, program=8)


def look(chosen="", typed="", windows=(OTHER, MAIN)):
    """Two buttons, a field with its label, and a list that shows what was chosen."""
    screen = np.full((300, 700, 3), 225, np.uint8)

    def box(x, y, w, h, words, fill=(240, 240, 240)):
        cv2.rectangle(screen, (x, y), (x + w, y + h), fill, -1)
        cv2.rectangle(screen, (x, y), (x + w, y + h), (90, 90, 90), 1)
        write(x + 8, y + h - 8, words)

    def write(x, y, words):
        cv2.putText(
            screen, words, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (20, 20, 20), 1, cv2.LINE_AA
        )

    box(20, 20, 90, 30, "Start", (200, 215, 235))
    box(130, 20, 90, 30, "Save", (200, 215, 235))
    write(20, 118, "Sample:")
    box(90, 100, 180, 26, typed, (255, 255, 255))
    box(20, 200, 200, 30, chosen, (255, 255, 255))
    cv2.fillPoly(screen, [np.array([[196, 210], [212, 210], [204, 222]])], (20, 20, 20))
    return Look(0.0, (0, 0), screen, 1.0, windows)


def test_presses_and_keys_of_the_program_alone_are_taken():
    deeds = [
        Key(text="y"), Press(60, 35, look()), Press(600, 100, look()), Key(text="z"),
        Press(180, 112, look()), Key(text="a", with_others=True), *map(Key, "K18"), Key(name="backspace"),
        Key(text="7"), Key(name="enter"), Key(text="s", with_others=True),
        Press(300, 180, look(windows=(MENU, OTHER, MAIN))),
    ]  # fmt: skip
    found, left = hits(deeds, "Acme")

    assert [(h.where, h.typed, h.keys) for h in found] == [
        ("main", None, []), ("main", "K17", ["enter"]), ("dialog", None, []),
    ]  # fmt: skip
    assert found[2].bounds == (250, 150, 100, 80)
    assert left == ["a key with ctrl or alt (s); work it with the mouse"]


def test_a_button_is_cut_at_its_border_a_field_by_its_label_and_a_list_where_it_does_not_change():
    (button, field, chooser), _ = hits(
        [
            Press(60, 35, look()),
            Press(180, 112, look()),
            Key(text="K"),
            Press(204, 215, look()),
        ],
        "Acme",
    )
    later = look("Exactly this one", "K17")
    box, at = cut_out(button, later)
    label, beside = cut_out(field, later)
    part, _ = cut_out(chooser, later)

    assert abs(box[0] - 20) < 5 and abs(box[2] - 90) < 8 and abs(at[0]) < 8
    assert label[0] + label[2] < 90 and label[0] + label[2] / 2 + beside[0] == pytest.approx(
        180, abs=1
    )
    assert part[0] > 80 and part[0] <= 204 < part[0] + part[2]


@pytest.mark.parametrize(
    ("area", "program", "meant"),
    [((200, 150), 7, [1]), ((399, 300), 7, [4, 1]), ((200, 150), 8, [4, 1])],
)
def test_a_small_window_of_the_same_program_and_title_is_beside_the_meant_one(area, program, meant):
    log = Window(4, "Acme 2.0", (450, 0, *area), owned=False, program=program)

    assert [window.id for window in called("Acme", (log, OTHER, MENU, MAIN))] == meant


def test_what_stands_twice_or_is_blank_is_refused():
    blank = np.full((300, 700, 3), 225, np.uint8)
    (nothing,), _ = hits([Press(300, 260, Look(0.0, (0, 0), blank, 1.0, (MAIN,)))], "Acme")

    with pytest.raises(
        NotCut, match="pressed at 300,260 cannot be told apart: it is a single colour"
    ):
        cut_out(nothing)
