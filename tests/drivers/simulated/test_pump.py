"""The simulated burette doses whole steps, has a little backlash, and knows its newest dose."""

from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.pump import BACKLASH_ML, SimPump
from labrun.drivers.world import World

from ..played import played


def pump(folder: Path, **config) -> SimPump:
    return SimPump(Place("pump", {"clock": "fast", **config}, {}, folder / "pump", folder))


@pytest.mark.soak
class TestSimPump(KeepsContract):
    case = Case(
        driver="sim_pump",
        config={"clock": "fast"},
        slow={"clock": 1},
        good={"fill": {}, "dose": {"volume": 2.5}, "last_dose": {}, "halt": {}},
        needs={"dose": ["fill"]},
        lasting="dose",
    )


def test_it_doses_whole_steps_and_after_a_filling_a_little_less(tmp_path):
    async def story(driver):
        await driver.fill(GoalContext("fill"))
        doses = [await driver.dose(GoalContext(f"d{n}"), volume=0.50032) for n in range(10)]
        with pytest.raises(ActionFailed, match="TooLittle"):
            await driver.dose(GoalContext("more"), volume=6)
        return doses, await driver.last_dose(GoalContext("probe"))

    doses, last = played(pump(tmp_path), story)
    truly = World(tmp_path).look("pump")["dosed_ml"]

    assert {dose["volume"] for dose in doses} == {0.5}
    assert last == {"goal_id": "d9", "volume": 0.5, "level": 5}
    assert truly == pytest.approx(5.005 - BACKLASH_ML, abs=0.004)


def test_a_halted_dose_says_how_much_is_out_and_so_does_the_flask(tmp_path):
    import asyncio

    async def story(driver):
        await driver.fill(GoalContext("fill"))
        dose = asyncio.create_task(driver.dose(GoalContext("dose"), volume=5))
        await asyncio.sleep(0.1)
        await driver.halt(GoalContext("halt"))
        with pytest.raises(ActionFailed, match="Halted"):
            await dose
        return await driver.status()

    status = played(pump(tmp_path, clock=50), story)
    truly = World(tmp_path).look("pump")["dosed_ml"]

    assert 0 < status["dosed"] < 5
    assert status["level"] == pytest.approx(10 - status["dosed"], abs=1e-3)
    assert truly == pytest.approx(status["dosed"], abs=0.02)
