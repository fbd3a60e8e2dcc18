"""Moves through Klipper: fed in pieces, in its machine coordinates, and trusted as long as Klipper does."""

import asyncio

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.drivers.moonraker import gantry as moonraker

from ..played import played


@pytest.mark.slow
def test_a_stop_ends_the_move_soon_and_another_program_s_offset_and_g91_move_nothing(peers, gantry):
    peer = peers(speed=50)

    async def story(driver):
        await driver.home(GoalContext("h"))
        peer.shift, peer.relative = [7.0, 0.0, 0.0], True
        await asyncio.sleep(0.4)
        goal = GoalContext("m")
        moving = asyncio.create_task(driver.move_to(goal, x=150))
        await asyncio.sleep(0.5)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await moving
        ended, status = peer.place[0], await driver.status()
        await driver.move_to(GoalContext("n"), x=ended + 5)
        return ended, status

    ended, status = played(gantry(peer), story)

    assert 10 < ended < 80 and status["homed"] and status["x"] == pytest.approx(ended, abs=0.01)
    assert peer.place[0] == pytest.approx(ended + 5, abs=0.01)


@pytest.mark.slow
def test_a_move_that_is_refused_on_its_way_has_ended_and_is_not_said_to_be_undone(peers, gantry):
    peer = peers(speed=50)

    async def story(driver):
        with pytest.raises(ActionFailed, match=r"NotHomed: .* Must home axis first"):
            await driver.jog(GoalContext("j"), axis="x", distance=1.0)
        await driver.home(GoalContext("h"))
        moving = asyncio.create_task(driver.move_to(GoalContext("m"), x=150))
        await asyncio.sleep(0.5)
        peer.axes = ""
        with pytest.raises(ActionFailed, match=r"^Alarm: .* after a part of the way") as failed:
            await moving
        return failed.value.happened, peer.move

    assert played(gantry(peer), story) == ("unknown", None)


def test_a_move_is_not_done_while_its_board_is_gone(peers, gantry):
    peer = peers()

    async def story(driver):
        await driver.home(GoalContext("h"))
        await driver.move_to(GoalContext("0"), x=1)
        peer.is_gone = True
        with pytest.raises(ActionFailed, match="Lost communication with MCU") as failed:
            await driver.move_to(GoalContext("1"), x=2)
        return failed.value.happened

    assert played(gantry(peer), story) == "unknown"


@pytest.mark.soak
def test_a_print_of_another_program_keeps_moves_out_and_a_halt_pauses_it(peers, gantry):
    peer = peers()

    async def story(driver):
        await driver.home(GoalContext("h"))
        peer.prints = "/gcodes/benchy.gcode"
        assert await driver.link.until(lambda: driver.link.prints, 10)
        for begun in (driver.move_to(GoalContext("0"), x=1), driver.home(GoalContext("h2"))):
            with pytest.raises(
                ActionFailed, match=r"Klipper prints benchy\.gcode; halt pauses that"
            ):
                await begun
        assert "benchy" in (await driver.status())["alarm"] and peer.prints
        await driver.halt(GoalContext("1"))
        assert peer.prints is None
        return await driver.move_to(GoalContext("2"), x=2)

    assert played(gantry(peer), story)["x"] == 2


@pytest.mark.slow
def test_a_halted_klipper_is_told_and_unlock_restarts_it(peers, gantry, monkeypatch):
    monkeypatch.setattr(moonraker, "RESTART_S", 0.0)
    peer = peers(homing_s=2, api_key="secret")

    async def story(driver):
        goal = GoalContext("h")
        homing = asyncio.create_task(driver.home(goal))
        await asyncio.sleep(0.2)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled):
            await homing
        with pytest.raises(ActionFailed, match=r"^Alarm: .*state shutdown: .*unlock restarts it"):
            await driver.move_to(GoalContext("1"), x=1)
        assert "shutdown: Shutdown due to" in (await driver.status())["alarm"]
        await driver.unlock(GoalContext("u"))
        with pytest.raises(ActionFailed, match="NotHomed"):
            await driver.move_to(GoalContext("2"), x=1)
        with pytest.raises(ActionFailed, match=r"NotAvailable: .* nothing that does `M3S255.000`"):
            await driver.set_output(GoalContext("o"), output="laser", on=True)

    played(gantry(peer, api_key="secret", outputs={"laser": "spindle"}), story)

    assert peer.restarts == 2

    with pytest.raises(OSError, match=r"Unauthorized; give its API key as `api_key`"):
        played(gantry(peer), story)
