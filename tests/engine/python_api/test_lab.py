"""`labrun.lab`: one action at a time from Python, as `labrun call` does it."""

import _thread
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import labrun


@pytest.fixture(scope="module")
def lab():
    with labrun.lab(yes=["motion"]) as lab:
        yield lab


def test_an_action_takes_and_returns_units(lab):
    first = lab.gantry.move_to(x="1 cm", y=2)
    second = lab["gantry"].move_to(x=first["x"] + first["x"])

    assert first["x"].to("cm").magnitude == pytest.approx(
        1, abs=0.001
    )  # as far as it is repeatable
    assert first["y"].to("mm").magnitude == pytest.approx(2, abs=0.01)
    assert second["x"].to("mm").magnitude == pytest.approx(20, abs=0.02)


def test_what_cannot_be_sent_is_refused_in_a_sentence(lab):
    with pytest.raises(labrun.Refused, match="10 s is a time, the device wants a length"):
        lab.gantry.move_to(x="10 s")
    with pytest.raises(labrun.Refused, match=r"outside x 0\.\.730 mm"):
        lab.gantry.move_to(x="10 m")
    with pytest.raises(labrun.Refused, match="takes its values by name: x, y, z"):
        lab.gantry.move_to(10)
    with pytest.raises(AttributeError, match="did you mean move_to") as told:
        lab.gantry.mvoe_to(x=1)
    assert told.value._render_traceback_() == [str(told.value)]  # what IPython shows
    with pytest.raises(labrun.Refused, match="no device 'gantri'"):
        lab["gantri"]


def test_what_is_dangerous_waits_for_a_person(lab):
    with pytest.raises(labrun.Refused, match=r"libs\.measure is dangerous \(laser\) and nobody"):
        lab.libs.measure()


def test_devices_and_actions_show_themselves(lab):
    assert "gantry" in dir(lab) and "gantry" in repr(lab)
    assert "move_to" in dir(lab.gantry) and repr(lab.gantry).startswith("<gantry@1 gantry: ")
    assert lab.gantry.move_to.__doc__ and not hasattr(lab, "_repr_html_")


def test_a_failure_is_the_devices_own_words(bench):
    with (
        labrun.lab(bench.lab, yes=True) as lab,
        pytest.raises(labrun.ActionFailed, match=r"^a\.act: Broken: "),
    ):
        lab.a.act(name="byhand", script="Broken")


def test_a_closed_lab_says_so_and_a_lab_with_faults_shows_them(bench, tmp_path):
    lab = labrun.lab(bench.lab, yes=True)
    lab.close()
    with pytest.raises(labrun.Refused, match="this lab is closed"):
        lab.a.act(name="byhand")
    (tmp_path / "lab.yaml").write_text("devices: {}\n")
    with pytest.raises(labrun.Refused, match=r"lab\.yaml:1:\d+: error"):
        labrun.lab(tmp_path / "lab.yaml")


def test_a_device_that_somebody_else_holds_is_left_to_them(bench):
    with labrun.lab(bench.lab, yes=True) as mine, labrun.lab(bench.lab, yes=True) as other:
        mine.a.act(name="mine")
        with pytest.raises(labrun.Refused, match=r"'a' at .* is held by call-.* Nothing was sent"):
            other.a.act(name="other")
    with labrun.lab(bench.lab, yes=True) as lab:
        lab.a.act(name="later")


@pytest.mark.slow
def test_others_find_its_devices_and_after_a_stop_they_are_leased_anew(tmp_path):
    path = tmp_path / "lab.yaml"
    path.write_text(
        "name: held\nsimulated: true\n"
        "devices: {gantry: {contract: gantry@1, driver: sim_gantry, config: {homed: true}}}\n"
    )
    stop = [sys.executable, "-m", "labrun.engine", "stop", "gantry", "--lab", path]
    with labrun.lab(path, yes=["motion"]) as lab:
        lab.gantry.move_to(x=1)
        with (
            labrun.lab(path, yes=["motion"]) as another,
            pytest.raises(labrun.Refused, match=r"held by call-.*`labrun stop gantry`.*Nothing"),
        ):
            another.gantry.halt()
        stopped = subprocess.run(stop, cwd=tmp_path, capture_output=True, text=True)
        with pytest.raises(labrun.ActionFailed, match=r"gantry\.move_to: Stopped: .* stopped by"):
            lab.gantry.move_to(x=2)

        assert stopped.stdout == "gantry is in its safe state\n"
        assert lab.gantry.move_to(x=3)["x"].magnitude == pytest.approx(3, abs=0.01)


def test_an_interrupt_cancels_the_action_and_says_where_things_stand(bench):
    before = len(bench.calls())

    def interrupt():
        while len(bench.calls()) == before:
            time.sleep(0.02)
        _thread.interrupt_main()

    was = signal.signal(signal.SIGINT, signal.default_int_handler)  # may be ignored here
    interrupting = threading.Thread(target=interrupt)
    try:
        with (
            labrun.lab(bench.lab, yes=True) as lab,
            pytest.raises(
                KeyboardInterrupt, match=r"a\.act was cancelled by Ctrl-C and ended CANC"
            ),
        ):
            interrupting.start()
            lab.a.act(name="long", seconds=60)
    finally:
        interrupting.join()
        signal.signal(signal.SIGINT, was)


def test_a_lab_that_is_forgotten_gives_its_folder_back(bench):
    lab = labrun.lab(bench.lab, yes=True)
    folder = Path(lab._session._folder)
    lab.a.act(name="once")

    assert folder.exists()
    del lab
    assert not folder.exists()
