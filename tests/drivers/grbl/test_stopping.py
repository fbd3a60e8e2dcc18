"""A stop brakes first and resets then: it ends soon, and says whether the place can be trusted."""

import asyncio

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.grbl import motion, stopping


async def moving(driver, **wanted):
    """A move that is under way."""
    move = asyncio.create_task(driver.move_to(GoalContext("m"), **wanted))
    await asyncio.sleep(0.3)
    return move


def test_safe_stops_a_move_without_losing_the_place(peers, gantry, played):
    peer = peers(speed=4)

    async def story(driver):
        move = await moving(driver, x=300)
        await driver.safe()
        stood = list(peer.steps)
        assert peer.move is None
        with pytest.raises(ActionFailed, match="Alarm: a stop ended the motion of gantry") as ended:
            await move
        await asyncio.sleep(0.1)
        assert peer.steps == stood
        return ended.value.happened, await driver.status()

    happened, status = played(gantry(peer), story)

    assert happened == "yes"
    assert (status["state"], status["homed"]) == ("idle", True)
    assert peer.place[0] + 805 == pytest.approx(status["x"], abs=0.005)


def test_a_move_that_halt_has_ended_says_so_though_its_proof_is_answered_by_the_reset(
    peers, gantry, played, monkeypatch
):
    peer = peers(speed=4)
    monkeypatch.setattr(motion, "POLL_S", 5.0)  # the answer comes first

    async def story(driver):
        move = await moving(driver, x=300)
        await driver.halt(GoalContext("halt"))
        with pytest.raises(ActionFailed, match="Alarm: a stop ended the motion of gantry") as ended:
            await move
        return ended.value.happened, await driver.status()

    happened, status = played(gantry(peer), story)

    assert happened == "yes"
    assert (status["state"], status["homed"]) == ("idle", True)


def test_safe_where_nothing_moves_changes_nothing(peer, gantry, played, monkeypatch):
    monkeypatch.setattr(stopping, "LOOK_S", 60)  # one that does not report in time is stopped

    async def story(driver):
        await driver.safe()
        return await driver.status()

    assert played(gantry(peer), story)["homed"]
    assert "18" not in peer.heard and "!" not in peer.heard


def test_a_stop_and_a_cancel_at_once_are_one_stop(peers, gantry, played):
    peer = peers(speed=4)

    async def story(driver):
        goal = GoalContext("m")
        move = asyncio.create_task(driver.move_to(goal, x=300))
        await asyncio.sleep(0.3)
        goal.cancelled.set()
        await asyncio.gather(driver.safe(), driver.safe())
        await asyncio.gather(move, return_exceptions=True)
        return await driver.status()

    status = played(gantry(peer), story)

    assert status["homed"]
    assert not peer.queue and peer.move is None


@pytest.mark.slow
def test_a_reset_in_mid_motion_loses_the_trust(peers, gantry, played):
    peer = peers(speed=1, settings={120: 10.0, 121: 10.0, 122: 10.0})  # it brakes for 4 s

    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("m"), x=300))
        await asyncio.sleep(3)
        await driver.safe()
        with pytest.raises(ActionFailed):
            await move
        return await driver.status()

    status = played(gantry(peer), story)

    assert (status["state"], status["homed"]) == ("alarm", False)
    assert "ALARM:3" in status["alarm"]


def test_a_task_that_is_broken_off_leaves_nothing_moving(peers, gantry, played):
    peer = peers(speed=2)

    async def story(driver):
        move = await moving(driver, x=300)
        move.cancel()
        await asyncio.gather(move, return_exceptions=True)
        await asyncio.sleep(0.2)
        return await driver.status()

    status = played(gantry(peer), story)

    assert peer.move is None
    assert not status["homed"]


def test_safe_right_after_an_alarm_waits_until_the_controller_answers_again(peer, gantry, played):
    async def story(driver):
        peer._alarm(1)
        async with asyncio.timeout(500):
            await driver.controller.until(lambda: driver.controller.dead, 5)
        await driver.safe()
        return driver.controller.dead

    assert played(gantry(peer), story) is False


def test_a_halt_while_the_door_is_open_keeps_the_place(peers, gantry, played):
    peer = peers(speed=5)

    async def story(driver):
        move = asyncio.ensure_future(driver.move_to(GoalContext("a"), x=60, feed=1200))
        await driver.controller.until(lambda: peer.place[0] > -800, 500)
        driver.controller.write(b"\x84")
        await driver.controller.until(lambda: driver.controller.report.state == "Door", 500)
        await driver.halt(GoalContext("b"))
        with pytest.raises(ActionFailed, match="a stop ended the motion"):
            await move
        return await driver.move_to(GoalContext("c"), x=1)

    assert played(gantry(peer), story, homed=True)["x"] == pytest.approx(1, abs=0.01)
