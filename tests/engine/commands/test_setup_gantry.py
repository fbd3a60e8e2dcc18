"""`labrun setup gantry` in a terminal, with a person who answers, in front of a controller."""

import signal
import time

import pytest

from labrun.drivers.find import check_driver, find_driver
from labrun.engine.lab.lab import load_lab

from ...drivers.grbl.controllers import peer, peers

__all__ = ["peer", "peers"]

pytestmark = pytest.mark.slow


def test_from_a_cable_to_a_lab_that_works(terminal, peer, tmp_path):
    terminal = terminal("setup", "gantry", "--port", peer.path)
    terminal.answer("$20=1: soft limits are off", "y")
    terminal.answer("Move?", "y")  # each goes to minus: with soft limits on, 0 is an end
    for question, way in (("X: which way", "b"), ("Y: which way", "l"), ("Z: which way", "u")):
        terminal.answer(question, way)
    terminal.answer("Home it now?", "y")
    terminal.answer("Another zero?", "")
    status = terminal.end()
    lab, problems = load_lab(tmp_path / "lab.yaml")

    assert status == 0, terminal.screen
    assert problems == []
    assert lab is not None
    device = lab.lab.devices["gantry"]
    assert device.config == {
        "port": peer.path, "home_first": True, "axes": {"x": "Y", "y": "-X", "z": "-Z"},
    }  # fmt: skip
    assert (device.limits["x"].maximum, device.limits["y"].maximum) == (725, 805)
    assert "-0," not in (tmp_path / "lab.yaml").read_text()
    assert peer.settings[20] == 1
    assert "$130=810.000" in (tmp_path / "lab.settings.txt").read_text()
    check_driver(find_driver(device.driver, tmp_path), lab.contracts[device.contract])


def test_an_axis_that_does_not_move_ends_it_and_nothing_is_written(terminal, peer, tmp_path):
    terminal = terminal("setup", "gantry", "--port", peer.path)
    terminal.answer("$20=1: soft limits are off", "n")
    terminal.answer("Move?", "y")
    terminal.answer("X: which way", "none")
    status = terminal.end()

    assert status != 0
    assert "X did not move: look at its motor's cable" in terminal.screen.replace("\n", " ")
    assert not (tmp_path / "lab.yaml").exists()


@pytest.mark.parametrize(
    ("number", "word", "status"),
    [(signal.SIGINT, "Ctrl-C", 130), (signal.SIGTERM, "SIGTERM", 1)],
)
def test_a_signal_stops_what_moves_and_waits_for_no_answer(terminal, peers, number, word, status):
    peer = peers()
    peer.homing_s = 1000.0
    terminal = terminal("setup", "gantry", "--port", peer.path)
    terminal.answer("$20=1: soft limits are off", "n")
    if word == "Ctrl-C":
        terminal.wait_for("Move?")
    else:
        terminal.answer("Move?", "n")
        terminal.answer("Home it now?", "y")
        while peer.state != "Home" and terminal.process.poll() is None:
            time.sleep(0.02)
    terminal.process.send_signal(number)
    ended = terminal.end()

    assert ended == status, terminal.screen
    assert f"{word}: stopped; lab.yaml was not written" in terminal.screen
    while peer.state == "Home":  # what was sent to it is on its way
        time.sleep(0.02)


def test_no_controller_there(terminal, tmp_path):
    terminal = terminal("setup", "gantry", "--port", str(tmp_path / "none"))

    assert terminal.end() != 0
    assert "there is no port" in terminal.screen
    assert "no controller was found" in terminal.screen
