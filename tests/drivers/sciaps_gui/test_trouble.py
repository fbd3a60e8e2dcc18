"""Errors, hangs, dialogs, locked screens: what the driver does, and never a second click for a shot."""

import asyncio
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext

pytestmark = pytest.mark.slow


async def shoot(driver):
    return await driver.measure(GoalContext("g"))


@pytest.mark.soak
def test_an_error_that_stands_there_is_read_and_closed_first(gui):
    analyser = gui.start()
    analyser.order("error The argon is low")

    assert gui.play(shoot) == {"shot_id": "shot-000001"}
    assert analyser.shots() == 1


def test_an_error_after_the_click_leaves_it_open_whether_it_fired(gui):
    analyser = gui.start()
    analyser.order("error_after_click Communication lost")

    async def story(driver):
        with pytest.raises(ActionFailed) as caught:
            await shoot(driver)
        return caught.value, await driver.measure(GoalContext("next"))

    failure, following = gui.play(story)

    assert (failure.name, failure.happened) == ("DialogOpen", "unknown")
    assert "shows an error in a window 'Error'; it was closed (its picture: " in failure.message
    assert following == {"shot_id": "shot-000002"}
    assert analyser.shots() == 1


@pytest.mark.soak
def test_an_error_of_which_the_lab_says_that_it_fires_nothing_did_not_happen(gui, tmp_path):
    buttons = tmp_path / "buttons"
    shutil.copytree(gui.recorded(), buttons)
    text = (buttons / "buttons.yaml").read_text()
    meaning = "  error:\n    says: Interlock open\n    happened: no\n"
    (buttons / "buttons.yaml").write_text(text.replace("  error:\n", meaning))
    analyser = gui.start()
    analyser.order("error_after_click Interlock open")

    failure = gui.fails(shoot, buttons=str(buttons))

    assert (failure.name, failure.happened) == ("DialogOpen", "no")
    assert "Interlock open" in failure.message


def test_a_click_into_a_program_that_then_hangs_acts_later_and_is_not_repeated(gui):
    analyser = gui.start()
    analyser.order("hang_after_click 25")  # longer than a measurement, and no look takes 20 s

    assert gui.play(shoot, measure_s=20, hang_s=90) == {"shot_id": "shot-000001"}
    assert analyser.shots() == 1


def test_a_program_that_hangs_already_is_not_clicked(gui):
    analyser = gui.start()

    async def story(driver):
        await driver.locate(GoalContext("l"))
        await asyncio.sleep(0.2)
        await driver.ready(GoalContext("r"), "measure")  # it has answered once
        analyser.tell("hang 6")
        await asyncio.sleep(0.3)
        await shoot(driver)

    failure = gui.fails(story, busy_s=2)

    assert (failure.name, failure.happened) == ("Rejected", "no")
    assert "does not respond; nothing was clicked" in failure.message
    assert analyser.shots() == 0


def test_a_hang_longer_than_anybody_waits_leaves_it_unknown_and_the_probe_finds_the_shot(gui):
    analyser = gui.start()
    analyser.order("hang_after_click 5")

    async def story(driver):
        with pytest.raises(ActionFailed) as caught:
            await shoot(driver)
        return caught.value, await driver.last_shot(GoalContext("p"))

    failure, last = gui.play(story, measure_s=8, hang_s=1.5)

    assert (failure.name, failure.happened) == ("Timeout", "unknown")
    assert last == {"shot_id": "shot-000001", "goal_id": "g"}
    assert analyser.shots() == 1


def test_a_dialog_that_nobody_knows_is_not_touched(gui):
    analyser = gui.start()
    analyser.order("open ask_boxes_here")

    failure = gui.fails(shoot)

    assert (failure.name, failure.happened) == ("DialogOpen", "no")
    assert (
        "a window 'Export: what' is open over the program; nothing was clicked" in failure.message
    )
    assert analyser.shots() == 0
    assert "export_finish" in analyser.places()


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ("lock", "'Locked' covers the whole screen: is it locked?"),
        ("blank", "the screen is a single colour: it is blank, asleep or locked"),
        ("second", "2 windows are called 'Profile Builder': 'Profile Builder 3.1"),
        ("minimise", "no window on the screen is called 'Profile Builder'"),
    ],
)
def test_a_program_that_cannot_be_made_out_is_not_clicked(gui, order, words):
    analyser = gui.start()
    analyser.order(order)

    failure = gui.fails(shoot)

    assert failure.happened == "no"
    assert words in failure.message
    assert "libs (the program 'Profile Builder'), asked to measure" in failure.message
    assert analyser.shots() == 0


def test_a_window_over_the_button_keeps_the_click_from_going_astray(gui):
    analyser = gui.start()
    analyser.order("cover_button")

    failure = gui.fails(shoot)

    assert failure.happened == "no"
    assert "the window 'Clock' covers it" in failure.message
    assert analyser.shots() == 0


def test_a_button_that_is_not_there_is_told_with_what_resembles_it_most(gui):
    gui.start(without=["measure"])

    failure = gui.fails(lambda driver: driver.locate(GoalContext("l")))

    assert (failure.name, failure.happened) == ("ButtonNotFound", "no")
    assert "measure is not visible; the best match is at" in failure.message


def test_a_program_that_is_busy_is_waited_for_and_not_clicked(gui):
    analyser = gui.start(busy=True)

    failure = gui.fails(shoot, busy_s=2)

    assert (failure.name, failure.happened) == ("Busy", "no")
    assert "its button `measure` is greyed out; nothing was clicked, after 2 s" in failure.message
    assert analyser.shots() == 0


@pytest.mark.soak
def test_a_program_drawn_far_larger_than_recorded_is_not_guessed_at(gui):
    gui.start(scale=2.6)

    assert gui.fails(lambda driver: driver.locate(GoalContext("l"))).name == "ButtonNotFound"


@pytest.mark.soak
def test_a_program_that_grows_between_two_shots_is_found_again(gui):
    gui.start(scale=0.9)

    async def story(driver):
        await shoot(driver)
        gui.end()
        gui.start(scale=1.3)
        return await driver.measure(GoalContext("2"))

    assert gui.play(story) == {"shot_id": "shot-000002"}


@pytest.mark.soak
def test_an_export_into_a_folder_that_the_program_does_not_have_is_told_and_left(gui):
    analyser = gui.start()

    async def story(driver):
        shot = (await shoot(driver))["shot_id"]
        with pytest.raises(ActionFailed) as caught:
            await gui.spectrum(driver, shot)
        return caught.value, await driver.measure(GoalContext("2"))

    failure, following = gui.play(story, export_path="/nowhere")

    assert failure.name == "DialogOpen"
    assert "shows an error in a window 'Error'; its dialogs were closed" in failure.message
    assert following == {"shot_id": "shot-000002"}
    assert analyser.shots() == 2


@pytest.mark.parametrize("word", ["exports", "cache"])
def test_a_folder_that_is_missing_at_the_start_is_told_with_its_word(gui, word):
    gui.start()

    with pytest.raises(
        OSError, match=rf"config.{word} is '/nowhere', which cannot be listed: there is no"
    ):
        gui.play(shoot, **{word: "/nowhere"})


def test_an_export_folder_that_is_gone_is_told_before_anything_is_clicked(gui):
    gui.start()

    async def story(driver):
        shot = (await shoot(driver))["shot_id"]
        (gui.folder / "program" / "exports").rmdir()
        await gui.spectrum(driver, shot)

    failure = gui.fails(story)

    assert (failure.name, failure.happened) == ("Rejected", "no")
    assert "asked to export: there is no folder or file" in failure.message
    assert "nothing was clicked" in failure.message


def test_a_picture_that_a_message_names_outlives_the_call(gui, tmp_path):
    gui.start(without=["measure"])
    config = {"contract": "libs_analyzer@1", "driver": "sciaps_gui", "config": gui.config()}
    (tmp_path / "lab.json").write_text(json.dumps({"devices": {"libs": config}}))
    done = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "call", "libs.locate", "--lab", "lab.json"],
        cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )  # fmt: skip

    assert done.returncode == 1, done.stdout + done.stderr
    (picture,) = re.findall(r"its picture: ([^)]+)", done.stderr)
    assert Path(picture).is_file()


@pytest.mark.soak
def test_an_export_folder_without_room_is_told_before_anything_is_clicked(gui, monkeypatch):
    from labrun.drivers.analyser import folder

    gui.start()
    full = folder.shutil.disk_usage("/")._replace(free=4096)

    async def story(driver):
        shot = (await shoot(driver))["shot_id"]
        monkeypatch.setattr(folder.shutil, "disk_usage", lambda path: full)
        await gui.spectrum(driver, shot)

    failure = gui.fails(story)

    assert (failure.name, failure.happened) == ("DiskFull", "no")
    assert "has only 4096 bytes free" in failure.message


@pytest.mark.soak
def test_a_shot_that_is_over_leaves_it_safe(gui):
    gui.start()

    async def story(driver):
        await shoot(driver)
        await driver.safe()
        await driver.disarm(GoalContext("d"))
        return await driver.measure(GoalContext("2"))

    assert gui.play(story) == {"shot_id": "shot-000002"}
