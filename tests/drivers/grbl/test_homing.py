"""Homing: silent until it is done, and an `ok` after an alarm is no success."""

import asyncio

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext


def test_homing_makes_the_place_known(peer, gantry, played):
    async def story(driver):
        return await driver.status()

    status = played(gantry(peer), story)

    assert (status["state"], status["homed"], status["alarm"]) == ("idle", True, "")
    assert (status["x"], status["y"], status["z"]) == pytest.approx((0, 0, 85), abs=0.006)


def test_while_it_homes_it_is_not_asked_and_says_so(peers, gantry, played):
    peer = peers(speed=10, homing_s=16.6)

    async def story(driver):
        homing = asyncio.create_task(driver.home(GoalContext("h")))
        await asyncio.sleep(0.3)
        asked = peer.heard.count("?")
        status = await driver.status()
        assert peer.heard.count("?") == asked
        await homing
        return status

    status = played(gantry(peer), story, homed=False)

    assert (status["state"], status["homed"]) == ("homing", False)


@pytest.mark.parametrize("hal", [False, True])
@pytest.mark.parametrize(
    ("code", "words", "went"),
    [(9, "did not find the limit switch", 135.0), (8, "could not get off the limit switch", -5.0)],
)
def test_a_switch_that_is_not_found_or_is_stuck_fails_homing_until_it_is_mended(
    peers, gantry, played, code, words, went, hal
):
    peer = peers(hal=hal)  # GRBL itself says `ok` after the alarm
    peer.homing_fails = code

    async def story(driver):
        with pytest.raises(ActionFailed, match=rf"HomingFailed: .*ALARM:{code}: homing {words}"):
            await driver.home(GoalContext("h"))
        failed, place = await driver.status(), peer.place[2]
        peer.homing_fails = 0
        await driver.home(GoalContext("again"))
        return failed, place, await driver.status()

    failed, place, after = played(gantry(peer), story, homed=False)

    assert (failed["state"], failed["homed"]) == ("alarm", False) and "z" not in failed
    assert place == pytest.approx(went, abs=0.005)
    assert (after["state"], after["homed"], after["alarm"]) == ("idle", True, "")


def test_homing_that_is_switched_off_says_how_to_go_on(peers, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed, match=r"error:5 \(homing is off.*home_here"):
            await driver.home(GoalContext("h"))

    played(gantry(peers(settings={22: 0})), story, homed=False)


@pytest.mark.parametrize(("way", "aborts_as"), [("cancel", 8), ("safe", 6), ("hold", 9)])
def test_homing_can_be_broken_off_and_the_place_is_then_unknown(
    peers, gantry, played, way, aborts_as
):
    peer = peers(speed=4, homing_s=16.6)
    peer.aborts_as = aborts_as

    async def story(driver):
        goal = GoalContext("h")
        homing = asyncio.create_task(driver.home(goal))
        await asyncio.sleep(0.3)
        if way == "cancel":
            goal.cancelled.set()
        elif way == "hold":
            await driver.hold(GoalContext("hold"))
        else:
            await driver.safe()
        with pytest.raises((ActionCanceled, ActionFailed)) as ended:
            await homing
        async with asyncio.timeout(500):
            while driver.controller.dead:  # noqa: ASYNC110 - the recovery tells nobody
                await asyncio.sleep(0.02)
        return type(ended.value), await driver.status()

    kind, status = played(gantry(peer), story, homed=False)

    assert kind is (ActionCanceled if way == "cancel" else ActionFailed)
    assert (status["state"], status["homed"]) == ("alarm", False)
    assert "ALARM:6" in status["alarm"]


def test_homing_that_does_not_end_is_ended(peers, gantry, played):
    peer = peers(speed=2, homing_s=16.6)

    async def story(driver):
        with pytest.raises(ActionFailed, match=r"did not end within 0.4 s and was reset"):
            await driver.home(GoalContext("h"))

    played(gantry(peer, homing_timeout=0.4), story, homed=False)

    assert peer.homing_until is None


def test_a_hold_that_was_left_does_not_keep_homing_waiting(peer, gantry, played):
    async def story(driver):
        driver.controller.write(b"!")
        await asyncio.sleep(0.1)
        await driver.home(GoalContext("h"))
        return await driver.status()

    assert played(gantry(peer), story)["homed"]
