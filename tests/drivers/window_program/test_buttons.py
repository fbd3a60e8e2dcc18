"""A folder of buttons that cannot be used is told by file and reason; the steps of an export."""

import numpy as np
import pytest
from PIL import Image

from labrun.drivers.driver import Place
from labrun.drivers.find import DriverFault
from labrun.drivers.sciaps_gui.driver import SciapsGui
from labrun.drivers.window_program.buttons import ButtonsFault, read_buttons

GOOD = """labrun_buttons: 1
title: Analyser
buttons:
  measure: {file: a.png}
  export: {file: b.png, at: [0, 4]}
"""


def picture(path, size=(30, 90)):
    drawn = np.random.default_rng(1).integers(0, 255, (*size, 3), np.uint8)
    Image.fromarray(drawn).save(path)


def folder(tmp_path, text):
    (tmp_path / "buttons.yaml").write_text(text)
    for name in ("a.png", "b.png", "c.png"):
        picture(tmp_path / name)
    picture(tmp_path / "tiny.png", (6, 20))
    return tmp_path


def test_the_papers_steps_leave_out_what_was_not_recorded(tmp_path):
    assert read_buttons(folder(tmp_path, GOOD)).steps() == [
        ("click", "export"), ("type", "{folder}"), ("press", "enter"),
    ]  # fmt: skip


def test_steps_of_ones_own(tmp_path):
    text = (
        GOOD + "export:\n  - {click: export}\n  - {type: '{folder}/{name}'}\n  - {press: enter}\n"
    )

    assert read_buttons(folder(tmp_path, text)).steps()[1] == ("type", "{folder}/{name}")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "labrun_buttons: 2\nbuttons: {measure: {file: a.png}}\n",
            "labrun_buttons: Input should be 1",
        ),
        ("labrun_buttons: 1\nbuttons: {measure: {file: a.png}}\n", "has no export; record it with"),
        (GOOD.replace("b.png", "d.png"), "the picture of export, .*d.png, cannot be read"),
        (GOOD.replace("b.png", "buttons.yaml"), "buttons.yaml, cannot be read"),
        (GOOD.replace("b.png", "tiny.png"), "20 x 6 pixels are too few"),
        (GOOD.replace("at: [0, 4]", "at: here"), "buttons.export.at"),
        (GOOD.replace("file: a.png", "file: a.png, colour: red"), "buttons.measure.colour: Extra"),
        (GOOD + "export:\n  - {click: finish}\n", "export: click: finish is not a recorded button"),
        (GOOD + "export:\n  - {click: export, press: enter}\n", "one step has one of click, type"),
        (GOOD + "export:\n  - {tick: export}\n", "only its empty state was recorded"),
        (GOOD + "export: [", "cannot be read: while parsing"),
        ("", "Input should be a valid dictionary|cannot be read|the file"),
    ],
)
def test_what_is_wrong_with_a_folder(tmp_path, text, words):
    with pytest.raises(ButtonsFault, match=words):
        read_buttons(folder(tmp_path, text))


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(
        ButtonsFault, match="record the program's buttons with `labrun record-program --buttons"
    ):
        read_buttons(tmp_path / "nowhere")


def test_a_driver_without_buttons_does_not_start(tmp_path):
    config = {"buttons": str(tmp_path / "none"), "cache": ".", "exports": "."}

    with pytest.raises(DriverFault, match=r"there is no .*buttons.yaml"):
        SciapsGui(Place("libs", config, {}, tmp_path, tmp_path))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"delete": "all"}, "config.delete: Input should be 'never', 'button' or 'file'"),
        ({"measure_s": float("nan")}, "config.measure_s"),
        ({"cashe": "x"}, "config has no key cashe; its keys are: buttons, cache, exports"),
    ],
)
def test_a_wrong_configuration(tmp_path, more, words):
    config = {"buttons": str(tmp_path), "cache": ".", "exports": ".", **more}

    with pytest.raises(ValueError, match=words):
        SciapsGui(Place("libs", config, {}, tmp_path, tmp_path))
