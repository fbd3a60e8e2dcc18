"""Controllers that were built or set otherwise do the same, to the same place."""

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext

MACHINES = {
    "it reports in inches": {"settings": {13: 1}},
    "it reports work positions": {"settings": {10: 0}},
    "it reports work positions in inches": {"settings": {10: 0, 13: 1}},
    "it reports its buffer": {"settings": {10: 3}},
    "it homes to plus": {"settings": {23: 0}},
    "it homes to minus": {"settings": {23: 7}},
    "its axes have other steps": {"settings": {100: 80.0, 101: 160.0, 102: 400.0}},
    "its own limits are on": {"settings": {20: 1}},
    "it is grblHAL, whose own limits are on": {"hal": True, "settings": {20: 1}},
    "it is FluidNC": {"fluid": True, "settings": {20: 1}},
    "it is FluidNC, which says late that it is not homed": {"fluid": True, "tells_late": True},
    "it is FluidNC, whose scale begins elsewhere": {
        "fluid": True,
        "homes_at": (-7.0, 5.0, 3.0),
        "settings": {20: 1, 23: 2},
    },
}


async def tour(driver):
    """Corner, middle and work zero: where it says that it stands, and where it is."""
    await driver.move_to(GoalContext("a"), x=0, y=0, z=0)
    await driver.jog(GoalContext("b"), axis="y", distance=25)
    await driver.set_zero(GoalContext("c"), axes=["x", "y"])
    there = await driver.move_to(GoalContext("d"), x=123.4, y=56.7, feed=2000)
    status = await driver.status()
    back = await driver.go_to_zero(GoalContext("e"), axes=["x"])
    return there, status, back


@pytest.mark.parametrize("told", MACHINES)
def test_it_goes_to_the_same_places_where(told, peers, gantry, played):
    peer = peers(**MACHINES[told])
    driver = gantry(peer)

    there, status, back = played(driver, tour)

    near = driver.controller.settings.tolerance
    assert (there["x"], there["y"]) == pytest.approx((123.4, 56.7), abs=near)
    assert (status["work_x"], status["work_y"]) == pytest.approx((123.4, 31.7), abs=2 * near)
    assert (back["x"], back["y"]) == pytest.approx((0, 56.7), abs=near)
    assert driver.bench.to_bench(tuple(peer.place)) == pytest.approx((0, 56.7, 0), abs=near)


@pytest.mark.parametrize("hal", [False, True])
@pytest.mark.parametrize("mask", [0, 3, 7])
def test_it_goes_to_the_same_places_where_zero_is_where_it_homes(mask, hal, peers, gantry, played):
    peer = peers(hal=hal, settings={23: mask, 20: 1})
    peer.zero_where_homed = True
    driver = gantry(peer)

    there, status, _ = played(driver, tour)

    assert (there["x"], there["y"]) == pytest.approx((123.4, 56.7), abs=0.005)
    assert status["work_x"] == pytest.approx(123.4, abs=0.01)


def test_start_up_lines_of_its_own_answer_nothing_that_was_asked(peer, gantry, played):
    peer.startup = [">G54G20:ok", ">G99:error:20"]

    async def story(driver):
        return await driver.move_to(GoalContext("a"), x=3)

    assert played(gantry(peer), story)["x"] == pytest.approx(3, abs=0.005)


@pytest.mark.parametrize(
    ("command", "state", "trusted"), [("$C", "Check", True), ("$SLP", "Sleep", False)]
)
def test_halt_and_home_lead_out_of_a_state_that_only_a_reset_ends(
    command, state, trusted, peer, gantry, played
):
    async def story(driver):
        await driver.controller.ask(command)
        with pytest.raises(ActionFailed, match=f"Held: .*it is in state {state}; "):
            await driver.move_to(GoalContext("a"), x=3)
        await driver.halt(GoalContext("b"))
        halted = await driver.status()
        await driver.controller.ask("$X" if driver._locked() else "$G")
        await driver.controller.ask(command)
        await driver.home(GoalContext("c"))
        return halted, await driver.move_to(GoalContext("d"), x=3)

    halted, place = played(gantry(peer), story)

    assert halted["homed"] is trusted
    assert place["x"] == pytest.approx(3, abs=0.005)


def test_an_axis_of_grblhal_with_soft_limits_moves_alone_from_where_it_has_homed(
    peers, gantry, played
):
    async def story(driver):
        await driver.move_to(GoalContext("z"), z=0.0)
        return await driver.status()

    status = played(gantry(peers(hal=True, settings={20: 1})), story)

    assert (status["state"], status["alarm"]) == ("idle", "")
    assert (status["x"], status["y"], status["z"]) == pytest.approx((0.0, 0.0, 0.0), abs=0.006)
