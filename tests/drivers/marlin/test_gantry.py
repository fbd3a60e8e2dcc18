"""Moves through Marlin: fed in pieces, stopped where they end, sent once though an answer is lost."""

import asyncio
import math
import re

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext, Place
from labrun.drivers.grbl.gantry import Grbl
from labrun.drivers.marlin import link
from labrun.drivers.marlin.machine import read_place
from labrun.drivers.motion import fed_gantry

from ..played import played


def at(peer):
    return [round(value, 3) for value in peer.place]


@pytest.mark.parametrize(
    ("told", "place"),
    [
        ("X:5.00 Y:-20.00 Z:0.20 E:0.00 Count X:100 Y:-400 Z:10", (5.0, -20.0, 0.2)),
        ("X:5.00 Y:-20.00 Z:0.20 E:0.00 ount X:100 Y:-400 Z:10", (5.0, -20.0, 0.2)),
        ("X:5.00 :-20.00 Z:0.20 E:0.00 Count X:100 Y:-400 Z:10", None),
        ("echo:busy: processing", None),
    ],
)
def test_the_steps_in_its_answer_are_no_place(told, place):
    assert read_place([told]) == place


def test_a_stop_ends_the_move_where_its_pieces_end_and_the_position_is_still_true(peers, gantry):
    peer = peers(speed=0.25)

    async def story(driver):
        await driver.home(GoalContext("h"))
        goal = GoalContext("m")
        moving = asyncio.create_task(driver.move_to(goal, x=90))
        while peer.place[0] < 1:  # noqa: ASYNC110 - the peer is another thread's
            await asyncio.sleep(0.01)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await moving
        status = await driver.status()
        ended = peer.place[0]
        await driver.move_to(GoalContext("n"), x=20)
        return ended, status, await driver.status()

    ended, status, after = played(gantry(peer), story)

    assert 1 < ended < 60
    assert status["homed"] and status["x"] == pytest.approx(ended, abs=0.01)
    assert at(peer) == [20, 0, 100] and after["x"] == 20


@pytest.mark.slow
def test_a_hold_brakes_and_resume_goes_on(peers, gantry):
    peer = peers(speed=1)

    async def story(driver):
        await driver.home(GoalContext("h"))
        moving = asyncio.create_task(driver.move_to(GoalContext("m"), x=40))
        await asyncio.sleep(0.3)
        await driver.hold(GoalContext("o"))
        held, state = peer.place[0], (await driver.status())["state"]
        await asyncio.sleep(0.3)
        still = peer.place[0]
        await driver.resume(GoalContext("r"))
        return held, still, state, await moving

    held, still, state, end = played(gantry(peer), story)

    assert 0 < held == still < 40 and state == "hold"
    assert end["x"] == 40 and at(peer)[0] == 40


@pytest.mark.parametrize("doing", ["move", "jog"])
def test_a_hold_without_a_connection_tells_what_is_unknown_and_what_it_held_ends(
    peers, gantry, doing
):
    peer = peers(speed=0.25)

    async def story(driver):
        await driver.home(GoalContext("h"))
        goal = GoalContext("m")
        way = (
            driver.jog(goal, axis="x", distance=40)
            if doing == "jog"
            else driver.move_to(goal, x=40)
        )
        moving = asyncio.create_task(way)
        while peer.place[0] < 1:  # noqa: ASYNC110 - the peer is another thread's
            await asyncio.sleep(0.01)
        if doing == "move":  # it is held, and its cable pulled
            await driver.hold(GoalContext("o"))
            peer.unplug()
            assert await driver.link.until(lambda: bool(driver.link.lost), 5)
        else:
            peer.unplug()
        with pytest.raises(ActionFailed) as held:
            await driver.hold(GoalContext("p"))
        async with asyncio.timeout(5):
            with pytest.raises(ActionFailed, match="was unplugged or is gone") as ended:
                await moving
        return str(held.value), ended.value.happened

    held, happened = played(gantry(peer), story)

    assert (
        re.search("hether it has stopped is unknown|hether it still moves is unknown", held)
        and happened == "unknown"
    )


@pytest.mark.parametrize("version", ["2.0", "2.1"])
def test_a_line_whose_answer_or_text_was_lost_is_carried_out_once(
    peers, gantry, monkeypatch, version
):
    peer = peers()
    peer.silent_on_repeats = version == "2.1"

    async def story(driver):
        await driver.home(GoalContext("h"))
        monkeypatch.setattr(link, "SILENCE_S", 0.6)
        peer.eats_ok_of = "M119"
        await driver.move_to(GoalContext("1"), x=11)
        peer.garbles = "X12"
        await driver.jog(GoalContext("2"), axis="x", distance=1)
        peer.oks_too_many = 1
        peer.relative = True  # a file on its card said so
        await driver.move_to(GoalContext("3"), x=14, z=90)
        rides = driver.world.look("gantry")  # what a simulated analyser on it knows, at once
        return rides, await driver.status()

    rides, status = played(gantry(peer), story)

    assert (rides["x"], rides["z"]) == (14, 90)
    assert status["x"] == 14 and at(peer)[0] == 14 and not status["pins"]


def test_a_zero_that_another_program_has_shifted_is_noticed_and_homing_clears_it(peers, gantry):
    peer = peers(shift=5.0, boots_on_open=False)  # one was left there before

    async def story(driver):
        await driver.home(GoalContext("h"))
        await driver.move_to(GoalContext("1"), x=20)
        await driver.link.ask("G92 X15")
        with pytest.raises(ActionFailed, match=r"shifted its zero by X -5.00 mm") as refused:
            await driver.move_to(GoalContext("2"), x=30)
        stood = at(peer)[0]
        await driver.link.ask("M92 X160")
        await driver.home(GoalContext("i"))
        await driver.link.ask("G0 X10")  # no shift, by the steps that it has now
        await driver.move_to(GoalContext("3"), x=30)
        return refused.value, stood

    refused, stood = played(gantry(peer), story)

    assert (refused.name, refused.happened, stood) == ("Alarm", "no", 20)
    assert at(peer)[0] == 30


def test_a_move_of_another_program_is_told_as_not_held_and_ended_by_halt(peers, gantry):
    peer = peers(speed=5)

    async def story(driver):
        await driver.home(GoalContext("h"))
        await driver.hold(GoalContext("at rest"))
        await driver.link.ask("G1 X190 F600")
        assert "x" not in await driver.status()
        with pytest.raises(ActionFailed, match="it was not held, which Marlin cannot do; `halt`"):
            await driver.hold(GoalContext("hold"))
        await driver.halt(GoalContext("halt"))
        stood = at(peer)[0]
        await asyncio.sleep(0.1)
        return stood, at(peer)[0], await driver.status()

    stood, stands, status = played(gantry(peer), story)

    assert stood == stands < 190
    assert (status["state"], status["homed"]) == ("alarm", False)
    assert "stopped without braking in a move of another program" in status["alarm"]


def test_homing_that_finds_no_switch_halts_marlin_and_unlock_restarts_it(peers, gantry):
    peer = peers()
    peer.homing_fails = True

    async def story(driver):
        with pytest.raises(ActionFailed, match=r"`echo:Homing Failed`, .* unlock restarts it"):
            await driver.home(GoalContext("h"))
        peer.homing_fails = False
        with pytest.raises(ActionFailed, match=r"^Alarm: .*was not moved"):
            await driver.move_to(GoalContext("1"), x=11)
        await driver.unlock(GoalContext("u"))
        with pytest.raises(ActionFailed, match="NotHomed"):
            await driver.move_to(GoalContext("2"), x=11)
        await driver.home(GoalContext("h2"))
        return await driver.move_to(GoalContext("3"), x=11)

    assert played(gantry(peer), story)["x"] == 11


@pytest.mark.parametrize(
    ("emergency", "words"), [(True, "stopped at"), (False, "EMERGENCY_PARSER")]
)
def test_homing_can_be_stopped_with_an_emergency_parser_only(peers, gantry, emergency, words):
    peer = peers(emergency=emergency, homing_s=1.5)

    async def story(driver):
        goal = GoalContext("h")
        homing = asyncio.create_task(driver.home(goal))
        await asyncio.sleep(0.3)
        goal.cancelled.set()
        with pytest.raises((ActionCanceled, ActionFailed), match=words):
            await homing
        return await driver.status()

    assert not played(gantry(peer), story)["homed"]


def test_a_touch_tells_the_contact_and_a_pulled_cable_costs_the_position(
    peers, gantry, monkeypatch
):
    monkeypatch.setattr(fed_gantry, "AGAIN_S", 0.1)
    peer = peers()
    peer.surface = 97.0

    async def story(driver):
        await driver.home(GoalContext("h"))
        contact = await driver.touch(GoalContext("t"), to=96, feed=3000)
        with pytest.raises(ActionFailed, match="NoContact"):
            peer.surface = None
            await driver.touch(GoalContext("t"), to=95, feed=3000)
        peer.unplug()
        assert await driver.link.until(lambda: bool(driver.link.lost), 5)
        peer.plug()
        assert await driver.link.until(lambda: not driver.link.lost, 5)
        await asyncio.sleep(0.5)
        return contact, await driver.status()

    contact, status = played(gantry(peer), story)

    assert math.isclose(contact["z"], 97)
    assert not status["homed"] and "is back. Home it" in status["alarm"]


@pytest.mark.slow
def test_a_driver_for_another_firmware_says_what_it_found(peers, gantry, tmp_path, monkeypatch):
    monkeypatch.setattr(link, "SILENCE_S", 0.3)
    place = Place("gantry", {"port": peers().path, "boot_s": 0.3}, {}, tmp_path, tmp_path)
    deaf = peers(boots_on_open=False)
    deaf.killed = True

    with pytest.raises(OSError, match=r"this is Marlin 2\.0\.9\.7; write `driver: marlin`"):
        asyncio.run(Grbl(place).open())
    with pytest.raises(OSError, match="nothing on it responds: no `start` within 1 s"):
        asyncio.run(gantry(deaf).open())
