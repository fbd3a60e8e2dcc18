"""A jog by a distance ends there; a held one ends with the hold, at the edge, or with its goal."""

import asyncio
import math
import time

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.drivers.grbl.controller import HOLD


def test_a_jog_by_a_distance(peer, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=50)
        return await driver.jog(GoalContext("b"), axis="x", distance=-1.5, feed=900)

    assert played(gantry(peer), story)["x"] == pytest.approx(48.5, abs=0.01)
    assert "$J=G21G91X-1.5000F900.000" in peer.heard


def test_a_diagonal_jog_is_one_line_and_goes_as_far_along_each(peer, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=50, y=50)
        place = await driver.jog(GoalContext("b"), way="+x-y", distance=2, feed=900)
        with pytest.raises(ActionFailed, match=r"SoftLimit: .*z 99.* is outside 0 to 85"):
            await driver.jog(GoalContext("c"), way="+x+z", distance=15)
        with pytest.raises(ActionFailed, match=r"Rejected: .*'\+x-x' names an axis twice"):
            await driver.jog(GoalContext("d"), way="+x-x", distance=1)
        return place

    place = played(gantry(peer, axes={"x": "Y", "y": "-X"}), story)

    assert (place["x"], place["y"]) == pytest.approx((52, 48), abs=0.01)
    assert "$J=G21G91Y2.0000X2.0000F900.000" in peer.heard


@pytest.mark.parametrize("who", ["its button", "hold"])
def test_a_jog_that_a_feed_hold_ends_did_not_go_all_the_way(peers, gantry, played, who):
    peer = peers(speed=2)

    async def story(driver):
        jog = asyncio.ensure_future(driver.jog(GoalContext("a"), axis="x", distance=60, feed=1200))
        await driver.controller.until(lambda: peer.place[0] > -800, 500)
        if who == "hold":
            await driver.hold(GoalContext("b"))
        else:
            driver.controller.write(b"!")
        with pytest.raises(ActionFailed) as failed:
            await jog
        return failed.value, await driver.status()

    fault, status = played(gantry(peer), story, homed=True)

    assert status["homed"] and status["x"] < 60
    words = "a stop ended the motion" if who == "hold" else "a feed hold or an open door"
    assert words in str(fault)


def test_a_jog_that_a_reset_ends_is_told_as_the_alarm(peers, gantry, played):
    peer = peers(speed=2)

    async def story(driver):
        jog = asyncio.ensure_future(driver.jog(GoalContext("a"), axis="x", distance=60, feed=1200))
        await driver.controller.until(lambda: peer.place[0] > -800, 500)
        driver.controller.port.write(b"\x18")
        with pytest.raises(ActionFailed, match=r"it answered ALARM:3"):
            await jog

    played(gantry(peer), story, homed=True)


@pytest.mark.parametrize("way", [{"distance": 5}, {"direction": "+"}])
def test_whether_a_jog_that_could_not_be_seen_to_end_has_moved_is_unknown(
    peer, gantry, played, way
):
    async def story(driver):
        peer.refuses["G4P0"] = 9
        with pytest.raises(ActionFailed, match=r"asked whether all motion has ended") as failed:
            await driver.jog(GoalContext("a"), axis="x", feed=1200, **way)
        return failed.value.happened

    assert played(gantry(peer), story, homed=True) == "unknown"


def test_a_jog_out_of_the_work_area_is_refused_before_it_is_sent(peer, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed, match=r"SoftLimit: .*z 99.* is outside 0 to 85"):
            await driver.jog(GoalContext("b"), axis="z", distance=15)

    played(gantry(peer), story)

    assert not any(line.startswith("$J") for line in peer.heard)


def test_a_jog_whose_goal_is_not_sent_again_ends_with_its_lease(peers, gantry, played):
    peer = peers(speed=1)

    async def story(driver):
        return await driver.jog(GoalContext("a"), axis="x", direction="+", feed=1200, lease=0.3)

    place = played(gantry(peer), story, homed=True)

    # 20 mm/s for 0.3 s and the way of braking
    assert 1 < place["x"] < 20
    assert peer.move is None and not peer.queue


def test_a_jog_goes_on_as_long_as_its_goal_is_sent_again(peers, gantry, played):
    peer = peers(speed=1)

    async def story(driver):
        goal = GoalContext("a")
        jog = asyncio.create_task(driver.jog(goal, axis="x", direction="+", feed=1200, lease=0.3))
        goal.wanted_at = math.inf  # as if it were sent again all the time
        while (held := (await driver.status())["x"]) <= 10 and not jog.done():  # noqa: ASYNC110 - a clock moves it
            await asyncio.sleep(0.05)
        goal.wanted_at = time.monotonic()
        return held, await jog

    held, place = played(gantry(peer), story)

    assert held > 10
    assert held <= place["x"] < held + 25


def test_a_held_jog_that_a_feed_hold_has_ended_ends_where_it_stands(peers, gantry, played):
    async def story(driver):
        goal = GoalContext("a", wanted_at=math.inf)
        jog = asyncio.create_task(driver.jog(goal, axis="x", direction="+", feed=1200))
        while (await driver.status())["x"] <= 2 and not jog.done():  # noqa: ASYNC110 - a clock moves it
            await asyncio.sleep(0.05)
        driver.controller.write(HOLD)
        return await jog, await driver.status()

    place, status = played(gantry(peers(speed=1)), story, homed=True)

    assert place["x"] > 2
    assert (status["homed"], status["state"], status["x"]) == (True, "idle", place["x"])


def test_a_held_jog_stops_at_the_edge_of_the_work_area(peers, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), y=700)
        return await driver.jog(GoalContext("b"), axis="y", direction="+", feed=2500, lease=2.0)

    assert played(gantry(peers(speed=40)), story)["y"] == pytest.approx(725, abs=0.02)


def test_a_held_diagonal_jog_stops_at_the_first_edge(peers, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=100, y=710)
        return await driver.jog(GoalContext("b"), way="-x+y", feed=2500, lease=2.0)

    place = played(gantry(peers(speed=40)), story)

    assert (place["x"], place["y"]) == pytest.approx((85, 725), abs=0.02)


def test_a_held_jog_of_a_turned_axis_goes_the_benchs_way(peers, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), y=100)
        return await driver.jog(GoalContext("b"), axis="y", direction="-", feed=600, lease=2.0)

    assert played(gantry(peers(), axes={"x": "Y", "y": "-X"}), story)["y"] < 100


def test_a_cancel_ends_a_held_jog(peers, gantry, played):
    peer = peers(speed=1)

    async def story(driver):
        goal = GoalContext("a")
        jog = asyncio.create_task(driver.jog(goal, axis="x", direction="+", lease=2.0))
        await asyncio.sleep(0.4)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await jog
        return await driver.status()

    status = played(gantry(peer), story)

    assert (status["state"], status["homed"]) == ("idle", True)
    assert "85" in peer.heard and peer.move is None


def test_what_feeds_a_held_jog_may_die_and_the_axis_stops_by_itself(peers, gantry, played):
    peer = peers(speed=1)

    async def story(driver):
        jog = asyncio.create_task(
            driver.jog(GoalContext("a"), axis="x", direction="+", feed=1200, lease=2.0)
        )
        await asyncio.sleep(0.6)
        driver.controller.write = lambda data: None  # nothing reaches the port any more
        driver.controller.port.write = lambda data: None
        await asyncio.sleep(1.5)
        still = list(peer.steps)
        await asyncio.sleep(0.2)
        jog.cancel()
        await asyncio.gather(jog, return_exceptions=True)
        return still

    assert played(gantry(peer), story) == peer.steps
    assert peer.move is None


def test_before_homing_a_jog_only_creeps(peer, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed, match=r"NotHomed: .*locked until it is homed or unlocked"):
            await driver.jog(GoalContext("a"), axis="x", distance=-1)
        await driver.unlock(GoalContext("b"))
        with pytest.raises(ActionFailed, match="until then a jog goes 10 mm at most"):
            await driver.jog(GoalContext("c"), axis="x", distance=-11)
        return await driver.jog(GoalContext("d"), axis="x", distance=-5, feed=2000)

    played(gantry(peer), story, homed=False)

    assert "$J=G21G91X-5.0000F300.000" in peer.heard
