"""Parts of a dialog are found in the dialog, and other words of the program are not taken for them."""

from dataclasses import replace

import numpy as np
import pytest

from labrun.drivers.window_program.buttons import read_buttons
from labrun.drivers.window_program.looking import look_in
from labrun.drivers.window_program.match import Hit, Sighting
from labrun.drivers.window_program.program import Program
from labrun.drivers.window_program.recording import looked
from labrun.drivers.window_program.view import View
from labrun.drivers.window_program.windows import Window

PARTS = ("folder", "separate_spectrum", "new_folder", "export_finish", "export_cancel")


def program(gui, look: str = "grey") -> Program:
    return Program(read_buttons(gui.recorded(look)), "Profile Builder")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("look", "scale"),
    [
        ("dark", 1.3),
        pytest.param("grey", 0.7, marks=pytest.mark.soak),
        pytest.param("paper", 1.9, marks=pytest.mark.soak),
    ],
)
def test_all_parts_of_an_open_dialog_are_found(gui, look, scale):
    analyser = gui.start(look=look, scale=scale)
    analyser.order("open ask_all")
    eyes = program(gui, look)
    view, places = eyes.view(), analyser.places()
    sights = looked(eyes.buttons, view)
    eyes.close()
    found = {name: sights[name].sure for name in PARTS}

    assert None not in found.values(), [s.words() for s in sights.values()]
    for name, (x, y, w, h) in ((name, places[name]) for name in PARTS):
        across, down = found[name].centre
        assert abs(across + view.corner[0] - x - w / 2) < w / 4, name
        assert abs(down + view.corner[1] - y - h / 2) < h / 4, name


@pytest.mark.slow
@pytest.mark.parametrize(
    "scale",
    [0.75, pytest.param(1.0, marks=pytest.mark.soak), pytest.param(1.7, marks=pytest.mark.soak)],
)
def test_words_of_the_main_window_are_no_labels_of_a_dialog(gui, scale):
    gui.start(look="dark", scale=scale)  # its "Ready" is like "Folder:" to 0.75
    eyes = program(gui, "dark")
    sights = looked(eyes.buttons, eyes.view())
    eyes.close()

    assert [s.words() for name, s in sights.items() if name in PARTS and s.hits] == []


def test_what_stood_there_before_the_click_is_no_part_of_a_dialog_drawn_into_the_window(gui):
    eyes = program(gui)
    eyes.close()
    draw = np.random.default_rng(1)
    picture = draw.integers(0, 255, (200, 300, 3), np.uint8)
    main = Window(1, "Profile Builder", (0, 0, 300, 200), False)
    before = View(picture, (0, 0), 1.0, main, (), "")
    opened = picture.copy()
    opened[100:140, 100:200] = 200
    stood, new = (
        Hit("folder", 0.9, 1.0, box, 1.0, 0.0) for box in ((10, 10, 60, 20), (110, 105, 60, 20))
    )
    eyes._before = before
    now = replace(before, picture=opened)

    assert eyes._not_from_before("folder", Sighting("folder", (stood, new)), now).sure == new
    assert (
        eyes._not_from_before("folder", Sighting("folder", (stood,)), now)
        .words()
        .endswith("what stood there before")
    )
    assert eyes._not_from_before("measure", Sighting("measure", (stood,)), now).sure == stood


def test_nothing_is_asked_for_and_nothing_found(gui):
    eyes = program(gui)
    eyes.close()
    blank = View(np.zeros((50, 50, 3), np.uint8), (0, 0), 1.0, None, (), "")

    assert look_in(blank, eyes.buttons, [], 1.0) == {}


def test_a_sign_without_its_close_button_is_no_error(gui):
    gui.start().order("error Interlock open")
    eyes = program(gui)
    names = eyes.buttons.named("error")
    view = eyes.view()
    signs = look_in(view, eyes.buttons, names, eyes.scale)
    eyes.close()
    alone = {
        **signs,
        "error_close": Sighting("error_close"),
    }  # a peak is shaped like a warning sign

    assert eyes._error(signs, view) == "error"
    assert eyes._error(alone, view) is None
    only = {"error": signs["error"]}  # where no close button was recorded
    assert eyes._error(only, view) == "error"
    assert eyes._error(only, replace(view, dialogs=())) is None  # a word in the status bar
