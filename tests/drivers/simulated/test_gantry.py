"""The simulated gantry moves as the real one: whole steps, ramps, limits, a stop that stops."""

import asyncio
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext, Place
from labrun.drivers.find import check_driver
from labrun.drivers.simulated.gantry import SimGantry
from labrun.drivers.world import World
from labrun.schemas.contracts import shipped_contracts

from ..played import played

STEP_MM = 1 / 199.1


def gantry(folder: Path, **config) -> SimGantry:
    config = {"clock": "fast", "homed": True, **config}
    return SimGantry(Place("gantry", config, {"x": (0.0, 100.0)}, folder / "gantry", folder))


def truth(folder: Path) -> list[dict]:
    return list(World(folder).truth("gantry").entries())


def test_it_keeps_the_contract():
    check_driver(SimGantry, shipped_contracts()["gantry@1"])


def test_it_stands_within_half_a_step_of_where_it_was_sent(tmp_path):
    async def story(driver):
        return await driver.move_to(GoalContext("g"), x=0.2, y=1.0, z=0.0)

    place = played(gantry(tmp_path), story)

    assert place == {"x": 0.2009, "y": 0.9995, "z": 0.0}
    assert World(tmp_path).look("gantry")["x"] == pytest.approx(0.2, abs=STEP_MM / 2)


def test_axes_left_out_stay(tmp_path):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=5, y=6, z=7)
        return await driver.move_to(GoalContext("b"), z=1)

    place = played(gantry(tmp_path), story)

    assert (place["x"], place["y"]) == pytest.approx((5, 6), abs=STEP_MM)


def test_a_place_outside_this_bench_is_refused_and_nothing_moves(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match=r"x 100\.1 mm is outside 0 to 100 mm") as refused:
            await driver.move_to(GoalContext("g"), x=100.1)
        return refused.value.name

    assert played(gantry(tmp_path), story) == "SoftLimit"
    assert truth(tmp_path) == []


KEPT_OUT = {"keep_out": [{"name": "clamp", "x": [20, 30], "z": [0, 40]}]}
AROUND = [
    lambda d: d.move_to(GoalContext("g"), x=50.0),
    lambda d: d.move_to(GoalContext("g"), x=25.0, safe_z=60.0),
    lambda d: d.jog(GoalContext("g"), axis="x", distance=12.0),
    lambda d: d.touch(GoalContext("g"), axis="x", to=50.0),
    lambda d: d.go_to_zero(GoalContext("g")),
]


@pytest.mark.parametrize("asked", AROUND)
def test_no_line_goes_through_a_box_that_is_kept_out_of(tmp_path, asked):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=40.0, z=20.0, safe_z=50.0)
        await driver.set_zero(GoalContext("b"))
        await driver.move_to(GoalContext("c"), x=10.0, z=20.0, safe_z=50.0)
        moved = len(truth(tmp_path))
        with pytest.raises(
            ActionFailed, match=r"keep-out box `clamp` \(x 20 to 30, z 0 to 40 mm\)"
        ):
            await asked(driver)
        assert len(truth(tmp_path)) == moved
        held = await driver.jog(GoalContext("d"), direction="+", axis="x", feed=2000.0, lease=9.0)
        over = await driver.move_to(GoalContext("e"), x=50.0, safe_z=40.0)
        return held["x"], over["x"]

    limits = {"clock": 20.0, **KEPT_OUT}
    assert played(gantry(tmp_path, **limits), story) == pytest.approx((20, 50), abs=0.02)


def test_it_must_be_homed_before_it_moves(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match="NotHomed"):
            await driver.move_to(GoalContext("a"), x=1)
        await driver.home(GoalContext("b"))
        await driver.move_to(GoalContext("c"), x=1)
        return await driver.status()

    status = played(gantry(tmp_path, homed=False), story)

    assert status["homed"]
    assert status["z"] == pytest.approx(100, abs=STEP_MM)


def test_the_time_that_a_move_takes_is_counted_on_the_fast_clock(tmp_path):
    async def story(driver):
        await driver.move_to(GoalContext("g"), x=100.0)
        return driver.clock.elapsed_s

    # 100 mm at 41.67 mm/s with 150 mm/s2: 2.4 s and one ramp of 0.278 s
    assert played(gantry(tmp_path), story) == pytest.approx(2.678, abs=0.002)


def test_a_cancel_stops_it_on_the_way(tmp_path):
    async def story(driver):
        goal = GoalContext("g")
        told = []
        goal.tell = lambda progress, message: (told.append(progress), goal.cancelled.set())
        with pytest.raises(ActionCanceled):
            await driver.move_to(goal, x=50.0)
        return told, await driver.status()

    told, status = played(gantry(tmp_path, clock="real"), story)

    assert len(told) == 1
    assert 0 < status["x"] < 50
    assert status["state"] == "idle"
    assert truth(tmp_path)[-1]["end"][0] == status["x"]


def test_the_safe_state_stops_a_move_and_it_can_go_on_after(tmp_path):
    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=50.0))
        await asyncio.sleep(0.12)
        await driver.safe()
        with pytest.raises(ActionFailed, match="Alarm: a stop ended the move"):
            await move
        return await driver.move_to(GoalContext("b"), x=1.0)

    place = played(gantry(tmp_path, clock="real"), story)

    assert place["x"] == pytest.approx(1, abs=STEP_MM)


def test_an_ordered_alarm_locks_it_until_it_is_homed(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match="Alarm"):
            await driver.move_to(GoalContext("a"), x=5)
        state = (await driver.status())["state"]
        with pytest.raises(ActionFailed, match="unlock or home"):
            await driver.move_to(GoalContext("b"), x=5)
        await driver.unlock(GoalContext("c"))
        with pytest.raises(ActionFailed, match="NotHomed"):
            await driver.move_to(GoalContext("d"), x=5)
        return state

    assert played(gantry(tmp_path, faults={"move_to": {"Alarm": 1.0}}), story) == "alarm"


def test_lost_steps_are_found_again_by_homing(tmp_path):
    async def story(driver):
        said = await driver.move_to(GoalContext("a"), x=10.0)
        true = driver.world.look("gantry")["x"]
        await driver.home(GoalContext("b"))
        return said["x"], true, driver.world.look("gantry")["x"]

    said, true, after = played(gantry(tmp_path, lost_steps=1.0), story)

    assert 0.009 < said - true < 0.21
    assert after == 0.0


def test_a_setting_that_it_does_not_have_is_refused(tmp_path):
    with pytest.raises(
        ValueError, match="config has no key speed; its keys are: clock, seed, faults, homed"
    ):
        gantry(tmp_path, speed=3)


def test_hold_and_resume_go_on_along_the_same_line(tmp_path):
    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=40.0))
        await asyncio.sleep(0.2)
        await driver.hold(GoalContext("b"))
        await asyncio.sleep(0.3)
        held = await driver.status()
        await asyncio.sleep(0.2)
        still = await driver.status()
        await driver.resume(GoalContext("c"))
        return held, still, await move

    held, still, place = played(gantry(tmp_path, clock=4), story)

    assert held["state"] == "hold" and 0 < held["x"] < 40
    assert still["x"] == held["x"]
    assert place["x"] == pytest.approx(40, abs=STEP_MM)


def test_halt_ends_a_move_and_is_done_when_the_axes_stand(tmp_path):
    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=40.0))
        await asyncio.sleep(0.2)
        await driver.halt(GoalContext("b"))
        halted = await driver.status()
        with pytest.raises(ActionFailed, match="a stop ended the move"):
            await move
        return halted, await driver.status()

    halted, later = played(gantry(tmp_path, clock=4), story)

    assert halted["state"] == "idle" and 0 < halted["x"] < 40
    assert later["x"] == halted["x"]


def test_a_stop_ends_what_is_held(tmp_path):
    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=40.0))
        await asyncio.sleep(0.2)
        await driver.hold(GoalContext("b"))
        await asyncio.sleep(0.2)
        await driver.safe()
        with pytest.raises(ActionFailed, match="a stop ended the move"):
            await move
        return (await driver.status())["state"]

    assert played(gantry(tmp_path, clock=4), story) == "idle"


def test_a_work_zero_is_set_gone_to_and_kept(tmp_path):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=30.0, y=40.0, z=5.0)
        zero = await driver.set_zero(GoalContext("b"), axes=["x", "y"])
        await driver.move_to(GoalContext("c"), x=50.0, y=45.0)
        probe = await driver.last_by_hand(GoalContext("d"))
        return zero, await driver.status(), probe

    async def later(driver):
        return await driver.go_to_zero(GoalContext("e"), axes=["x"])

    zero, status, probe = played(gantry(tmp_path), story)
    place = played(gantry(tmp_path), later)

    assert zero["x"] == pytest.approx(30, abs=STEP_MM) and zero["z"] == 0
    assert (status["work_x"], status["work_y"]) == pytest.approx((20, 5), abs=2 * STEP_MM)
    assert probe == {"goal_id": "b", **zero}
    assert (place["x"], place["y"]) == pytest.approx((30, 45), abs=STEP_MM)


def test_a_jog_by_a_distance_ends_there_and_one_out_of_the_bench_is_refused(tmp_path):
    async def story(driver):
        place = await driver.jog(GoalContext("a"), axis="x", distance=2.5)
        with pytest.raises(ActionFailed, match=r"SoftLimit: gantry was not moved: x -0\.99"):
            await driver.jog(GoalContext("b"), axis="x", distance=-3.5)
        return place

    assert played(gantry(tmp_path), story)["x"] == pytest.approx(2.5, abs=STEP_MM)


def test_a_jog_that_is_held_ends_with_the_hold(tmp_path):
    async def story(driver):
        goal = GoalContext("a")
        jog = asyncio.create_task(driver.jog(goal, axis="x", direction="+", feed=1200, lease=0.3))
        goal.wanted_at = math.inf  # as if it were sent again all the time
        while (held := (await driver.status())["x"]) <= 10 and not jog.done():  # noqa: ASYNC110 - a clock moves it
            await asyncio.sleep(0.05)
        goal.wanted_at = time.monotonic()
        return held, await jog

    held, place = played(gantry(tmp_path, clock="real"), story)

    assert 10 < held < place["x"] < held + 20


def test_on_a_clock_that_only_counts_a_held_jog_lasts_one_lease(tmp_path):
    async def story(driver):
        place = await driver.jog(GoalContext("a"), axis="x", direction="+", feed=600, lease=0.5)
        return place, await driver.jog(GoalContext("b"), way="+x+y", feed=600, lease=0.5)

    straight, both = played(gantry(tmp_path), story)

    assert straight["x"] == pytest.approx(5, abs=STEP_MM)
    assert (both["x"] - 5, both["y"]) == pytest.approx((3.536, 3.536), abs=STEP_MM)


def test_status_says_all_that_the_contract_says(tmp_path):
    async def story(driver):
        return await driver.status()

    status = played(gantry(tmp_path), story)

    assert set(status) == set(shipped_contracts()["gantry@1"].status["properties"])


@pytest.mark.posix("kill -9 is a signal of POSIX")
def test_a_killed_gantry_comes_back_where_it_stood(tmp_path):
    script = f"""
import asyncio, pathlib
from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.simulated.gantry import SimGantry
async def main():
    folder = pathlib.Path({str(tmp_path)!r})
    driver = SimGantry(Place("gantry", {{"homed": True}}, {{}}, folder, folder))
    await driver.open()
    goal = GoalContext("g")
    goal.tell = lambda progress, message: print(progress, flush=True)
    await driver.move_to(goal, x=700)
asyncio.run(main())
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        for _ in range(3):
            process.stdout.readline()
        os.kill(process.pid, signal.SIGKILL)

    async def story(driver):
        return await driver.status()

    status = played(gantry(tmp_path), story)

    assert 0 < status["x"] < 100
    assert World(tmp_path).look("gantry")["x"] == pytest.approx(status["x"], abs=1e-3)
