"""Whose spectrum an export brought: proved, or set aside with a sentence; nothing else is deleted."""

import shutil

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext

from ..window_program.bench import grabbed
from ..window_program.spectra import csv_text

pytestmark = pytest.mark.slow
CHANNELS = 2000


async def shoot(driver, goal: str) -> str:
    return (await driver.measure(GoalContext(goal)))["shot_id"]


def own(driver, shot: str, number: str = "1") -> bytes:
    """The spectrum that the program has for this shot."""
    return csv_text(driver.shot_log.shot(shot).entry, number, CHANNELS).encode()


def test_a_shot_whose_export_was_given_up_is_not_filed_as_the_next_one(gui):
    gui.start(exports="list")

    async def measured(driver):
        return await shoot(driver, "1")

    async def story(driver):
        second = await shoot(driver, "2")
        with pytest.raises(ActionFailed) as caught:
            await gui.spectrum(driver, second)
        third = await shoot(driver, "3")
        return caught.value, own(driver, third), await gui.spectrum(driver, third, "e3")

    gui.play(measured)  # its server ends before the export
    failure, wanted, got = gui.play(story)
    aside = sorted((gui.folder / "mine" / "quarantine").rglob("*"))

    assert (failure.name, failure.happened) == ("Rejected", "unknown")
    assert "2 spectra that were never seen before" in failure.message
    assert "shot-000001" in failure.message and str(aside[0]) in failure.message
    assert [path.name[-6:] for path in aside if path.suffix == ".csv"] == ["_1.csv", "_2.csv"]
    assert failure.message.startswith((aside[0] / "why.txt").read_text().strip())
    assert got == wanted


@pytest.mark.soak
def test_a_program_that_exports_its_list_is_exported_from_point_after_point(gui):
    analyser = gui.start(exports="list")

    async def story(driver):
        pairs = []
        for n in range(2):
            shot = await shoot(driver, f"m{n}")
            pairs.append((await gui.spectrum(driver, shot, f"e{n}"), own(driver, shot)))
        return pairs

    pairs = gui.play(story, delete="never")

    assert all(got == wanted for got, wanted in pairs)
    assert len(analyser.entries()) == 2


@pytest.mark.soak
@pytest.mark.parametrize("stray", ["other_1.csv", "sample7/sample7_1.csv"])
def test_a_strangers_file_is_left_alone_and_the_own_one_waited_for(gui, stray):
    analyser = gui.start(stray=stray, late_s=8.0)

    async def story(driver):
        shot = await shoot(driver, "1")
        return await gui.spectrum(driver, shot), own(driver, shot)

    got, wanted = gui.play(story, delete="file", export_s=30)

    assert got == wanted
    assert analyser.entries() == set()
    assert (gui.folder / "program" / "exports" / stray).is_file()


@pytest.mark.soak
def test_a_strangers_file_alone_is_not_taken_and_nothing_is_deleted(gui):
    analyser = gui.start(stray="other_1.csv", late_s=100.0)

    async def story(driver):
        await gui.spectrum(driver, await shoot(driver, "1"))

    failure = gui.fails(story, delete="file", export_s=3)

    assert failure.name == "Timeout"
    assert "other_1.csv" in failure.message and "nothing was deleted" in failure.message
    assert len(analyser.entries()) == 1


@pytest.mark.soak
def test_the_only_file_of_a_program_with_two_unknown_entries_is_set_aside(gui):
    gui.start(keep=True)  # whatever is measured, the oldest shot stays selected

    async def story(driver):
        await shoot(driver, "1")
        await gui.spectrum(driver, await shoot(driver, "2"))

    failure = gui.fails(story)

    assert "shot-000001" in failure.message and "never exported" in failure.message


def test_a_word_in_the_status_bar_is_no_error(gui, tmp_path):
    analyser = gui.start(says="error")
    box = analyser.places()["state"]
    x, y, width, height = box
    picture = grabbed()[y : y + height, x : x + width]
    gui.end()
    buttons = tmp_path / "buttons"
    shutil.copytree(gui.recorded(), buttons)
    save_picture(buttons / "error.png", picture)
    analyser = gui.start(says="Last error: none")

    async def story(driver):
        return await driver.measure(GoalContext("1"))

    assert gui.play(story, buttons=str(buttons)) == {"shot_id": "shot-000001"}
    assert analyser.shots() == 1


def save_picture(path, picture):
    from PIL import Image

    Image.fromarray(picture).save(path)
    text = (path.parent / "buttons.yaml").read_text()
    before, _, after = text.partition("  error_close:")
    rest = after.partition("  delete_yes:")
    (path.parent / "buttons.yaml").write_text(before + "  delete_yes:" + rest[2])


@pytest.mark.soak
def test_the_confirmation_that_sync_opens_is_confirmed(gui):
    gui.start(sync_asks=True)

    async def story(driver):
        await gui.spectrum(driver, await shoot(driver, "1"))
        return await shoot(driver, "2")

    assert gui.play(story, sync=True) == "shot-000002"
    assert len((gui.folder / "program" / "synced.log").read_text().splitlines()) == 1


@pytest.mark.soak
def test_a_dialog_of_its_own_that_comes_late_does_not_stay_open(gui):
    analyser = gui.start(dialog_s=6.0)

    async def story(driver):
        first = await shoot(driver, "1")
        with pytest.raises(ActionFailed) as caught:
            await gui.spectrum(driver, first)
        analyser.order("set dialog_s 0.1")
        await gui.spectrum(driver, first, "again")
        return caught.value, await shoot(driver, "2")

    failure, following = gui.play(story, dialog_s=3, busy_s=30)

    assert "export_cancel" not in analyser.places()
    assert failure.happened == "no"
    assert following == "shot-000002"


def test_a_dialog_that_a_killed_server_left_open_is_left_by_the_next_one(gui):
    analyser = gui.start()

    async def killed(driver):
        shot = await shoot(driver, "1")
        driver.shot_log.learn("dialog", shot)  # as it stands there in the middle of an export
        analyser.order("open ask_folder")

    async def story(driver):
        return await shoot(driver, "2")

    gui.play(killed)

    assert gui.play(story) == "shot-000002"
