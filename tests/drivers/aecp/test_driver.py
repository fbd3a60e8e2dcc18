"""The driver of the paper's analyser server: what is known after every answer, and after none."""

import asyncio
import hashlib
import re
import threading
import time
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest

from labrun.drivers.aecp.answers import times_in
from labrun.drivers.aecp.driver import Aecp
from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.find import check_driver, find_driver
from labrun.schemas.contracts import shipped_contracts

pytestmark = pytest.mark.slow

CHANNELS = 2000


async def failing(action, *args, **named) -> ActionFailed:
    with pytest.raises(ActionFailed) as caught:
        await action(*args, **named)
    return caught.value


def test_it_keeps_the_contract(tmp_path):
    check_driver(Aecp, shipped_contracts()["libs_analyzer@1"])

    assert find_driver("aecp", tmp_path) is Aecp


def test_a_shot_is_fired_once_and_its_whole_spectrum_comes_home(aecp):
    aecp.start()

    async def story(driver):
        shot = (await driver.measure(GoalContext("r/main/1")))["shot_id"]
        goal = GoalContext("r/main/2")
        result = await driver.export(goal, shot=shot, file="spectra/a.csv")
        return result, goal.files["file"], await driver.last_shot(GoalContext("p"))

    result, file, last = aecp.play(story)

    assert aecp.shots() == 1
    assert result["sha256"] == file.sha256 == hashlib.sha256(file.data).hexdigest()
    assert len(file.data.splitlines()) == CHANNELS + 1
    assert last == {"shot_id": "shot-000001", "goal_id": "r/main/1"}


def test_success_before_the_file_is_whole_is_waited_out(aecp):
    aecp.start(write_s=2.0)

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        goal = GoalContext("2")
        await driver.export(goal, shot=shot, file="a.csv")
        return goal.files["file"].data

    assert len(aecp.play(story).splitlines()) == CHANNELS + 1


def test_an_export_that_is_asked_for_again_is_not_made_again(aecp):
    aecp.start()

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        goals = [GoalContext("2"), GoalContext("3")]
        await driver.export(goals[0], shot=shot, file="a.csv")
        aecp.end()
        await driver.export(goals[1], shot=shot, file="b.csv")
        return [g.files["file"] for g in goals]

    first, second = aecp.play(story)

    assert (first.path, second.path) == ("a.csv", "b.csv")
    assert first.data == second.data


@pytest.mark.parametrize(
    ("plan", "error", "happened", "words", "shots"),
    [
        ("not_found", "ButtonNotFound", "no", "The button measure was not found.", 0),
        ("too_long", "Timeout", "unknown", "The operation takes too long.", 0),
        ("too_long_fired", "Timeout", "unknown", "The operation takes too long.", 1),
        ("die", "Lost", "unknown", "the connection broke before an answer came", 1),
        ("die_before", "Lost", "unknown", "the connection broke before an answer came", 0),
        ("mute", "Lost", "unknown", "no answer came within 2 s", 1),
    ],
)
def test_what_is_known_of_a_shot_when_its_cache_cannot_be_seen(
    aecp, plan, error, happened, words, shots
):
    aecp.start(plans={"measure": [plan]})

    async def story(driver):
        failure = await failing(driver.measure, GoalContext("g"))
        return failure, await driver.last_shot(GoalContext("p"))

    failure, last = aecp.play(story, measure_s=2)

    assert (failure.name, failure.happened) == (error, happened)
    assert words in failure.message
    assert (
        f"libs (analyser server http://127.0.0.1:{aecp.port}), asked to measure" in failure.message
    )
    assert last == {"shot_id": None, "goal_id": None}
    assert aecp.shots() == shots


@pytest.mark.parametrize("plan", ["too_long_fired", "die", "mute"])
def test_a_shot_whose_answer_was_lost_is_found_in_the_cache(aecp, plan):
    aecp.start(plans={"measure": [plan]})

    async def story(driver):
        result = await driver.measure(GoalContext("g"))
        return result, await driver.last_shot(GoalContext("p"))

    result, last = aecp.play(story, cache=aecp.cache, measure_s=2)

    assert result == {"shot_id": "shot-000001"}
    assert last == {"shot_id": "shot-000001", "goal_id": "g"}
    assert aecp.shots() == 1


def test_an_answer_that_comes_late_is_believed(aecp):
    aecp.start(plans={"measure": ["late"]})

    assert aecp.play(lambda d: d.measure(GoalContext("g")), measure_s=2.2) == {
        "shot_id": "shot-000001"
    }


def test_a_shot_that_a_stop_broke_off_is_known_when_its_answer_has_come(aecp):
    aecp.start(plans={"measure": ["late"]})

    async def story(driver):
        shot = asyncio.create_task(driver.measure(GoalContext("g")))
        await asyncio.sleep(0.8)
        shot.cancel()
        await asyncio.gather(shot, return_exceptions=True)
        return await driver.last_shot(GoalContext("p"))

    assert aecp.play(story) == {"shot_id": "shot-000001", "goal_id": "g"}


def test_a_deleted_entry_that_the_server_takes_for_a_shot_is_none(aecp):
    aecp.start(plans={"measure": ["ok", "vanish"]})

    async def story(driver):
        await driver.measure(GoalContext("1"))
        return await failing(driver.measure, GoalContext("2"))

    failure = aecp.play(story, cache=aecp.cache)

    assert (failure.name, failure.happened) == ("Lost", "unknown")
    assert "it reports success, but" in failure.message
    assert aecp.shots() == 1


def test_two_new_entries_for_one_click_are_told(aecp):
    aecp.start(plans={"measure": ["stray"]})

    failure = aecp.play(lambda d: failing(d.measure, GoalContext("1")), cache=aecp.cache)

    assert (failure.name, failure.happened) == ("Lost", "yes")
    assert "one is from another click" in failure.message


def test_busy_means_that_nothing_was_clicked(aecp):
    aecp.start(shot_s=1.5)

    async def story(driver):
        first = asyncio.create_task(driver.measure(GoalContext("1")))
        await asyncio.sleep(0.5)
        second = await failing(driver.measure, GoalContext("2"))
        return await first, second, await driver.last_shot(GoalContext("p"))

    first, second, last = aecp.play(story)

    assert (second.name, second.happened) == ("Busy", "no")
    assert last["goal_id"] == "1"
    assert (first["shot_id"], aecp.shots()) == ("shot-000001", 1)


def test_reconnect_waits_for_the_new_connection_whatever_the_old_one_still_says(aecp):
    aecp.start(tell_s=0.001)

    async def story(driver):
        shots = []
        for n in range(2):
            await driver.reconnect(GoalContext(f"r{n}"))
            shots.append((await driver.measure(GoalContext(f"m{n}")))["shot_id"])
        return shots

    assert aecp.play(story) == ["shot-000001", "shot-000002"]


def test_reconnect_goes_on_when_the_new_connection_breaks_at_once(aecp):
    aecp.start(drops=[2])

    async def story(driver):
        await driver.reconnect(GoalContext("r"))
        return await driver.measure(GoalContext("m"))

    assert aecp.play(story) == {"shot_id": "shot-000001"}


def test_after_a_restart_of_the_server_it_goes_on(aecp):
    aecp.start(plans={"measure": ["die"]})

    async def story(driver):
        await failing(driver.measure, GoalContext("1"))
        refused = await failing(driver.measure, GoalContext("2"))
        await aecp.again()
        await driver.reconnect(GoalContext("3"))
        return refused, await driver.measure(GoalContext("4"))

    refused, again = aecp.play(story)

    assert (refused.name, refused.happened) == ("Rejected", "no")
    assert "nothing was sent" in refused.message
    assert again == {"shot_id": "shot-000003"}
    assert aecp.shots() == 2


def test_the_same_goal_is_never_sent_twice(aecp):
    aecp.start()

    async def story(driver):
        await driver.measure(GoalContext("g"))
        return await failing(driver.measure, GoalContext("g"))

    failure = aecp.play(story)

    assert failure.happened == "unknown"
    assert aecp.shots() == 1


@pytest.mark.parametrize(
    ("plan", "error", "words"),
    [
        ("not_found", "ButtonNotFound", "The button export was not found."),
        ("too_long", "Timeout", "there is nothing new"),
        ("half", "Timeout", "it ends within line"),
        ("full", "DiskFull", "No space left on device"),
        ("twins", "Rejected", "wrote 2 spectra that were never seen before"),
    ],
)
def test_an_export_that_is_not_whole_is_never_handed_over(aecp, plan, error, words):
    aecp.start(plans={"export": [plan]})

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        goal = GoalContext("2")
        return await failing(driver.export, goal, shot=shot, file="a.csv"), goal.files

    failure, files = aecp.play(story, export_s=3)

    assert failure.name == error
    assert words in failure.message
    assert files == {}


def test_a_spectrum_cut_at_the_end_of_a_line_lacks_channels(aecp):
    aecp.start()

    async def story(driver):
        first = (await driver.measure(GoalContext("1")))["shot_id"]
        await driver.export(GoalContext("2"), shot=first, file="a.csv")
        aecp.end()
        aecp.start(channels=1500)
        await driver.reconnect(GoalContext("3"))
        second = (await driver.measure(GoalContext("4")))["shot_id"]
        return await failing(driver.export, GoalContext("5"), shot=second, file="b.csv")

    failure = aecp.play(story, export_s=3)

    assert "has 1500 of 2000 channels" in failure.message


def test_an_export_whose_answer_was_lost_is_found_in_the_folder(aecp):
    aecp.start(plans={"export": ["die"]})

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        goal = GoalContext("2")
        await driver.export(goal, shot=shot, file="a.csv")
        return goal.files["file"].data

    assert len(aecp.play(story).splitlines()) == CHANNELS + 1


def test_an_export_that_came_after_it_was_given_up_is_taken_and_not_asked_for_again(aecp):
    aecp.start(write_s=4.0)

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        first = await failing(driver.export, GoalContext("2"), shot=shot, file="a.csv")
        await asyncio.sleep(3)
        goal = GoalContext("3")
        await driver.export(goal, shot=shot, file="a.csv")
        return first, goal.files["file"].data

    first, data = aecp.play(story, export_s=2)

    assert first.name == "Timeout"
    assert len(data.splitlines()) == CHANNELS + 1
    assert len(list((aecp.folder / "exports").iterdir())) == 1


def test_the_spectrum_of_another_shot_is_not_taken_for_this_one(aecp):
    aecp.start(plans={"export": ["ok", "same"]})

    async def story(driver):
        first = (await driver.measure(GoalContext("1")))["shot_id"]
        await driver.export(GoalContext("2"), shot=first, file="a.csv")
        second = (await driver.measure(GoalContext("3")))["shot_id"]
        return await failing(driver.export, GoalContext("4"), shot=second, file="b.csv")

    assert "wrote the spectrum of shot-000001 again" in aecp.play(story).message


def test_a_shot_that_was_passed_over_is_not_filed_as_the_next_one(aecp):
    aecp.start(plans={"export": ["list"]})

    async def story(driver):
        await driver.measure(GoalContext("1"))
        second = (await driver.measure(GoalContext("2")))["shot_id"]
        refused = await failing(driver.export, GoalContext("3"), shot=second, file="a.csv")
        third = (await driver.measure(GoalContext("4")))["shot_id"]
        await driver.export(GoalContext("5"), shot=third, file="b.csv")
        return refused

    refused = aecp.play(story)

    assert (refused.name, refused.happened) == ("Rejected", "unknown")
    assert "shot-000001 may be among them and was never exported" in refused.message
    assert len(list((aecp.folder / "mine" / "quarantine").rglob("*.csv"))) == 2


@pytest.mark.parametrize("plan", ["stray", "stray_folder"])
def test_what_does_not_bear_the_time_of_the_request_is_not_taken(aecp, plan):
    aecp.start(plans={"export": [plan]})

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        goal = GoalContext("2")
        await driver.export(goal, shot=shot, file="a.csv")
        return goal.files["file"].data

    data = aecp.play(story)
    (own,) = (aecp.folder / "exports").glob(time.strftime("%Y_*/*_1.csv"))

    assert data == own.read_bytes()


def test_after_three_spectra_lost_in_a_row_nothing_is_fired_until_somebody_has_looked(aecp):
    aecp.start(plans={"export": ["half"] * 3})

    async def story(driver):
        for n in range(3):
            shot = (await driver.measure(GoalContext(f"m{n}")))["shot_id"]
            await failing(driver.export, GoalContext(f"e{n}"), shot=shot, file="a.csv")
        refused = await failing(driver.measure, GoalContext("m3"))
        await driver.reconnect(GoalContext("r"))
        return refused, await driver.measure(GoalContext("m4"))

    refused, after = aecp.play(story, export_s=2, cache=aecp.cache)

    assert (refused.name, refused.happened) == ("Rejected", "no")
    assert "shot-000001, shot-000002, shot-000003 did not arrive whole" in refused.message
    assert (after, aecp.shots()) == ({"shot_id": "shot-000004"}, 4)


def test_names_in_which_the_server_types_one_time_into_another_are_read(aecp):
    name = "2026_12026_11_23_06_07_162026_11_23_06_07_071_23_06_06_59"

    assert [time.strftime("%M %S", time.localtime(t)) for t in times_in(name)] == ["07 16", "07 07"]
    assert times_in("2026_13_23_06_07_16 other_1") == []


def test_a_clock_that_is_off_is_told_with_what_to_write(aecp):
    aecp.start(clock_s=-90)

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        return await failing(driver.export, GoalContext("2"), shot=shot, file="a.csv")

    first = aecp.play(story, export_s=3)

    async def again(driver):
        await driver.export(GoalContext("3"), shot="shot-000001", file="a.csv")

    assert re.search(r"begun -\d\d s from the request.*write `clock_s: -(89|90|91)`", first.message)
    aecp.play(again, clock_s=-90)


def test_a_shot_that_was_passed_over_cannot_be_exported_any_more(aecp):
    aecp.start()

    async def story(driver):
        first = (await driver.measure(GoalContext("1")))["shot_id"]
        await driver.measure(GoalContext("2"))
        passed = await failing(driver.export, GoalContext("3"), shot=first, file="a.csv")
        never = await failing(driver.export, GoalContext("4"), shot="shot-9", file="a.csv")
        return passed, never

    passed, never = aecp.play(story)

    assert (passed.name, never.name) == ("UnknownShot", "UnknownShot")
    assert "exports its newest shot only" in passed.message


def test_an_export_folder_can_be_read_over_http(aecp):
    aecp.start(write_s=1.0)
    (aecp.folder / "exports").mkdir(exist_ok=True)
    serve = partial(Quiet, directory=str(aecp.folder / "exports"))
    with ThreadingHTTPServer(("127.0.0.1", 0), serve) as web:
        thread = threading.Thread(target=web.serve_forever)
        thread.start()

        async def story(driver):
            shot = (await driver.measure(GoalContext("1")))["shot_id"]
            goal = GoalContext("2")
            await driver.export(goal, shot=shot, file="a.csv")
            return goal.files["file"].data

        try:
            data = aecp.play(story, exports=f"http://127.0.0.1:{web.server_port}/")
        finally:
            web.shutdown()
            thread.join()

    assert len(data.splitlines()) == CHANNELS + 1


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        """Nothing: the test's output is its own."""


@pytest.mark.parametrize(
    ("plan", "words"),
    [("same_place", "two buttons at 100,80"), ("crash", "no answer came within 2 s")],
)
def test_buttons_that_are_not_there_are_told(aecp, plan, words):
    aecp.start(plans={"find_buttons": [plan]})

    failure = aecp.play(lambda d: failing(d.locate, GoalContext("1")), locate_s=2)

    assert failure.name == "ButtonNotFound"
    assert words in failure.message


def test_while_the_server_is_blocked_by_its_search_the_driver_waits(aecp):
    aecp.start(find_s=4.0)

    async def story(driver):
        await driver.locate(GoalContext("1"))
        await driver.disarm(GoalContext("2"))
        return await driver.measure(GoalContext("3"))

    assert aecp.play(story, locate_s=10) == {"shot_id": "shot-000001"}


def test_the_server_is_told_where_to_export(aecp):
    aecp.start()
    other = aecp.folder / "other"
    other.mkdir()

    async def story(driver):
        shot = (await driver.measure(GoalContext("1")))["shot_id"]
        await driver.export(GoalContext("2"), shot=shot, file="a.csv")

    aecp.play(story, exports=str(other), export_path=str(other))

    assert len(list(other.iterdir())) == 1


def test_it_is_not_safe_while_the_server_is_silent(aecp):
    aecp.start()

    async def story(driver):
        await driver.safe()
        aecp.end()
        await asyncio.sleep(0.5)
        return await failing(driver.disarm, GoalContext("1"))

    assert "use the switch on the analyser" in aecp.play(story).message


def test_its_status_counts_shots(aecp):
    aecp.start()

    async def story(driver):
        await driver.measure(GoalContext("1"))
        return await driver.status()

    assert aecp.play(story) == {"armed": False, "shots": 1, "interlock": "unknown"}
