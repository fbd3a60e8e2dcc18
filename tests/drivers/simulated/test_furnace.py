"""The simulated furnace follows its controller: up in time, a little too far, down more slowly."""

from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext, Place
from labrun.drivers.simulated.furnace import SimFurnace

from ..played import played

HOUR = 3600


def furnace(folder: Path, **config) -> SimFurnace:
    place = Place("furnace", {"clock": "fast", **config}, {}, folder / "furnace", folder)
    return SimFurnace(place)


@pytest.mark.soak
class TestSimFurnace(KeepsContract):
    case = Case(
        driver="sim_furnace",
        config={"clock": "fast"},
        slow={"clock": 200},
        good={
            "ramp": {"to": 60, "rate": 5}, "hold": {"duration": 1200}, "last_hold": {}, "off": {},
        },
        needs={"hold": ["ramp"]},
        lasting="ramp",
    )  # fmt: skip

    def is_safe(self, status):
        return status["state"] == "off"


def test_it_overshoots_holds_and_comes_down_no_faster_than_its_walls_let_it(tmp_path):
    async def story(driver):
        clock, at = driver.clock, []
        up = await driver.ramp(GoalContext("up"), to=850, rate=5)
        at.append(clock.elapsed_s)
        held = await driver.hold(GoalContext("hold"), duration=HOUR)
        at.append(clock.elapsed_s)
        again = await driver.ramp(GoalContext("again"), to=850, rate=5)
        at.append(clock.elapsed_s)
        await driver.ramp(GoalContext("down"), to=300, rate=5, within=10)
        at.append(clock.elapsed_s)
        return up, held, again, at, await driver.last_hold(GoalContext("probe"))

    up, held, again, at, last = played(furnace(tmp_path), story)

    assert 830 / 5 * 60 < at[0] < 1.25 * 830 / 5 * 60
    assert 852.5 < up["highest"] < 865
    assert at[1] - at[0] == held["held"] == HOUR
    assert held["mean"] == pytest.approx(850, abs=1.5)
    assert 848 < held["lowest"] <= held["mean"] < held["highest"] < 852
    assert at[2] == at[1] and again["temperature"] == pytest.approx(850, abs=2)
    assert at[3] - at[2] > 1.4 * 550 / 5 * 60
    assert last == {"goal_id": "hold", **held}


def test_its_controller_takes_another_end_in_mid_ramp_and_stays_where_it_is_cancelled(tmp_path):
    async def story(driver):
        goal = GoalContext("up")
        goal.tell = lambda progress, words: driver.clock.elapsed_s > HOUR and goal.cancelled.set()
        with pytest.raises(ActionCanceled, match="it stays at 3"):
            await driver.ramp(goal, to=900, rate=5)
        stays = await driver.status()
        down = await driver.ramp(GoalContext("down"), to=200, rate=5)
        return stays, down

    stays, down = played(furnace(tmp_path), story)

    assert stays["state"] == "holding" and stays["set_point"] == pytest.approx(320, abs=5)
    assert down["highest"] < 340


def test_a_computer_that_dies_stops_nothing(tmp_path):
    async def begins(driver):
        driver.now.state, driver.now.target_c, driver.now.k_per_s = "ramping", 500.0, 0.1
        driver._keep()

    async def looks(driver):
        driver._at_s -= HOUR * driver.clock.speed / 100_000  # as if the server had been down
        return await driver.status()

    played(furnace(tmp_path, clock=100_000), begins)
    status = played(furnace(tmp_path, clock=100_000), looks)

    assert status["state"] == "ramping" and status["temperature"] > 200


def test_without_its_thermocouple_it_is_off_and_has_no_temperature_to_tell(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match="SensorBroken"):
            await driver.ramp(GoalContext("up"), to=850, rate=5)
        with pytest.raises(ActionFailed, match="SensorBroken"):
            await driver.status()
        return driver.now.state

    assert played(furnace(tmp_path, sensor_breaks_after_s=HOUR), story) == "off"
