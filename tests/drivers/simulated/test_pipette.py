"""The simulated pipette moves nearly the volume asked for, and knows its newest stroke."""

import asyncio
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.pipette import SimPipette
from labrun.drivers.world import World

from ..played import played


def pipette(folder: Path, **config) -> SimPipette:
    return SimPipette(Place("pipette", {"clock": "fast", **config}, {}, folder / "pipette", folder))


@pytest.mark.slow
class TestSimPipette(KeepsContract):
    case = Case(
        driver="sim_pipette",
        config={"clock": "fast"},
        slow={"clock": 2},
        good={
            "pick_up_tip": {}, "aspirate": {"volume": 200}, "dispense": {"volume": 50.5},
            "last_stroke": {}, "eject_tip": {}, "hold": {},
        },
        needs={
            "aspirate": ["pick_up_tip"], "dispense": ["pick_up_tip", "aspirate"],
            "eject_tip": ["pick_up_tip"],
        },
        lasting="pick_up_tip",
    )  # fmt: skip


def test_what_it_dispenses_weighs_nearly_a_milligram_a_microlitre(tmp_path):
    async def story(driver):
        await driver.pick_up_tip(GoalContext("tip"))
        weights = []
        for n in range(30):
            before = driver.now.dropped_mg
            await driver.aspirate(GoalContext(f"in {n}"), volume=100)
            await driver.dispense(GoalContext(f"out {n}"), volume=100)
            weights.append(driver.now.dropped_mg - before)
        return weights

    weights = played(pipette(tmp_path), story)
    mean = sum(weights) / len(weights)
    spread = (sum((w - mean) ** 2 for w in weights) / (len(weights) - 1)) ** 0.5

    assert mean == pytest.approx(100, abs=0.8)
    assert 0.2 < spread < 1.2
    assert World(tmp_path).look("pipette")["dropped_mg"] == pytest.approx(sum(weights))


def test_what_cannot_be_done_did_not_happen(tmp_path):
    async def story(driver):
        names = []

        async def refused(action, *parameters, **volume):
            with pytest.raises(ActionFailed) as failed:
                await action(GoalContext("g"), **volume)
            names.append(failed.value.name)

        await refused(driver.aspirate, volume=10)
        await driver.pick_up_tip(GoalContext("tip"))
        await refused(driver.pick_up_tip)
        await refused(driver.dispense, volume=10)
        await driver.aspirate(GoalContext("in"), volume=900)
        await refused(driver.aspirate, volume=101)
        await driver.eject_tip(GoalContext("out"))
        await refused(driver.pick_up_tip)
        return names

    names = played(pipette(tmp_path, tips=1), story)

    assert names == ["NoTip", "TipAlready", "TooLittle", "TipFull", "RackEmpty"]


def test_an_empty_reservoir_gives_air(tmp_path):
    async def story(driver):
        await driver.pick_up_tip(GoalContext("tip"))
        with pytest.raises(ActionFailed, match="NoLiquid"):
            await driver.aspirate(GoalContext("in"), volume=100)

    played(pipette(tmp_path, reservoir_ul=20), story)


def test_its_newest_stroke_outlives_its_server(tmp_path):
    async def draw(driver):
        await driver.pick_up_tip(GoalContext("tip"))
        await driver.aspirate(GoalContext("the goal"), volume=300)

    async def ask(driver):
        return await driver.last_stroke(GoalContext("probe")), await driver.status()

    played(pipette(tmp_path), draw)
    last, status = played(pipette(tmp_path), ask)

    assert last == {"goal_id": "the goal", "action": "aspirate", "volume": 300, "tips_left": 95}
    assert status == {"tip": True, "volume": 300, "tips_left": 95}


def test_ejecting_without_a_tip_does_nothing(tmp_path):
    async def story(driver):
        await driver.pick_up_tip(GoalContext("tip"))
        await driver.eject_tip(GoalContext("out"))
        await driver.eject_tip(GoalContext("again"))
        return await driver.last_stroke(GoalContext("probe"))

    last = played(pipette(tmp_path), story)

    assert last["goal_id"] == "out"
    assert [e["what"] for e in World(tmp_path).truth("pipette").entries()] == [
        "pick_up_tip",
        "eject_tip",
    ]


def test_the_safe_state_holds_a_stroke_that_has_not_begun(tmp_path):
    async def story(driver):
        stroke = asyncio.create_task(driver.pick_up_tip(GoalContext("tip")))
        await asyncio.sleep(0)
        await driver.safe()
        with pytest.raises(ActionFailed, match="stopped before the stroke") as refused:
            await stroke
        return refused.value.happened

    assert played(pipette(tmp_path), story) == "no"
