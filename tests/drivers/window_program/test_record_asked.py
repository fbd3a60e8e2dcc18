"""`labrun record-program --buttons` at a terminal: a person points, and the driver can begin."""

import os
import pty
import subprocess
import sys
import time

import pytest

from labrun.drivers.window_program.buttons import read_buttons
from labrun.drivers.window_program.hands import Hands

PATIENCE_S = 500


class Terminal:
    """A pseudo-terminal with the command at its other end."""

    def __init__(self, *arguments: str, cwd) -> None:
        self.ours, theirs = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "labrun.engine", *arguments],
            cwd=cwd, stdin=theirs, stdout=theirs, stderr=theirs,
        )  # fmt: skip
        os.close(theirs)
        self.text = ""

    def until(self, words: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while words not in self.text and time.monotonic() < end:
            try:
                self.text += os.read(self.ours, 4096).decode()
            except OSError:
                break
        assert words in self.text, self.text
        self.text = self.text.partition(words)[2]

    def say(self, line: str = "") -> None:
        os.write(self.ours, f"{line}\n".encode())


@pytest.fixture
def terminal(gui, tmp_path):
    opened = Terminal(
        "record-program", "--buttons", "-o", "mine", "--title", "Profile Builder", cwd=tmp_path
    )
    yield opened
    opened.process.kill()
    opened.process.wait()
    os.close(opened.ours)


@pytest.mark.slow
def test_a_person_records_with_the_mouse(gui, terminal, tmp_path):
    places, hands = gui.start().places(), Hands()

    def point(x, y):
        hands.move(x, y)
        terminal.say()

    for name in ("measure", "sample_name", "export"):
        x, y, w, h = places[name]
        terminal.until(f"{name}, ")
        point(x, y)
        terminal.until("lower right corner")
        point(x + w, y + h)
        if name == "sample_name":
            terminal.until("into the field")
            point(x + w + 60, y + h // 2)
        terminal.until("away from it")
        point(1700, 1000)
    terminal.until("delete, ")
    terminal.say("q")
    buttons = (terminal.process.wait(PATIENCE_S), read_buttons(tmp_path / "mine"))[1]

    assert terminal.process.returncode == 0
    assert buttons.named("main") == ["measure", "sample_name", "export"]
    assert buttons.button("sample_name").at[0] == places["sample_name"][2] // 2 + 60
    assert buttons.title == "Profile Builder"
