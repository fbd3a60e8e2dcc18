"""`labrun record-program --box` and `--find` on pictures of a screen: recorded and found, or why not."""

import subprocess
import sys

import cv2
import numpy as np
import pytest
from PIL import Image

from labrun.drivers.window_program.buttons import read_buttons

from ...command_line import labrun

pytestmark = pytest.mark.slow

MEASURE, EXPORT = "measure=30,40,120,40", "export=300,40,120,40"


def drawn(scale: float = 1.0, twice: bool = False) -> np.ndarray:
    """A window with two buttons; `twice`: the first of them again."""
    screen = np.full((round(300 * scale), round(600 * scale), 3), 240, np.uint8)
    words = [((30, 40), "Measure"), ((300, 40), "Export")] + [((30, 200), "Measure")] * twice
    for (x, y), text in words:
        corners = [(round(a * scale), round(b * scale)) for a, b in ((x, y), (x + 119, y + 39))]
        cv2.rectangle(screen, *corners, (200, 210, 230), -1)
        cv2.rectangle(screen, *corners, (90, 90, 90), 1)
        at = round((x + 12) * scale), round((y + 27) * scale)
        cv2.putText(
            screen, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.7 * scale, (20, 20, 60), 2, cv2.LINE_AA
        )
    return screen


def saved(folder, name, picture):
    Image.fromarray(picture).save(folder / name)
    return name


def record(folder, *more):
    saved(folder, "screen.png", drawn())
    return labrun(folder, "record-program", "-o", "b", "--image", "screen.png", *more)


def test_marked_buttons_are_recorded_and_found_at_another_size(tmp_path):
    done = record(
        tmp_path, "--box", MEASURE, "--box", EXPORT, "--at", "export=0,5", "--title", "Ana"
    )
    saved(tmp_path, "larger.png", drawn(1.4))
    found = labrun(
        tmp_path,
        "record-program",
        "--find",
        "-o",
        "b",
        "--image",
        "larger.png",
        "--seen",
        "seen.png",
    )
    buttons = read_buttons(tmp_path / "b")

    assert done.returncode == 0, done.stderr
    assert "b holds measure, export" in done.stderr
    assert (buttons.title, buttons.button("export").at) == ("Ana", (0, 5))
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout.startswith("ok  main   measure at 126,84 (fit 0.9")
    assert np.asarray(Image.open(tmp_path / "seen.png")).shape == (420, 840, 3)


def test_a_button_that_is_there_twice_is_not_recorded(tmp_path):
    saved(tmp_path, "screen.png", drawn(twice=True))
    done = labrun(
        tmp_path,
        "record-buttons",
        "-o",
        "b",
        "--image",
        "screen.png",
        "--box",
        MEASURE,
        "--box",
        EXPORT,
    )

    assert done.returncode == 1
    assert (
        "measure was not recorded, because it would not be found again: measure is there 2 times"
        in done.stderr
    )
    assert "b holds export" in done.stderr


def test_a_button_that_is_not_there_is_told_with_status_1(tmp_path):
    record(tmp_path, "--box", MEASURE, "--box", EXPORT)
    saved(tmp_path, "empty.png", drawn()[150:])
    found = labrun(tmp_path, "find-buttons", "b", "--image", "empty.png")

    assert found.returncode == 1
    assert "--  main   measure is not visible" in found.stdout


def test_what_was_recorded_before_stays(tmp_path):
    record(tmp_path, "--box", MEASURE)
    record(tmp_path, "--box", EXPORT)

    assert set(read_buttons(tmp_path / "b").named("main")) == {"measure", "export"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--box", "measure=1,2,3"], "--box measure=1,2,3: write 4 whole numbers"),
        (["--box", "mesure=30,40,120,40"], "--where mesure=dialog); did you mean measure?"),
        (["--box", "measure=590,40,120,40"], "is not inside the picture of 600 x 300"),
        (["--box", "measure=30,40,9,9"], "9 x 9 pixels are too few"),
        (["--box", "measure=200,150,80,40"], "it is a single colour"),
        (
            ["--box", MEASURE, "--where", "measure=here"],
            "choose one of main, dialog, error, banner, busy",
        ),
        (
            ["--box", "new_folder.on=30,40,120,40"],
            "record new_folder, the box that is not ticked, first",
        ),
        ([], "mark buttons with --box NAME=X,Y,W,H, or run it at a terminal"),
    ],
)
def test_wrong_marks_are_told(tmp_path, arguments, words):
    done = record(tmp_path, *arguments)

    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_a_picture_that_is_none(tmp_path):
    (tmp_path / "screen.png").write_text("no picture")
    done = labrun(tmp_path, "record-buttons", "--image", "screen.png", "--box", MEASURE)

    assert (done.returncode, "cannot be read as a picture" in done.stderr) == (2, True)


@pytest.mark.skipif(sys.platform != "linux", reason="only X11 can be taken away")
def test_without_a_screen(tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    command = [sys.executable, "-m", "labrun.engine", "record-buttons", "--box", MEASURE]
    # In a process of its own: in this one, another test may have found the screen already.
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert done.returncode == 4
    assert "there is no screen" in done.stderr


def test_a_sign_that_the_idle_program_shows_is_not_recorded(tmp_path):
    record(tmp_path, "--box", MEASURE, "--box", EXPORT)
    screen = drawn()
    cv2.putText(screen, "ERROR!", (200, 150), cv2.FONT_HERSHEY_SIMPLEX, 0.9, (0, 0, 0), 2)
    saved(tmp_path, "error.png", screen)
    boxes = ["--box", "error_of_all=290,30,140,60", "--box", "error=190,120,120,40"]
    done = labrun(tmp_path, "record-buttons", "-o", "b", "--image", "error.png", *boxes)

    assert done.returncode == 1
    assert "error_of_all was not recorded" in done.stderr
    assert "while the program was idle, too: mark more of it" in done.stderr
    assert read_buttons(tmp_path / "b").named("error") == ["error"]
