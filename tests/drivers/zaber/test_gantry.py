"""Moves of Zaber stages: straight, stopped soon, and trusted as long as each stage knows its place."""

import asyncio

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext

from ..played import played
from .peer import MICROSTEP_MM

pytestmark = pytest.mark.needs("zaber")


async def until(seen):
    """Wait for what another thread brings about."""
    while not seen():  # noqa: ASYNC110
        await asyncio.sleep(0.01)


async def fails(asked):
    with pytest.raises(ActionFailed) as told:
        await asked
    return str(told.value)


def test_stages_go_straight_and_a_second_program_that_opens_the_port_finds_them_homed(
    peers, gantry
):
    peer = peers(speed=100)

    async def story(driver):
        await driver.home(GoalContext("h"))
        at = await driver.move_to(GoalContext("m"), x=30, y=10)
        await driver.set_output(GoalContext("o"), output="laser", on=True)
        await driver.halt(GoalContext("e"))
        return at

    laser = {"on": "1 io set do 1 1", "off": "1 io set do 1 0"}
    at = played(gantry(peer, outputs={"laser": laser}), story)
    x, y = dict(peer.axes[1].path), dict(peer.axes[2].path)
    beside = [abs(x[t] / 3 - y[t]) * MICROSTEP_MM for t in x.keys() & y.keys() if x[t] > 0]

    assert at == pytest.approx({"x": 30, "y": 10, "z": 0}, abs=2e-3)
    assert peer.mm(1) == pytest.approx(30, abs=1e-3) and peer.pins == {(1, 1): 0}
    assert peer.axes[1].accel // 3 == pytest.approx(accel_of(peer, "/2 1 ", "move abs"), abs=1)
    assert len(beside) > 10

    async def again(driver):
        return await driver.status()

    status = played(gantry(peer), again)

    assert status["homed"] and status["x"] == pytest.approx(30, abs=2e-3)


def accel_of(peer, stage, command):
    """The acceleration in the first such command to a stage."""
    line = next(text for text in peer.heard if text.startswith(stage) and command in text)
    return int(line.partition(":")[0].split()[-1])


def test_a_cancel_ends_a_move_on_its_way_and_a_stop_at_once(peers, gantry):
    peer = peers(speed=20)
    for axis in peer.axes.values():
        axis.flags.clear()

    async def story(driver):
        goal = GoalContext("m")
        moving = asyncio.create_task(driver.move_to(goal, x=140))
        await until(lambda: peer.mm(1) > 25)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await moving
        first, status = peer.mm(1), await driver.status()
        moving = asyncio.create_task(driver.move_to(GoalContext("n"), x=140))
        await until(lambda: peer.mm(1) > first + 3)
        await driver.halt(GoalContext("e"))
        assert "a stop ended the motion" in await fails(moving)
        return first, status, peer.mm(1)

    first, status, last = played(gantry(peer), story)

    assert 25 < first < 135 and status["homed"]
    assert status["x"] == pytest.approx(first, abs=2e-3) and first + 3 < last < 139
    assert any("stop" in text for text in peer.heard)


def test_a_stall_and_a_driver_that_is_off_are_told_and_only_homing_makes_the_place_known(
    peers, gantry
):
    peer = peers(speed=60)

    async def story(driver):
        told = [await fails(driver.move_to(GoalContext("0"), x=1))]
        await driver.home(GoalContext("h"))
        moving = asyncio.create_task(driver.move_to(GoalContext("1"), x=140))
        await until(lambda: peer.mm(1) > 5)
        peer.stall(1)
        told += [await fails(moving), await fails(driver.move_to(GoalContext("2"), y=1))]
        shown = await driver.status()
        await driver.unlock(GoalContext("u"))
        told += [await fails(driver.move_to(GoalContext("3"), y=1))]
        await driver.jog(GoalContext("4"), axis="x", distance=-1, feed=6000)
        await driver.home(GoalContext("5"))
        peer.axes[3].parked = True
        told += [await fails(driver.move_to(GoalContext("6"), z=2))]
        await driver.unlock(GoalContext("v"))
        await driver.move_to(GoalContext("7"), z=2)
        told += [await fails(driver.touch(GoalContext("t"), to=0))]
        peer.axes[2].flags |= {"FO"}
        told += [await fails(driver.move_to(GoalContext("8"), y=2))]
        return told, shown

    told, shown = played(gantry(peer), story)

    assert told[0].startswith("NotHomed") and told[3].startswith("NotHomed")
    assert "axis x: stalled and stopped (FS). Unlock and home it" in told[1]
    assert told[2].startswith("Alarm: ") and "was not moved" in told[2]
    assert shown["state"] == "alarm" and "x" not in shown and not shown["homed"]
    assert "it is parked; unlock it" in told[4]
    assert told[5].startswith("NotAvailable") and "no input for a probe" in told[5]
    assert "axis y: driver disabled no fault (FO)" in told[6]


@pytest.mark.slow
def test_a_pulled_cable_and_stages_without_power_are_told_and_found_again(peers, gantry):
    peer = peers(speed=20)
    for axis in peer.axes.values():
        axis.flags.clear()

    async def story(driver):
        moving = asyncio.create_task(driver.move_to(GoalContext("m"), x=140))
        await until(lambda: peer.mm(1) > 22)
        peer.unplug()
        told = [await fails(moving), await fails(driver.move_to(GoalContext("n"), x=1))]
        peer.plug()
        await until(lambda: driver.homed)
        stood = peer.mm(1)
        peer.power_off()
        told += [await fails(driver.move_to(GoalContext("o"), x=1))]
        peer.mute = True
        told += [await fails(driver.move_to(GoalContext("p"), x=1))]
        return told, stood

    told, stood = played(gantry(peer, silence_s=0.3), story)

    assert told[0].startswith("Alarm") and "connection was lost" in told[0]
    assert told[1].startswith("Offline") and "reconnects when it is back" in told[1]
    assert 22 < stood < 139
    assert told[2].startswith("NotHomed")
    assert "was not answered within 0.3 s" in told[3]


def test_stages_that_are_not_there_too_old_or_of_unknown_steps_are_told(peers, gantry):
    async def story(driver):
        return await driver.status()

    for peer, config, words in (
        (peers(axes=1), {"silence_s": 0.2}, "y, device 2 axis 1 did not respond within 0.2 s"),
        (peers(version="6.32.1000"), {}, "has firmware 6.32.1000; moves need 7.25 or newer"),
    ):
        with pytest.raises(OSError, match=words):
            played(gantry(peer, **config), story)
    with pytest.raises(OSError, match="no such file"):
        played(gantry(peers(), port="/dev/there-is-none"), story)

    one = played(gantry(peers(axes=1), stages={"x": {"device": 1, "microstep_um": 0.5}}), story)

    assert one["machine_y"] == one["machine_z"] == 0
    for config, words in (
        ({"stages": {}}, "it names the stage of each axis"),
        ({"stages": {"x": {"device": 1}, "b": {"device": 2}}}, "has no a, but a later axis"),
        ({"stages": {"x": {"device": 1}, "y": {"device": 1}}}, "device 1, axis 1 is named twice"),
        ({"stages": {"x": {"device": 1, "microstep_deg": 1}}}, "said as microstep_um"),
        ({"stages": {"x": {"device": 0}}}, "stages.x: device: Input should be greater"),
        ({"home_order": ["x"]}, "names each of z, x, y once"),
        ({"outputs": {"laser": "spindle"}}, "write its lines with the device's number"),
    ):
        with pytest.raises(ValueError, match=words):
            gantry(peers(), **config)
