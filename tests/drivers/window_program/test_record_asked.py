"""`labrun record-program --buttons` at a terminal: a person points, and the driver can begin."""

import pytest

from labrun.drivers.window_program.buttons import read_buttons
from labrun.drivers.window_program.hands import Hands


@pytest.mark.slow
def test_a_person_records_with_the_mouse(gui, terminal, tmp_path):
    terminal = terminal("record-program", "--buttons", "-o", "mine", "--title", "Profile Builder")
    places, hands = gui.start().places(), Hands()

    def point(x, y):
        hands.move(x, y)
        terminal.press("\n")

    for name in ("measure", "sample_name", "export"):
        x, y, w, h = places[name]
        terminal.wait_for(f"{name}, ")
        point(x, y)
        terminal.wait_for("lower right corner")
        point(x + w, y + h)
        if name == "sample_name":
            terminal.wait_for("into the field")
            point(x + w + 60, y + h // 2)
        terminal.wait_for("away from it")
        point(1700, 1000)
    terminal.answer("delete, ", "q")
    status = terminal.end()
    buttons = read_buttons(tmp_path / "mine")

    assert status == 0
    assert buttons.named("main") == ["measure", "sample_name", "export"]
    assert buttons.button("sample_name").at[0] == places["sample_name"][2] // 2 + 60
    assert buttons.title == "Profile Builder"
