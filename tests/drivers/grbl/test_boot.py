"""A controller is reached, or what is on the port is said in a sentence."""

import asyncio
import os
import pty
import threading
import tty

import pytest

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.grbl.gantry import Grbl


def fault_of(driver):
    """The sentence with which opening fails; the driver leaves nothing behind."""

    async def story():
        with pytest.raises(OSError) as caught:
            await driver.open()
        await driver.close()
        return str(caught.value)

    return asyncio.run(story())


@pytest.fixture
def stranger(tmp_path):
    """Something else on a port; `stranger(b"words")` answers so whatever it is told."""
    ends = []

    def make(words):
        master, slave = pty.openpty()
        tty.setraw(slave)
        ends.extend([master, slave])

        def answer():
            while True:
                try:
                    if os.read(master, 100) and words:
                        os.write(master, words)
                except OSError:
                    return

        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        config = {"port": os.ttyname(slave), "boot_s": 0.3}
        return Grbl(Place("gantry", config, {}, tmp_path / "gantry", tmp_path))

    yield make
    for end in reversed(ends):
        os.close(end)


def test_it_waits_for_the_banner_and_reads_the_settings_once(peer, gantry, played):
    async def story(driver):
        await driver.status()
        return driver.controller.settings.travel, driver.controller.firmware

    found = played(gantry(peer), story, homed=False)

    assert found == ((810.0, 730.0, 90.0), "Grbl 1.1h")
    assert peer.heard.count("$$") == 1
    assert peer.overrun == 0


def test_a_controller_that_was_restarted_is_locked_and_not_homed(peer, gantry, played):
    status = played(gantry(peer), lambda driver: driver.status(), homed=False)

    assert (status["state"], status["homed"]) == ("alarm", False)
    assert "locked until it is homed" in status["alarm"]


def test_grblhal_has_no_lock_and_is_not_homed_either(peers, gantry, played):
    status = played(gantry(peers(hal=True)), lambda driver: driver.status(), homed=False)

    assert (status["state"], status["homed"], status["alarm"]) == ("idle", False, "")


def test_a_board_that_does_not_boot_when_its_port_is_opened_is_found_by_its_report(
    peers, gantry, played
):
    peer = peers(hal=True, boots_on_open=False)

    status = played(gantry(peer, boot_s=0.3), lambda driver: driver.status(), homed=False)

    assert status["state"] == "idle"
    assert "18" in peer.heard


@pytest.mark.parametrize(
    ("hal", "named"), [(False, "Grbl 1.1h.20190830"), (True, "grblHAL 1.1f.20190830")]
)
def test_one_that_says_no_banner_is_named_by_its_version(peers, gantry, played, hal, named):
    peer = peers(hal=hal, boots_on_open=False)
    peer.state = "Alarm"  # a stop would make it boot

    async def story(driver):
        return driver.controller.firmware, driver.controller.kind.name

    firmware, kind = played(gantry(peer, boot_s=0.3), story, homed=False)

    assert (firmware, kind) == (named, "grblHAL" if hal else "GRBL")


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({100: 0.0}, r"$100 is 0, so a move of X never ends: write steps per mm, `$100=...`"),
        ({112: 0.0}, r"$112 is 0, so a move of Z never ends: write its fastest rate"),
        ({121: 0.0}, r"$121 is 0, so a move of Y never ends: write its acceleration"),
    ],
)
def test_settings_with_which_no_move_would_end_are_refused(peers, gantry, settings, why):
    peer = peers(settings=settings)

    assert fault_of(gantry(peer)).startswith(f"{peer.path}: {why}")


def test_no_such_port(tmp_path):
    driver = Grbl(Place("gantry", {"port": "/dev/ttyNONE7"}, {}, tmp_path, tmp_path))

    assert fault_of(driver).startswith("there is no port /dev/ttyNONE7: is the cable plugged in?")


def test_a_file_that_is_no_port(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("no port")
    driver = Grbl(Place("gantry", {"port": str(path)}, {}, tmp_path, tmp_path))

    assert "notes.txt is not a serial port" in fault_of(driver)


def test_a_second_program_on_the_port_is_refused(peer, gantry, played):
    async def story(driver):
        second = gantry(peer)
        with pytest.raises(OSError, match="is in use by another program: close it there"):
            await second.open()
        await second.close()
        return (await driver.move_to(GoalContext("m"), x=3))["x"]

    assert played(gantry(peer), story) == pytest.approx(3, abs=0.005)


@pytest.mark.slow
def test_the_wrong_baud_rate(peer, gantry):
    assert "unreadable bytes: 9600 baud is probably wrong" in fault_of(gantry(peer, baud=9600))


def test_another_instrument_on_the_port(stranger):
    assert "responds, but not as GRBL does: it sent `ES`" in fault_of(stranger(b"ES\r\n"))


def test_nothing_on_the_port(stranger):
    assert "nothing on it responds: no GRBL banner within 0.3 s" in fault_of(stranger(b""))


def test_a_firmware_of_before_1_1_is_named(stranger):
    said = fault_of(stranger(b"Grbl 0.9j ['$' for help]\r\n"))

    assert "this is Grbl 0.9j, whose reports have an older format" in said


def test_a_port_behind_the_network_that_is_not_there(tmp_path):
    config = {"port": "socket://127.0.0.1:1"}
    driver = Grbl(Place("gantry", config, {}, tmp_path, tmp_path))

    assert "socket://127.0.0.1:1 cannot be reached" in fault_of(driver)
