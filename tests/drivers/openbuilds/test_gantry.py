"""The driver on OpenBuilds CONTROL: the tagged proof, and every trap that was measured."""

import asyncio
import contextlib
import math
import time

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.drivers.find import check_driver
from labrun.drivers.grbl.faults import GrblRefused
from labrun.drivers.motion.faults import MotionFault
from labrun.drivers.openbuilds.gantry import OpenBuilds
from labrun.schemas.contracts import shipped_contracts

ORIGIN_X = -805.0


async def until(driver, true):
    """The first status that is so."""
    async with asyncio.timeout(500):
        while not true(status := await driver.status()):  # noqa: ASYNC110 - it has to be asked
            await asyncio.sleep(0.02)
    return status


def test_it_keeps_the_contract():
    check_driver(OpenBuilds, shipped_contracts()["gantry@1"])


def test_it_has_the_port_opened_reads_the_settings_and_homes(peer, played):
    async def story(driver, control):
        return await driver.status(), driver.bench.origin, control.heard[0]

    status, origin, first = played(peer, story)

    assert (status["state"], status["homed"], status["alarm"]) == ("idle", True, "")
    assert (status["x"], status["z"]) == pytest.approx((0, 85), abs=0.006)
    assert origin == (-805.0, -725.0, -90.0)
    assert first == ("connectTo", {"type": "usb", "port": peer.path, "baud": 115200})


def test_a_move_has_not_succeeded_before_it_stands_whatever_status_says(peers, played):
    peer = peers(speed=3)

    async def story(driver, control):
        false_idle = 0
        for x in (8, 16, 24, 32, 40):
            move = asyncio.create_task(driver.move_to(GoalContext("m"), x=x, z=10))
            while not move.done():
                false_idle += control.run == "Idle" and peer.move is not None
                await asyncio.sleep(0.005)
            assert peer.move is None
            assert peer.place[0] - ORIGIN_X == pytest.approx(x, abs=0.005)
            assert driver.world.look("gantry")["x"] == pytest.approx(x, abs=0.005)
        return false_idle, control.completed

    false_idle, completed = played(peer, story)

    assert false_idle > 0  # else this has tested nothing
    assert completed >= 5


def test_each_command_ends_with_a_proof_of_its_own(peer, played):
    async def story(driver, control):
        await driver.move_to(GoalContext("a"), x=5)
        await driver.move_to(GoalContext("b"), x=5, feed=100)
        return [data for event, data in control.heard if event == "runCommand"]

    *_, first, second = played(peer, story)

    assert first.startswith("G21G90G94G53G0X-800.0000\nG4 P0 (labrun ")
    assert second.startswith("G21G90G94G53G1X-800.0000F100.000\nG4 P0 (labrun ")
    assert first.rpartition("(")[2] != second.rpartition("(")[2]


@pytest.mark.parametrize("wanted", [{"x": 731}, {"y": 800}, {"z": float("nan")}])
def test_a_place_out_of_reach_is_refused_before_anything_is_sent(peer, played, wanted):
    async def story(driver, control):
        before = len(control.heard)
        with pytest.raises(ActionFailed, match=r"SoftLimit: gantry .* was not moved"):
            await driver.move_to(GoalContext("m"), **wanted)
        return len(control.heard) - before

    assert played(peer, story) == 0


def test_without_homing_nothing_moves(peer, played):
    async def story(driver, control):
        with pytest.raises(ActionFailed, match="NotHomed"):
            await driver.move_to(GoalContext("m"), x=5)
        return (await driver.status())["state"]

    assert played(peer, story, homed=False) == "alarm"


@pytest.mark.parametrize("buttons", ["", "RHS"])
def test_a_board_that_is_locked_at_power_up_is_no_alarm_and_home_first_homes_it(
    peers, played, buttons
):
    async def story(driver, control):
        locked = await until(driver, lambda s: s["state"] == "alarm")
        assert not control.hasty
        return locked, await driver.move_to(GoalContext("m"), x=3)

    peer = peers()
    peer.buttons = buttons  # CONTROL resets it as its first report tells of one that is pressed
    locked, place = played(peer, story, homed=False, home_first=True)

    assert locked["alarm"].startswith("it is locked until it is homed")
    assert not {"x", "work_x"} & set(locked)
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_fluidnc_behind_it_has_its_own_scale_and_its_own_numbers(peers, played):
    peer = peers(fluid=True, homes_at=(-7.0, 5.0, 3.0), settings={20: 1, 23: 2})

    async def story(driver, control):
        locked = await until(driver, lambda s: s["state"] == "alarm")
        place = await driver.move_to(GoalContext("m"), x=3, y=2)
        peer.refuses["$X"] = 40
        with pytest.raises(GrblRefused) as refused:
            await driver.control.ask("$X", 60)
        return locked, place, driver.bench.origin, refused.value

    locked, place, origin, refused = played(peer, story, homed=False, home_first=True)

    assert locked["alarm"].startswith("it is locked until it is homed")
    assert (place["x"], place["y"]) == pytest.approx((3, 2), abs=0.005)
    assert origin == (-7.0 - 810.0, 5.0, 3.0 - 90.0)
    assert "limit switch or control input is engaged" in str(refused)


def test_what_a_locked_board_loses_while_it_boots_is_asked_again(peers, played, monkeypatch):
    monkeypatch.setattr("labrun.drivers.openbuilds.gantry.SETTINGS_S", 0.5)
    peer = peers()
    peer.eats_ok_of = "$$"  # CONTROL waits for it, and sends nothing more

    async def story(driver, control):
        await driver.home(GoalContext("home"))
        return await driver.move_to(GoalContext("m"), x=3)

    assert played(peer, story, homed=False)["x"] == pytest.approx(3, abs=0.005)
    assert peer.heard.count("$$") >= 2  # a busy machine may ask once more


def test_an_emergency_stop_between_two_reads_is_told_as_what_it_is(peers, played):
    async def story(driver, control):
        answered = driver.control.proofs.answered

        def stopped_after(line):
            answered(line)
            if "G4 P0" in line:  # the proof has come; the place has not been read yet
                peer.steps = [0, 0, 0]
                peer._power_on()
                driver.control._data({"response": "Grbl 1.1h ['$' for help]"})

        driver.control.proofs.answered = stopped_after
        with pytest.raises(ActionFailed) as stopped:
            await driver.move_to(GoalContext("m"), x=3)
        return stopped.value.name, stopped.value.message, await driver.status()

    peer = peers()

    error, message, status = played(peer, story)

    assert error == "Alarm"
    assert "emergency stop" in message
    assert not status["homed"]


def test_a_cancel_holds_first_so_that_the_place_is_still_trusted(peers, played):
    peer = peers(speed=1)

    async def story(driver, control):
        goal = GoalContext("m")
        move = asyncio.create_task(driver.move_to(goal, x=200))
        await asyncio.sleep(1)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await move
        assert peer.move is None
        return await until(driver, lambda s: s["state"] == "idle")

    status = played(peer, story)

    assert status["homed"]
    assert 0 < status["x"] < 200
    assert peer.place[0] - ORIGIN_X == pytest.approx(status["x"], abs=0.01)


def test_safe_stops_a_move(peers, played):
    peer = peers(speed=2)

    async def story(driver, control):
        move = asyncio.create_task(driver.move_to(GoalContext("m"), x=300))
        await asyncio.sleep(0.6)
        await driver.safe()
        stood = list(peer.steps)
        with pytest.raises(ActionFailed, match="Alarm: a stop ended the motion of gantry"):
            await move
        await asyncio.sleep(0.3)
        return stood

    assert played(peer, story) == peer.steps
    assert peer.move is None and not peer.queue


@pytest.mark.slow
def test_an_alarm_in_mid_move_is_named_and_ends_with_unlock_and_home(peer, played):
    async def story(driver, control):
        peer.hit_at = -700
        with pytest.raises(ActionFailed, match="ALARM:1: a limit switch was hit") as hit:
            await driver.move_to(GoalContext("a"), x=300)
        locked = await driver.status()
        peer.hit_at, control.boots_for_long = None, True
        await driver.unlock(GoalContext("b"))
        unlocked = await until(driver, lambda s: s["state"] != "alarm")
        await driver.home(GoalContext("c"))
        place = await driver.move_to(GoalContext("d"), x=3)
        return hit.value.happened, locked, unlocked, place

    happened, locked, unlocked, place = played(peer, story)

    assert happened == "unknown"
    assert (locked["state"], locked["homed"]) == ("alarm", False)
    assert (unlocked["state"], unlocked["homed"]) == ("idle", False)
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_an_alarm_that_is_told_by_nothing_but_the_connection_status_is_seen(peer, played):
    async def story(driver, control):
        control.connection = 5
        return await until(driver, lambda s: "locked" not in (s["alarm"] or "locked"))

    status = played(peer, story)

    assert status["state"] == "alarm"
    assert "reports an error or alarm" in status["alarm"]


@pytest.mark.soak
def test_a_server_that_starts_after_an_alarm_tells_it_and_ends_it(peers, program, gantry):
    peer = peers(settings={20: 1})

    async def story():
        async with program(peer) as control:
            first = gantry(control.url, peer.path)
            await first.open()
            await first.home(GoalContext("home"))
            with contextlib.suppress(MotionFault):
                await (await first.control.run("G53G0X5000"))
            await first.close()
            second = gantry(control.url, peer.path)
            await second.open()
            try:
                left = await second.status()
                await second.unlock(GoalContext("u"))
                await second.home(GoalContext("h"))
                return left, await second.move_to(GoalContext("m"), x=3)
            finally:
                await second.close()

    left, place = asyncio.run(story())

    assert (left["state"], left["homed"]) == ("alarm", False)
    assert "reports an error or alarm: 2 - in words. Unlock it" in left["alarm"]
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_an_error_stops_the_queue_and_unlock_clears_it(peer, played):
    async def story(driver, control):
        control.queue.append("G41")
        control._send()
        status = await until(driver, lambda s: s["alarm"])
        with pytest.raises(ActionFailed, match=r"was not moved: error:20 \(unknown G"):
            await driver.move_to(GoalContext("a"), x=3)
        await driver.unlock(GoalContext("b"))
        await driver.home(GoalContext("c"))
        return status, await driver.move_to(GoalContext("d"), x=3)

    status, place = played(peer, story)

    assert status["state"] == "alarm"
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_homing_that_does_not_end_is_reset_and_told_with_the_setting_that_gives_it_longer(
    peers, played
):
    peer = peers(homing_s=10_000.0)
    peer.aborts_as = 8

    async def story(driver, control):
        with pytest.raises(
            ActionFailed, match=r"within 0.4 s and was reset.*`homing_timeout`"
        ) as f:
            await driver.home(GoalContext("h"))
        return f.value.name, (await until(driver, lambda s: "ALARM" in s["alarm"]))["alarm"]

    name, alarm = played(peer, story, homed=False, homing_timeout=0.4)

    assert name == "HomingFailed"
    assert "ALARM:6" in alarm


def test_homing_that_fails_says_why(peer, played):
    peer.homing_fails = 9

    async def story(driver, control):
        with pytest.raises(ActionFailed, match=r"HomingFailed: .*ALARM:9"):
            await driver.home(GoalContext("h"))
        return await driver.status()

    status = played(peer, story, homed=False)

    assert (status["state"], status["homed"]) == ("alarm", False)


@pytest.mark.slow
def test_a_controller_that_falls_silent_is_found_by_its_frozen_place(peers, played, monkeypatch):
    from labrun.drivers.openbuilds import stopping, watch

    monkeypatch.setattr(watch, "STUCK_S", 1.0)
    monkeypatch.setattr(stopping, "HOLD_S", 1.5)
    monkeypatch.setattr(stopping, "PROOF_S", 1.2)
    peer = peers(speed=1)

    async def story(driver, control):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=300))
        await asyncio.sleep(0.5)
        peer.silent = True
        with pytest.raises(
            ActionFailed, match="its position has not changed for 1 s, and it reports Run"
        ):
            await move
        return await driver.status()

    assert not played(peer, story)["homed"]


@pytest.mark.soak
def test_a_move_that_stands_short_of_its_target_is_stopped_and_can_be_repeated(
    peer, played, monkeypatch
):
    from labrun.drivers.openbuilds import watch

    monkeypatch.setattr(watch, "STUCK_S", 1.0)

    async def story(driver, control):
        peer.runs_dry_at = -700
        with pytest.raises(ActionFailed, match=r"it reports Idle; it is stopped: repeat the move"):
            await driver.move_to(GoalContext("a"), x=200)
        short = await driver.status()
        return short, peer.place[0], await driver.move_to(GoalContext("b"), x=200)

    short, true, place = played(peer, story)

    assert short["homed"]
    assert short["x"] < 150 and short["x"] == pytest.approx(true + 805, abs=0.01)
    assert place["x"] == pytest.approx(200, abs=0.005)


@pytest.mark.slow
def test_hold_and_resume_work_though_the_programs_own_pause_does_not(peers, played):
    peer = peers(speed=2)

    async def story(driver, control):
        move = asyncio.create_task(driver.move_to(GoalContext("m"), x=100))
        await asyncio.sleep(0.4)
        await driver.hold(GoalContext("h"))
        held = await driver.status()
        await asyncio.sleep(0.3)
        assert not move.done() and peer.move is None
        await driver.resume(GoalContext("r"))
        return held, await move

    held, place = played(peer, story)

    assert held["state"] == "hold"
    assert place["x"] == pytest.approx(100, abs=0.005)


@pytest.mark.soak
def test_a_move_that_was_lost_sight_of_is_held_and_gone_on_with(peers, played):
    peer = peers(homing_s=0.1)

    async def story(driver, control):
        ended = await driver.control.run("G53G1X-700F600")
        await until(driver, lambda s: s["state"] == "moving" and s["x"] > 0)
        await driver.hold(GoalContext("h"))
        held, stands = await driver.status(), peer.move is None
        await driver.resume(GoalContext("r"))
        await until(driver, lambda s: s["state"] == "moving")
        await driver.halt(GoalContext("end"))
        return held, stands, ended.done()

    held, stands, ended = played(peer, story)

    assert held["state"] == "hold" and stands and not ended


@pytest.mark.soak
def test_steps_per_mm_that_were_set_by_another_of_its_pages_cost_the_place_until_it_is_homed(
    peers, played
):
    peer = peers(homing_s=0.1)

    async def story(driver, control):
        await driver.move_to(GoalContext("m"), x=20)
        stood = list(peer.steps)
        await (await driver.control.run("$100=100"))
        with pytest.raises(ActionFailed, match=r"has changed \$100 from 199.1 to 100.*; home it"):
            await driver.move_to(GoalContext("n"), x=30)
        assert peer.steps == stood
        await driver.unlock(GoalContext("u"))
        await driver.home(GoalContext("h"))
        return await driver.move_to(GoalContext("o"), x=30)

    place = played(peer, story)

    assert place["x"] == pytest.approx(30, abs=0.006)
    assert peer.place[0] - -805 == pytest.approx(30, abs=0.006)


@pytest.mark.soak
def test_reports_in_inches_are_refused(peers, played):
    with pytest.raises(OSError, match=r"in inches .*: write `\$13=0`"):
        played(peers(settings={13: 1}), None)


@pytest.mark.soak
def test_reports_in_inches_that_another_program_has_begun_are_told_with_what_ends_them(
    peers, played
):
    async def story(driver, control):
        await (await driver.control.run("$13=1"))
        inches = (await driver.status())["alarm"]
        with pytest.raises(ActionFailed, match=r"HomingFailed: .*write `\$13=0`, then home it"):
            await driver.home(GoalContext("h"))
        await (await driver.control.run("$13=0"))
        await driver.home(GoalContext("i"))
        return inches, await driver.move_to(GoalContext("m"), x=30)

    inches, place = played(peers(homing_s=0.1), story)

    assert inches.endswith("write `$13=0`, then home it")
    assert place["x"] == pytest.approx(30, abs=0.006)


@pytest.mark.soak
def test_a_travel_that_another_program_has_changed_is_told_with_the_alarm_of_a_soft_limit(
    peers, played
):
    async def story(driver, control):
        await (await driver.control.run("$130=500"))
        with pytest.raises(ActionFailed, match="ALARM:2: a move would have left"):
            await driver.move_to(GoalContext("m"), x=20)
        return (await driver.status())["alarm"]

    alarm = played(peers(settings={20: 1}, homing_s=0.1), story)

    assert alarm.endswith("has changed $130 from 810 to 500, and homing reads it")


@pytest.mark.soak
def test_an_axis_of_grblhal_moves_alone_from_where_it_has_homed(peers, played):
    async def story(driver, control):
        return await driver.move_to(GoalContext("z"), z=0.0)

    place = played(peers(hal=True, settings={20: 1}), story)

    assert (place["x"], place["y"], place["z"]) == pytest.approx((0.0, 0.0, 0.0), abs=0.006)


def test_a_work_zero_is_set_and_gone_to(peer, played):
    async def story(driver, control):
        await driver.move_to(GoalContext("a"), x=30, y=40)
        zero = await driver.set_zero(GoalContext("b"), axes=["x"])
        await driver.move_to(GoalContext("c"), x=100)
        far = await until(driver, lambda s: s["work_x"] > 60)
        return zero, far, await driver.go_to_zero(GoalContext("d"), axes=["x"])

    zero, far, place = played(peer, story)

    assert zero["x"] == pytest.approx(30, abs=0.005)
    assert far["work_x"] == pytest.approx(70, abs=0.01)
    assert (place["x"], place["y"]) == pytest.approx((30, 40), abs=0.005)


@pytest.mark.slow
def test_a_held_jog_to_an_edge_close_by_does_not_end_with_an_old_idle(peers, played):
    async def story(driver, control):
        await driver.move_to(GoalContext("a"), x=3, y=10)
        return await driver.jog(GoalContext("b"), way="-x-y", feed=600, lease=2.0)

    place = played(peers(speed=1), story)

    assert (place["x"], place["y"]) == pytest.approx((0, 7), abs=0.02)


@pytest.mark.slow
def test_a_jog_by_a_distance_and_one_that_is_held(peers, played):
    peer = peers(speed=1)

    async def story(driver, control):
        step = await driver.jog(GoalContext("a"), axis="x", distance=2)
        goal = GoalContext("b")
        jog = asyncio.create_task(driver.jog(goal, axis="x", direction="+", feed=1200))
        goal.wanted_at = math.inf  # as if it were sent again all the time
        while (held := (await driver.status())["x"]) <= 10 and not jog.done():  # noqa: ASYNC110 - a clock moves it
            await asyncio.sleep(0.05)
        goal.wanted_at = time.monotonic()
        return step, held, await jog

    step, held, place = played(peer, story)

    assert step["x"] == pytest.approx(2, abs=0.01)
    assert 10 < held <= place["x"] < held + 25
    assert peer.move is None and not peer.queue


@pytest.mark.slow
def test_the_port_that_is_unplugged_and_back_is_opened_again(peers, played):
    peer = peers(speed=2)

    async def story(driver, control):
        move = asyncio.create_task(driver.move_to(GoalContext("a"), x=100))
        await asyncio.sleep(0.5)
        peer.unplug()
        with pytest.raises(ActionFailed, match=r"Alarm: .*lost the port") as pulled:
            await move
        gone = await driver.status()
        with pytest.raises(ActionFailed, match=r"Offline: .*has no port open"):
            await driver.move_to(GoalContext("b"), x=1)
        peer.plug()
        back = await until(driver, lambda s: s["state"] == "alarm")
        await driver.home(GoalContext("c"))
        return pulled.value.happened, gone, back, await driver.move_to(GoalContext("d"), x=2)

    happened, gone, back, place = played(peer, story)

    assert happened == "unknown"
    assert gone["state"] == "offline"
    assert not back["homed"]
    assert place["x"] == pytest.approx(2, abs=0.005)


@pytest.mark.slow
def test_it_comes_back_when_the_program_was_started_anew(peer, program, gantry):
    async def whole():
        async with program(peer) as first:
            driver = gantry(first.url, peer.path)
            await driver.open()
            await driver.home(GoalContext("a"))
            port = first.port
        try:
            gone = await until(driver, lambda s: s["state"] == "offline")
            with pytest.raises(OSError, match="cannot be stopped"):
                await driver.safe()
            async with program(peer, port=port):
                back = await until(driver, lambda s: s["state"] == "alarm")
                await driver.home(GoalContext("b"))
                return gone, back, await driver.move_to(GoalContext("c"), x=4)
        finally:
            await driver.close()

    gone, back, place = asyncio.run(whole())

    assert not gone["homed"] and not back["homed"]
    assert place["x"] == pytest.approx(4, abs=0.005)


def test_a_program_that_tells_no_status_any_more_is_offline(peer, played):
    async def story(driver, control):
        control.told = False
        return await until(driver, lambda s: s["state"] == "offline")

    assert "has sent no status" in played(peer, story, homed=False, silence_s=2)["alarm"]


def test_no_program_at_that_address(gantry):
    async def story():
        driver = gantry("http://127.0.0.1:9", "/dev/ttyUSB0")
        with pytest.raises(
            OSError, match=r"OpenBuilds CONTROL does not respond at http://127.0.0.1:9"
        ):
            await driver.open()

    asyncio.run(story())


@pytest.mark.parametrize(
    ("port", "told"),
    [
        ("/dev/ttyNONE7", "did not open /dev/ttyNONE7 within 1 s"),
        ("", r"has had no report of .* within 1 s; .* `boot_s: 2`"),
    ],
)
def test_no_such_port_in_the_program_or_no_report_by_it(peer, program, gantry, port, told):
    async def story():
        async with program(peer) as control:
            peer.loses_questions = 1000
            driver = gantry(control.url, port or peer.path, boot_s=1.0)
            with pytest.raises(OSError, match=told):
                await driver.open()

    asyncio.run(story())


@pytest.mark.parametrize("silent", [True, False])  # its banner comes too late, or as late as can be
def test_a_board_that_says_nothing_in_time_has_its_port_closed_by_the_program(
    peer, program, gantry, silent
):
    async def story():
        async with program(peer) as control:
            control.gives_up_s = 0.3  # the board boots for longer
            control.asks_after_s, peer.silent = 60, silent
            driver = gantry(control.url, peer.path)
            with pytest.raises(OSError, match=r"closed .* again: nothing on it responded in time"):
                await driver.open()

    asyncio.run(story())


def test_another_port_open_in_the_program(peer, program, gantry):
    async def story():
        async with program(peer) as control:
            control.connection, control.active = 2, "/dev/ttyUSB9"
            driver = gantry(control.url, peer.path)
            with pytest.raises(OSError, match="has /dev/ttyUSB9 open, not "):
                await driver.open()

    asyncio.run(story())


def test_a_job_of_the_programs_own_is_left_alone(peer, program, gantry):
    async def story():
        async with program(peer) as control:
            control.connection, control.active = 3, peer.path
            driver = gantry(control.url, peer.path)
            with pytest.raises(OSError, match="is running another job"):
                await driver.open()

    asyncio.run(story())


@pytest.mark.slow
def test_a_move_that_an_earlier_life_began_is_stopped(peers, program, gantry):
    peer = peers(speed=1)

    async def story():
        async with program(peer) as control:
            first = gantry(control.url, peer.path)
            await first.open()
            await first.home(GoalContext("home"))
            move = asyncio.create_task(first.move_to(GoalContext("m"), x=700, feed=600))
            await asyncio.sleep(0.5)
            move.cancel()  # as if it had been killed: nobody tells CONTROL
            await asyncio.gather(move, return_exceptions=True)
            await first.close()
            moving = peer.move is not None
            second = gantry(control.url, peer.path)
            await second.open()
            try:
                return moving, peer.move, await second.status()
            finally:
                await second.close()

    moving, after, status = asyncio.run(story())

    assert moving and after is None
    assert (status["state"], status["homed"]) == ("idle", False)
