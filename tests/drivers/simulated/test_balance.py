"""The simulated balance sees what the pipette drops, after a moment, with a flicker."""

from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.balance import SimBalance
from labrun.drivers.world import World

from ..played import played


def balance(folder: Path, **config) -> SimBalance:
    return SimBalance(Place("balance", {"clock": "fast", **config}, {}, folder / "balance", folder))


def drop(folder: Path, milligrams: float) -> None:
    World(folder).publish("pipette", {"dropped_mg": milligrams})


class TestSimBalance(KeepsContract):
    case = Case(
        driver="sim_balance",
        config={"clock": "fast"},
        slow={"clock": 0.4},
        good={"zero": {}, "tare": {}, "last_tare": {}, "weigh": {"patience": 5.0}},
        lasting="weigh",
    )


def test_it_weighs_what_fell_on_the_pan_since_it_was_tared(tmp_path):
    async def story(driver):
        await driver.tare(GoalContext("t"))
        drop(tmp_path, 250.0)
        return await driver.weigh(GoalContext("w"))

    reading = played(balance(tmp_path, load_g=12.5), story)

    assert reading["stable"]
    assert reading["mass"] == pytest.approx(0.25, abs=0.002)


def test_a_reading_without_patience_is_not_stable(tmp_path):
    async def story(driver):
        drop(tmp_path, 5000.0)
        hasty = await driver.weigh(GoalContext("a"), patience=0.5)
        return hasty, await driver.weigh(GoalContext("b"))

    hasty, patient = played(balance(tmp_path), story)

    assert not hasty["stable"]
    assert hasty["mass"] < 4
    assert patient["mass"] == pytest.approx(5, abs=0.005)


def test_a_pan_that_is_not_empty_cannot_be_zeroed(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match="NotEmpty"):
            await driver.zero(GoalContext("z"))

    played(balance(tmp_path, load_g=50), story)


def test_too_heavy_a_load_is_an_overload(tmp_path):
    async def story(driver):
        with pytest.raises(
            ActionFailed, match=r"Overload: 300\.0 g on the pan; the range is 220 g"
        ):
            await driver.weigh(GoalContext("w"))

    played(balance(tmp_path, load_g=300), story)


def test_the_tare_outlives_the_server(tmp_path):
    async def tare(driver):
        await driver.tare(GoalContext("t"))

    async def weigh(driver):
        probed = await driver.last_tare(GoalContext("p"))
        return (await driver.weigh(GoalContext("w")))["mass"], await driver.status(), probed

    played(balance(tmp_path, load_g=20), tare)
    mass, status, probed = played(balance(tmp_path, load_g=20), weigh)

    assert probed["goal_id"] == "t" and probed["tare"] == pytest.approx(20, abs=0.001)
    assert mass == pytest.approx(0, abs=0.001)
    assert status["tared"]


def test_a_run_is_told_that_somebody_else_has_tared_since(tmp_path):
    async def story(driver):
        await driver.tare(GoalContext("r/t/1"))
        await driver.tare(GoalContext("call/t/1"))
        with pytest.raises(ActionFailed, match="TareLost: call/t/1 has zeroed or tared it since"):
            await driver.weigh(GoalContext("r/w/1"))
        return await driver.weigh(GoalContext("other/w/1"))

    assert played(balance(tmp_path, load_g=20), story)["stable"]


def test_the_same_goal_reads_the_same(tmp_path):
    async def story(driver):
        return [(await driver.weigh(GoalContext(goal)))["mass"] for goal in ("a", "b", "c")]

    first = played(balance(tmp_path / "one", load_g=1), story)

    assert first == played(balance(tmp_path / "two", load_g=1), story)
