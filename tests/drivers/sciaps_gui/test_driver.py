"""The driver against a real program on a real screen: one click a goal, whole files, safe deletion."""

import asyncio
import re
import time

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.find import check_driver, find_driver
from labrun.schemas.contracts import shipped_contracts

pytestmark = pytest.mark.slow


CHANNELS = 2000


def test_it_keeps_the_contract(tmp_path):
    check_driver(find_driver("sciaps_gui", tmp_path), shipped_contracts()["libs_analyzer@1"])


@pytest.mark.parametrize(
    ("look", "scale", "steps"),
    [
        pytest.param("grey", 1.2, 2, marks=pytest.mark.soak),
        pytest.param("dark", 1.4, 1, marks=pytest.mark.soak),
        pytest.param("paper", 0.8, 2, marks=pytest.mark.soak),
    ],
)
def test_shots_are_fired_and_exported_whatever_the_program_looks_like(gui, look, scale, steps):
    analyser = gui.start(look=look, scale=scale, steps=steps)

    async def story(driver):
        await driver.locate(GoalContext("l"))
        data = []
        for n in range(2):
            shot = (await driver.measure(GoalContext(f"m{n}")))["shot_id"]
            data.append(await gui.spectrum(driver, shot, f"e{n}"))
        return data, await driver.last_shot(GoalContext("p")), await driver.status()

    data, last, status = gui.play(story, look)

    assert analyser.shots() == 2
    assert [len(d.splitlines()) for d in data] == [CHANNELS + 1] * 2
    assert data[0] != data[1]
    assert last == {"shot_id": "shot-000002", "goal_id": "m1"}
    assert status == {"armed": False, "shots": 2, "interlock": "unknown"}
    assert len(analyser.entries()) == 2
    named = sorted(path.name for path in (gui.folder / "program" / "exports").iterdir())
    assert [re.sub(r"\d{8}_\d{6}$", "TIME", name) for name in named] == [
        "shot-000001_TIME", "shot-000002_TIME",
    ]  # fmt: skip


@pytest.mark.soak
def test_boxes_that_are_ticked_already_stay_ticked(gui):
    gui.start(ticked=["separate_spectrum", "new_folder"])

    async def story(driver):
        return await gui.spectrum(driver, (await driver.measure(GoalContext("m")))["shot_id"])

    gui.play(story)
    files = sorted(p for p in (gui.folder / "program" / "exports").rglob("*") if p.is_file())

    assert [f.stem.rpartition("_")[2] for f in files] == ["1", "2"]
    assert files[0].parent.name.startswith("shot-000001_")


@pytest.mark.soak
def test_a_file_that_grows_slowly_is_taken_when_it_is_whole(gui):
    gui.start(write_s=1.0)

    async def story(driver):
        return await gui.spectrum(driver, (await driver.measure(GoalContext("m")))["shot_id"])

    assert len(gui.play(story).splitlines()) == CHANNELS + 1


@pytest.mark.soak
def test_a_file_that_stays_half_is_not_handed_over_and_nothing_is_deleted(gui):
    analyser = gui.start(write_s=100.0)

    async def story(driver):
        return await gui.spectrum(driver, (await driver.measure(GoalContext("m")))["shot_id"])

    failure = gui.fails(story, delete="file", export_s=1.5)

    assert (failure.name, failure.happened) == ("Timeout", "unknown")
    assert "_1.csv" in failure.message and "nothing was deleted" in failure.message
    assert len(analyser.entries()) == 1


@pytest.mark.soak
@pytest.mark.parametrize("delete", ["button", "file"])
def test_what_was_exported_is_deleted_by_name_and_nothing_else(gui, delete):
    for name in ("shot_1", "shot_2"):
        (gui.folder / "program" / "cache" / name).mkdir(parents=True)
    analyser = gui.start()

    async def story(driver):
        newer = (await driver.measure(GoalContext("2")))["shot_id"]
        return await gui.spectrum(driver, newer), await gui.spectrum(driver, newer, "again")

    data, again = gui.play(story, delete=delete)

    assert analyser.entries() == {"shot_1", "shot_2"}
    assert data == again


@pytest.mark.soak
def test_the_spectrum_of_another_shot_is_noticed_before_anything_is_deleted(gui):
    analyser = gui.start(keep=True)  # whatever is measured, the oldest shot stays selected

    async def story(driver):
        first = (await driver.measure(GoalContext("1")))["shot_id"]
        await gui.spectrum(driver, first)
        return await gui.spectrum(driver, (await driver.measure(GoalContext("2")))["shot_id"], "2e")

    failure = gui.fails(story, delete="never")

    assert "wrote the spectrum of shot-000001 again" in failure.message
    assert len(analyser.entries()) == 2


def test_a_goal_is_clicked_once_for_ever(gui):
    analyser = gui.start()

    async def story(driver):
        await driver.measure(GoalContext("g"))
        await driver.measure(GoalContext("g"))

    failure = gui.fails(story)

    assert failure.happened == "unknown"
    assert "it is not repeated" in failure.message
    assert analyser.shots() == 1


def test_a_goal_that_was_stopped_before_its_click_is_not_clicked(gui):
    analyser = gui.start()

    async def story(driver):
        goal = GoalContext("g")
        goal.cancelled.set()
        await driver.measure(goal)

    failure = gui.fails(story)

    assert (failure.name, failure.happened) == ("Rejected", "no")
    assert analyser.shots() == 0


def test_it_is_closed_when_a_look_that_is_under_way_has_ended(gui):
    """The connection to the screen is the looking thread's: without it, it would wait for ever."""
    gui.start()

    async def story():
        driver = gui.driver()
        await driver.open()

        def slowly():
            time.sleep(0.5)
            return driver.program.seen()

        looking = asyncio.create_task(driver.on_screen(slowly))
        await asyncio.sleep(0.1)
        await driver.close()
        return (await looking).state

    assert asyncio.run(story()) == "idle"


def test_a_goal_that_is_stopped_while_it_aims_is_not_clicked(gui):
    analyser = gui.start()

    async def story(driver):
        goal, aim = GoalContext("g"), driver.program.aim

        def aim_and_be_stopped(*given):
            found = aim(*given)
            goal.cancelled.set()
            return found

        driver.program.aim = aim_and_be_stopped
        with pytest.raises(ActionFailed, match="it was stopped; nothing was clicked") as caught:
            await driver.measure(goal)
        return caught.value.happened

    assert (gui.play(story), analyser.shots()) == ("no", 0)


def test_nothing_is_clicked_where_somebody_has_moved_the_mouse_meanwhile(gui):
    analyser = gui.start()

    async def story(driver):
        aim = driver.program.aim

        def aim_and_be_pushed(*given):
            found = aim(*given)
            driver.program._hands._gui.moveTo(found.x + 200, found.y + 40)
            return found

        driver.program.aim = aim_and_be_pushed
        with pytest.raises(ActionFailed, match="someone else is moving it; nothing was") as caught:
            await driver.measure(GoalContext("g"))
        driver.program.aim = aim
        await driver.measure(GoalContext("h"))
        return caught.value.happened

    assert (gui.play(story), analyser.shots()) == ("no", 1)


@pytest.mark.soak
def test_an_old_shot_that_was_not_exported_cannot_be_any_more(gui):
    gui.start()

    async def story(driver):
        first = (await driver.measure(GoalContext("1")))["shot_id"]
        await driver.measure(GoalContext("2"))
        await gui.spectrum(driver, first)

    assert gui.fails(story).name == "UnknownShot"
