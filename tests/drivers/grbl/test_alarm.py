"""Alarms: named in words, waited out, never unlocked by themselves."""

import asyncio

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.grbl import alarm


async def until(driver, true):
    """The first status that is so."""
    async with asyncio.timeout(500):
        while not true(status := await driver.status()):  # noqa: ASYNC110 - it has to be asked
            await asyncio.sleep(0.02)
    return status


def test_a_limit_switch_hit_in_mid_move_locks_it_until_somebody_unlocks_and_homes(
    peer, gantry, played
):
    peer.hit_at = -700

    async def story(driver):
        with pytest.raises(
            ActionFailed, match=r"`G21.*`\); it answered ALARM:1: a limit sw"
        ) as hit:
            await driver.move_to(GoalContext("a"), x=200)
        locked = await until(driver, lambda s: not driver.controller.dead)
        with pytest.raises(ActionFailed, match="was not moved: ALARM:1"):
            await driver.move_to(GoalContext("b"), x=1)
        await driver.unlock(GoalContext("c"))
        unlocked = await driver.status()
        with pytest.raises(ActionFailed, match="NotHomed"):
            await driver.move_to(GoalContext("d"), x=1)
        peer.hit_at = None
        await driver.jog(GoalContext("e"), axis="x", distance=-5)
        await driver.home(GoalContext("f"))
        return hit.value.happened, locked, unlocked, await driver.move_to(GoalContext("g"), x=1)

    happened, locked, unlocked, place = played(gantry(peer), story)

    assert happened == "unknown"
    assert (locked["state"], locked["homed"]) == ("alarm", False)
    assert (unlocked["state"], unlocked["homed"], unlocked["alarm"]) == ("idle", False, "")
    assert place["x"] == pytest.approx(1, abs=0.005)


def test_the_reset_after_a_limit_waits_until_it_is_not_swallowed(peers, gantry, played):
    peer = peers(speed=2)
    peer.hit_at = -804

    async def story(driver):
        with pytest.raises(ActionFailed, match="ALARM:1"):
            await driver.move_to(GoalContext("a"), x=20)
        await until(driver, lambda s: not driver.controller.dead)

    played(gantry(peer), story)

    assert peer.heard.count("18") == 1


def test_a_soft_limit_of_the_controller_is_an_alarm_too(peers, gantry, played):
    peer = peers(settings={20: 1, 130: 300.0})
    driver = gantry(peer)

    async def story(driver):
        driver.bench = type(driver.bench)(
            (0, 1, 2), (1, 1, 1), (-295.0, -725.0, -90.0), (0, 0, 0), (730, 725, 85)
        )
        peer.settings[130] = 250.0  # by another program
        with pytest.raises(
            ActionFailed, match="ALARM:2: a move would have left the machine's"
        ) as no:
            await driver.move_to(GoalContext("a"), x=400)
        return no.value, await driver.status()

    fault, status = played(driver, story)

    assert fault.happened == "no"
    assert status["alarm"] in str(fault)
    assert status["alarm"].endswith("has changed $130 from 300 to 250, and homing reads it")


def test_an_alarm_while_it_stands_is_seen(peer, gantry, played):
    async def story(driver):
        peer._alarm(1)
        return await until(driver, lambda s: s["state"] == "alarm" and not driver.controller.dead)

    status = played(gantry(peer), story)

    assert "a limit switch was hit" in status["alarm"]
    assert not status["homed"]


def test_a_reset_button_in_mid_move_is_told_and_the_place_is_no_longer_trusted(
    peers, gantry, played
):
    peer = peers(speed=2)

    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=100))
        await asyncio.sleep(0.3)
        peer._power_on()
        with pytest.raises(ActionFailed, match=r"Alarm: .*it restarted: `Grbl 1.1h`"):
            await move
        return await driver.status()

    status = played(gantry(peer), story)

    assert (status["state"], status["homed"]) == ("alarm", False)
    assert "restarted unexpectedly (reset button, emergency stop" in status["alarm"]


@pytest.mark.slow
def test_a_controller_that_falls_silent_in_mid_move_is_told_to_stop_and_that_is_said(
    peers, gantry, played
):
    peer = peers(speed=1)

    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=400))
        await asyncio.sleep(0.3)
        peer.silent = True
        with pytest.raises(ActionFailed, match=r"Alarm: .*it fell silent for 2.5 s"):
            await move
        status = await driver.status()
        peer.silent = False
        return status

    status = played(gantry(peer), story)

    assert not status["homed"]
    assert "may still move" in status["alarm"]


@pytest.mark.soak
def test_a_move_that_stands_short_of_its_target_is_stopped_and_can_be_repeated(
    peer, gantry, played
):
    async def story(driver):
        peer.runs_dry_at = -700
        with pytest.raises(ActionFailed, match=r"Idle, but never answered `G4P0`; it is stopped: "):
            await driver.move_to(GoalContext("a"), x=200)
        short = await driver.status()
        return short, peer.place[0], await driver.move_to(GoalContext("b"), x=200)

    short, true, place = played(gantry(peer), story)

    assert short["homed"]
    assert short["x"] < 150 and short["x"] == pytest.approx(true + 805, abs=0.01)
    assert place["x"] == pytest.approx(200, abs=0.005)


def test_a_controller_that_answers_nothing_while_it_stands_is_offline_until_it_does(
    peer, gantry, played
):
    async def story(driver):
        peer.silent = True
        gone = await until(driver, lambda s: s["state"] == "offline")
        with pytest.raises(ActionFailed, match=r"Offline: .*it did not respond to `\?`") as refused:
            await driver.move_to(GoalContext("a"), x=3)
        peer.silent = False
        await until(driver, lambda s: s["state"] == "idle")
        return gone, refused.value.happened, await driver.move_to(GoalContext("b"), x=3)

    gone, happened, place = played(gantry(peer), story)

    assert "it did not respond to `?`" in gone["alarm"]
    assert happened == "no"
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_unplugged_in_mid_move_it_is_unknown_and_comes_back_by_itself(peers, gantry, played):
    peer = peers(speed=2)

    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=100))
        await asyncio.sleep(0.3)
        peer.unplug()
        with pytest.raises(ActionFailed, match=r"Alarm: .*asked to move to x 100 mm") as pulled:
            await move
        gone = await driver.status()
        with pytest.raises(ActionFailed, match=r"Offline: .*was unplugged or is gone") as offline:
            await driver.move_to(GoalContext("b"), x=1)
        with pytest.raises(OSError, match="cannot be stopped"):
            await driver.safe()
        peer.plug()
        back = await until(driver, lambda s: s["state"] == "alarm")
        await driver.home(GoalContext("c"))
        return pulled.value, gone, offline.value, back, await driver.move_to(GoalContext("d"), x=2)

    pulled, gone, offline, back, place = played(gantry(peer), story)

    assert pulled.happened == "unknown" and "was unplugged or is gone" in pulled.message
    assert gone["state"] == "offline"
    assert offline.happened == "no"
    assert not back["homed"] and "is back. Home it" in back["alarm"]
    assert place["x"] == pytest.approx(2, abs=0.005)


def test_the_emergency_stop_takes_the_power_and_gives_it_back(peers, gantry, played):
    peer = peers(speed=2)

    async def story(driver):
        peer._power_on()
        return await until(driver, lambda s: "restarted" in s["alarm"])

    assert not played(gantry(peer), story)["homed"]


def test_a_reset_button_that_is_held_is_named_and_unlocked_when_it_is_released(
    peers, gantry, played
):
    peer = peers(hal=True)
    peer.reset_at = -700

    async def story(driver):
        with pytest.raises(ActionFailed, match=r"ALARM:3: it was reset while it moved"):
            await driver.move_to(GoalContext("a"), x=200)
        with pytest.raises(ActionFailed, match=r"its reset button is pressed: release it") as held:
            await driver.unlock(GoalContext("b"))
        peer.reset_pressed = False
        await driver.unlock(GoalContext("c"))
        return held.value, await driver.status()

    held, unlocked = played(gantry(peer), story)

    assert held.happened == "no"
    assert (unlocked["homed"], unlocked["alarm"]) == (False, "")


@pytest.mark.slow
def test_a_pressed_emergency_stop_is_waited_for_and_unlocked_when_it_is_released(
    peers, gantry, played, monkeypatch
):
    monkeypatch.setattr(alarm, "BOOTS_S", 0.5)  # a second and a half, where nobody presses it
    peer = peers(hal=True)

    async def story(driver):
        peer.press()
        pressed = await until(driver, lambda s: "has not accepted a reset" in s["alarm"])
        with pytest.raises(ActionFailed, match=r"Alarm: .*the emergency stop is pressed"):
            await driver.unlock(GoalContext("a"))
        with pytest.raises(ActionFailed, match=r"HomingFailed: .*the emergency stop is pressed"):
            await driver.home(GoalContext("b"))
        peer.emergency = False
        await driver.unlock(GoalContext("c"))
        unlocked = await driver.status()
        await driver.home(GoalContext("d"))
        return pressed, unlocked, await driver.move_to(GoalContext("e"), x=3)

    pressed, unlocked, place = played(gantry(peer), story)

    assert pressed["state"] == "alarm" and pressed["alarm"].count("has not accepted a reset") == 1
    assert (unlocked["state"], unlocked["homed"], unlocked["alarm"]) == ("idle", False, "")
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_a_reset_button_is_an_accident_also_where_opening_the_port_boots_nothing(
    peers, gantry, played
):
    peer = peers(boots_on_open=False)

    async def story(driver):
        peer.boots_on_open = True  # from here on it says its banner
        peer._power_on()
        return await until(driver, lambda s: "restarted" in s["alarm"])

    assert not played(gantry(peer, boot_s=0.3), story)["homed"]
