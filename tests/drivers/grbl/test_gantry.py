"""The driver on a GRBL peer: moves, places, work zero, hold, and every way in which they fail."""

import asyncio
import contextlib

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.drivers.find import check_driver
from labrun.drivers.grbl import controller
from labrun.drivers.grbl.gantry import Grbl
from labrun.drivers.motion.faults import Silent
from labrun.drivers.world import World
from labrun.schemas.contracts import shipped_contracts

PEER = {"x": -805.0, "y": -725.0, "z": -90.0}


def lines(peer):
    """What the peer heard, without questions and boot."""
    return [line for line in peer.heard if line not in ("?", "$$", "$I", "$H")]


def test_it_keeps_the_contract():
    check_driver(Grbl, shipped_contracts()["gantry@1"])


def test_it_stands_where_it_was_sent(peer, gantry, played):
    async def story(driver):
        return await driver.move_to(GoalContext("m"), x=0.2, y=1.0, z=10)

    place = played(gantry(peer), story)

    for axis, wanted, true in zip("xyz", (0.2, 1.0, 10.0), peer.place, strict=True):
        assert place[axis] == pytest.approx(wanted, abs=0.005)
        assert true - PEER[axis] == pytest.approx(wanted, abs=0.005)


def test_a_move_is_proved_by_the_answer_to_a_dwell_and_axes_left_out_are_not_named(
    peer, gantry, played
):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=5)
        await driver.move_to(GoalContext("b"), z=20, feed=600)

    played(gantry(peer), story)

    assert lines(peer) == [
        "G21G90G94G53G0X-800.0000",
        "G4P0",
        "G21G90G94G53G1Z-70.0000F600.000",
        "G4P0",
    ]


def test_it_has_not_succeeded_before_it_stands(peers, gantry, played):
    peer = peers(speed=4)

    async def story(driver):
        for x in (8, 16, 24, 32):
            await driver.move_to(GoalContext("m"), x=x)
            assert peer.move is None
            assert peer.place[0] - PEER["x"] == pytest.approx(x, abs=0.005)

    played(gantry(peer), story)


@pytest.mark.parametrize(
    "wanted",
    [{"x": 731}, {"y": 725.1}, {"z": -0.1}, {"x": float("nan")}, {"x": 1, "z": float("inf")}],
)
def test_a_place_out_of_reach_is_refused_before_a_byte_is_sent(peer, gantry, played, wanted):
    async def story(driver):
        before = list(peer.heard)
        with pytest.raises(ActionFailed, match=r"SoftLimit: gantry .* was not moved"):
            await driver.move_to(GoalContext("m"), **wanted)
        return peer.heard == before

    assert played(gantry(peer), story)


def test_a_keep_out_box_is_gone_around(peer, gantry, played):
    box = {"name": "clamp", "x": [10, 20], "z": [0, 30]}

    async def story(driver):
        await driver.move_to(GoalContext("a"), z=5)
        with pytest.raises(ActionFailed, match="goes through the keep-out box `clamp`"):
            await driver.move_to(GoalContext("b"), x=40)
        await driver.move_to(GoalContext("c"), z=31)
        await driver.move_to(GoalContext("d"), x=40)
        return await driver.move_to(GoalContext("e"), z=5)

    place = played(gantry(peer, keep_out=[box]), story)

    assert (place["x"], place["z"]) == pytest.approx((40, 5), abs=0.005)


def test_without_homing_nothing_moves(peer, gantry, played):
    async def story(driver):
        with pytest.raises(ActionFailed, match=r"NotHomed: .* home it first") as caught:
            await driver.move_to(GoalContext("m"), x=5)
        return caught.value.happened

    assert played(gantry(peer), story, homed=False) == "no"
    assert lines(peer) == []


def test_the_first_move_may_home_by_itself(peer, gantry, played):
    async def story(driver):
        return await driver.move_to(GoalContext("m"), x=5)

    assert played(gantry(peer, home_first=True), story, homed=False)["x"] == pytest.approx(
        5, abs=0.005
    )
    assert peer.heard.count("$H") == 1


def test_a_work_zero_is_set_and_gone_to(peer, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=30, y=40, z=50)
        zero = await driver.set_zero(GoalContext("b"), axes=["x", "y"])
        probe = await driver.last_by_hand(GoalContext("c"))
        await driver.move_to(GoalContext("d"), x=100, y=100, z=60)
        far = await driver.status()
        place = await driver.go_to_zero(GoalContext("e"), axes=["y", "x"])
        return zero, probe, far, place

    zero, probe, far, place = played(gantry(peer), story)

    assert (zero["x"], zero["y"]) == pytest.approx((30, 40), abs=0.005)
    assert probe == {"goal_id": "b", **zero}
    assert (far["work_x"], far["work_y"]) == pytest.approx((70, 60), abs=0.01)
    assert (place["x"], place["y"], place["z"]) == pytest.approx((30, 40, 60), abs=0.005)
    assert "G10L20P0X0Y0" in lines(peer)


def test_a_work_zero_does_not_move_the_bench(peer, gantry, played):
    async def story(driver):
        await driver.move_to(GoalContext("a"), x=30)
        await driver.set_zero(GoalContext("b"))
        return await driver.move_to(GoalContext("c"), x=30)

    assert played(gantry(peer), story)["x"] == pytest.approx(30, abs=0.005)


@pytest.mark.parametrize("settings", [{10: 0}, {10: 2}, {10: 3}])
def test_reports_of_either_kind_are_understood(peers, gantry, played, settings):
    peer = peers(settings=settings)

    async def story(driver):
        await driver.move_to(GoalContext("a"), x=30)
        await driver.set_zero(GoalContext("b"))
        return await driver.move_to(GoalContext("c"), x=60)

    assert played(gantry(peer), story)["x"] == pytest.approx(60, abs=0.005)
    assert peer.place[0] - PEER["x"] == pytest.approx(60, abs=0.005)


def test_grblhal_does_the_same(peers, gantry, played):
    peer = peers(hal=True)

    async def story(driver):
        await driver.move_to(GoalContext("a"), x=30, y=5)
        return await driver.jog(GoalContext("b"), axis="y", distance=3)

    assert played(gantry(peer), story)["y"] == pytest.approx(8, abs=0.01)


@pytest.mark.parametrize("noise", [b"\xff\x80\x00", b"~#", b"\x00\xfe<"])
def test_noise_on_the_line_does_no_harm(peers, gantry, played, noise):
    peer = peers(noise=noise)

    async def story(driver):
        for x in range(1, 20):
            await driver.move_to(GoalContext("m"), x=x)
        return await driver.status()

    status = played(gantry(peer), story)

    assert (status["state"], status["x"]) == ("idle", pytest.approx(19, abs=0.005))


def test_a_digit_that_noise_has_changed_is_told_nowhere_and_gone_by_nowhere(peer, gantry, played):
    async def story(driver):
        await driver.set_zero(GoalContext("z"), axes=["x"])
        await driver.move_to(GoalContext("m"), x=20)
        peer.garbles = [("MPos:-785", "MPos:-285")]
        status = await driver.status()
        peer.garbles = [("WCO:-805", "WCO:-705")]
        while peer.garbles:
            await driver.status()
        zero = await driver.go_to_zero(GoalContext("g"), axes=["x"])
        peer.garbles = [("-5.003|", "-15.003|")]
        with pytest.raises(ActionFailed, match="touched nothing"):
            await driver.touch(GoalContext("t"), to=84.0, feed=600)
        return status, zero, await driver.status()

    status, zero, stood = played(gantry(peer), story)

    assert (status["x"], zero["x"]) == pytest.approx((20, 0), abs=0.006)
    assert stood["z"] == pytest.approx(84, abs=0.006)


@pytest.mark.parametrize("line", ["G53", "G4"])
def test_an_ok_that_is_lost_is_made_up_for(peer, gantry, played, line):
    async def story(driver):
        peer.eats_ok_of = line
        return await driver.move_to(GoalContext("m"), x=7)

    assert played(gantry(peer), story)["x"] == pytest.approx(7, abs=0.005)


def test_an_ok_that_never_comes_costs_no_other_line(peer, gantry, played):
    async def story(driver):
        for _ in range(2):
            peer.eats_ok_of = "G10"
            with pytest.raises(Silent):
                await driver.controller.ask("G10L20P0X0", 0.5)
            await driver.controller.ask("G10L20P0X0")
        return await driver.move_to(GoalContext("m"), x=200)

    assert played(gantry(peer), story)["x"] == pytest.approx(200, abs=0.005)


def test_an_answer_that_comes_much_later_settles_no_other_line(peer, gantry, played):
    """Somebody presses feed hold, a question is given up, and resume is pressed much later."""

    async def story(driver):
        c = driver.controller
        c.write(controller.HOLD)
        with pytest.raises(Silent):
            await c.ask("G4P0", 0.1)
        await asyncio.sleep(0.3)
        peer.eats_ok_of = "G10"
        own = c.say("G10L20P0X0")
        c.write(controller.RESUME)
        async with asyncio.timeout(500):
            while "G10L20P0X0" not in peer.heard:  # noqa: ASYNC110 - the controller is another thread
                await asyncio.sleep(0.01)
            await c.look()
        early = own.done()
        peer.say("ok")
        await asyncio.wait_for(own, 500)
        await driver.move_to(GoalContext("m"), x=7)
        return early

    assert not played(gantry(peer), story)


def test_an_emergency_stop_between_two_reads_is_told_as_what_it_is(peer, gantry, played):
    async def story(driver):
        c = driver.controller
        look = c.look

        async def restarted_before(*args):
            if peer.heard[-2:].count("G4P0"):  # the proof was answered; the place is read next
                peer._power_on()
                await asyncio.sleep(0.3)
            return await look(*args)

        c.look = restarted_before
        with pytest.raises(ActionFailed) as stopped:
            await driver.move_to(GoalContext("m"), x=3)
        return stopped.value.name, stopped.value.message

    error, message = played(gantry(peer), story)

    assert error == "Alarm"
    assert "emergency stop" in message


def test_a_question_that_noise_has_eaten_is_asked_again(peer, gantry, played):
    async def story(driver):
        peer.loses_questions = 1
        return await driver.move_to(GoalContext("m"), x=7)

    assert played(gantry(peer), story)["x"] == pytest.approx(7, abs=0.005)


def test_a_move_that_ends_elsewhere_is_no_success(peer, gantry, played):
    async def story(driver):
        obey = peer._obey
        peer._obey = lambda text: obey(text.replace("X-795.0000", "X-795.5000"))
        with pytest.raises(ActionFailed, match=r"WrongPlace.*at X -795.500 instead of X -795.000"):
            await driver.move_to(GoalContext("m"), x=10)

    played(gantry(peer), story)


def test_status_tells_that_it_moves(peers, gantry, played):
    peer = peers(speed=2)

    async def story(driver):
        told = []
        goal = GoalContext("m", tell=lambda part, words: told.append(part))
        move = asyncio.create_task(driver.move_to(goal, x=40))
        await asyncio.sleep(0.3)
        status = await driver.status()
        await move
        return status, told

    status, told = played(gantry(peer), story)

    assert status["state"] == "moving"
    assert 0 < status["x"] < 40
    assert status["feed"] > 0
    assert told == sorted(told) and told[-1] == pytest.approx(1, abs=0.001)


def test_a_simulated_instrument_that_rides_on_it_sees_where_it_is(peer, gantry, played, tmp_path):
    async def story(driver):
        await driver.move_to(GoalContext("m"), x=12, y=34, z=5)

    played(gantry(peer), story)

    seen = World(tmp_path).look("gantry")
    assert (seen["x"], seen["y"], seen["z"]) == pytest.approx((12, 34, 5), abs=0.005)


def test_hold_and_resume(peers, gantry, played):
    peer = peers(speed=4)

    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("m"), x=100))
        await asyncio.sleep(0.3)
        await driver.hold(GoalContext("h"))
        held = await driver.status()
        await asyncio.sleep(0.2)
        assert (await driver.status())["x"] == held["x"] and not move.done()
        await driver.resume(GoalContext("r"))
        return held, await move

    held, place = played(gantry(peer), story)

    assert held["state"] == "hold" and 0 < held["x"] < 100
    assert place["x"] == pytest.approx(100, abs=0.005)


def test_a_move_of_another_program_is_held_and_gone_on_with(peers, gantry, played):
    peer = peers(homing_s=0.1)

    async def story(driver):
        driver.controller.write(b"G53G1X-700F600\n")
        while (await driver.status())["state"] != "moving":  # noqa: ASYNC110 - it has to be asked
            await asyncio.sleep(0.02)
        await driver.hold(GoalContext("h"))
        held = await driver.status()
        await driver.resume(GoalContext("r"))
        resumed = await driver.status()
        await driver.halt(GoalContext("end"))
        return held, resumed

    held, resumed = played(gantry(peer), story)

    assert (held["state"], held["feed"]) == ("hold", 0)
    assert resumed["state"] == "moving"


@pytest.mark.parametrize(
    ("line", "when"),
    [("$100=100", "at rest"), ("$13=1", "asked"), ("$100=100", "in a move"), ("$101=180", "at 0")],
)
def test_a_scale_that_another_program_has_changed_is_told_before_a_move(
    peers, gantry, played, line, when
):
    peer = peers(homing_s=0.1, speed=200)

    async def story(driver):
        told = rf"has changed \{line[:3]}.*; home it"
        to = {"y": 725} if when == "at 0" else {"x": 20}  # machine y 0, in any scale
        moving = asyncio.create_task(driver.move_to(GoalContext("m"), **to))
        if when == "in a move":
            while "G4P0" not in peer.heard:  # noqa: ASYNC110 - the peer is a thread
                await asyncio.sleep(0.001)
            driver.controller.port.write(line.encode() + b"\n")
            with contextlib.suppress(ActionFailed):  # where its end is looked at after that
                await moving
        else:
            await moving
            await driver.controller.ask(line)
        stood = list(peer.steps)
        if when == "asked":
            assert "x" not in await driver.status()
        with pytest.raises(ActionFailed, match=told):
            await driver.move_to(GoalContext("n"), x=30)
        assert peer.steps == stood
        await driver.home(GoalContext("h"))
        return await driver.move_to(GoalContext("o"), x=30)

    place = played(gantry(peer), story)

    assert place["x"] == pytest.approx(30, abs=0.006)
    assert peer.place[0] - PEER["x"] == pytest.approx(30, abs=0.006)


@pytest.mark.parametrize("fluid", [False, True])
def test_bench_zero_stays_at_its_corner_though_another_program_has_changed_the_travel(
    peers, gantry, played, fluid
):
    peer = peers(homing_s=0.1, speed=200, fluid=fluid)

    async def story(driver):
        await driver.controller.ask("$130=500")
        peer.homes_at = (50.0, 0.0, 0.0)  # mpos_mm
        await driver.home(GoalContext("h"))
        return await driver.status(), driver.bench.high[0]

    status, high = played(gantry(peer), story)

    assert (status["x"], high) == (pytest.approx(0, abs=0.006), 500 if fluid else 495)


def test_a_hold_where_nothing_moves_is_not_kept_for_the_next_move(peer, gantry, played):
    async def story(driver):
        await driver.hold(GoalContext("h"))
        return await driver.move_to(GoalContext("m"), x=5)

    assert played(gantry(peer), story)["x"] == pytest.approx(5, abs=0.005)
    assert "!" not in peer.heard


def test_a_hold_in_the_last_moment_of_a_move_waits_for_its_resume_and_is_no_wrong_place(
    peers, gantry, played
):
    peer = peers(speed=2, homing_s=0.1)

    async def story(driver):
        peer.held_late = True
        move = asyncio.create_task(driver.move_to(GoalContext("m"), x=5))
        while peer.state != "Hold:0":  # noqa: ASYNC110 - the peer is another thread's
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.2)
        held, done = await driver.status(), move.done()
        await driver.resume(GoalContext("r"))
        return held, done, await move

    held, done, ended = played(gantry(peer), story)

    assert held["state"] == "hold" and not done
    assert ended["x"] == pytest.approx(5, abs=0.005)


def test_a_resume_that_comes_while_it_still_brakes_is_not_lost(peers, gantry, played):
    peer = peers(speed=3, homing_s=0.1)

    async def story(driver):
        move = asyncio.create_task(driver.move_to(GoalContext("m"), x=60))
        while peer.place[0] < -780:  # noqa: ASYNC110 - the peer is another thread's
            await asyncio.sleep(0.01)
        driver.controller.write(b"!")
        while peer.state != "Hold:1":  # noqa: ASYNC110 - as above
            await asyncio.sleep(0.001)
        await driver.resume(GoalContext("r"))
        return await move

    assert played(gantry(peer), story)["x"] == pytest.approx(60, abs=0.005)
    assert peer.heard.count("~") == 1


def test_what_somebody_else_has_on_hold_is_not_moved_and_can_be_halted(peer, gantry, played):
    async def story(driver):
        driver.controller.write(b"!")
        await asyncio.sleep(0.1)
        await driver.status()
        with pytest.raises(ActionFailed, match=r"Held: .*state Hold; resume or halt it first"):
            await driver.move_to(GoalContext("m"), x=5)
        await driver.halt(GoalContext("h"))
        return await driver.move_to(GoalContext("m"), x=5)

    assert played(gantry(peer), story)["x"] == pytest.approx(5, abs=0.005)


def test_a_machine_without_switches_is_told_where_it_stands(peers, gantry, played):
    peer = peers(settings={22: 0})

    async def story(driver):
        return await driver.move_to(GoalContext("m"), x=15)

    place = played(gantry(peer, home_here={"x": 10, "y": 20, "z": 30}), story)

    assert (place["x"], place["y"], place["z"]) == pytest.approx((15, 20, 30), abs=0.005)
    assert peer.place[0] == pytest.approx(5, abs=0.005)


def test_a_cancel_brakes_on_the_path_and_the_place_is_still_trusted(peers, gantry, played):
    peer = peers(speed=4)

    async def story(driver):
        goal = GoalContext("m")
        move = asyncio.create_task(driver.move_to(goal, x=200))
        await asyncio.sleep(0.3)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="stopped at x"):
            await move
        status = await driver.status()
        return status, await driver.move_to(GoalContext("n"), x=1)

    status, place = played(gantry(peer), story)

    assert (status["state"], status["homed"]) == ("idle", True)
    assert 0 < status["x"] < 200
    assert peer.place[0] - PEER["x"] == pytest.approx(place["x"], abs=0.005)
