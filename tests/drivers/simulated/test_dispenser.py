"""The simulated dispenser delivers nearly the volume asked for, once, and counts its bottles."""

import asyncio
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.dispenser import SimDispenser
from labrun.drivers.world import World

from ..played import played


def dispenser(folder: Path, **config) -> SimDispenser:
    config = {"clock": "fast", "liquids": ["acid", "base"], **config}
    return SimDispenser(Place("dispenser", config, {}, folder / "dispenser", folder))


@pytest.mark.slow
class TestSimDispenser(KeepsContract):
    case = Case(
        driver="sim_dispenser",
        config={"clock": "fast", "liquids": ["acid"]},
        slow={"clock": 1},
        good={
            "dispense": {"liquid": "acid", "volume": 500}, "last_dispense": {},
            "refilled": {"liquid": "acid", "volume": 200}, "last_refill": {}, "halt": {},
        },
        lasting="dispense", quick=frozenset({"refilled"}),
    )  # fmt: skip


def test_vessels_hold_nearly_what_was_asked_for_also_after_a_restart(tmp_path):
    async def fill(driver):
        for n in range(40):
            await driver.dispense(GoalContext(f"{n}"), liquid="acid", volume=100, into="A1")
        return await driver.dispense(GoalContext("one"), liquid="base", volume=50, into="A1")

    async def ask(driver):
        return await driver.last_dispense(GoalContext("probe")), await driver.status()

    result = played(dispenser(tmp_path), fill)
    last, status = played(dispenser(tmp_path), ask)
    state = World(tmp_path).look("dispenser")

    assert result == {"volume": 50, "left": 249.95}
    assert last == {"goal_id": "one", "liquid": "base", **result}
    assert status == {"dispensing": None, "left": {"acid": 246, "base": 249.95}}
    assert state["vessels"]["A1"]["acid"] == pytest.approx(4000, rel=0.006)
    assert state["vessels"]["A1"]["acid"] != 4000
    assert state["dropped_mg"] == pytest.approx(4050, rel=0.006)


def test_what_cannot_be_dispensed_did_not_happen(tmp_path):
    async def story(driver):
        async def refused(**wanted):
            with pytest.raises(ActionFailed) as failed:
                await driver.dispense(GoalContext("g"), **wanted)
            return str(failed.value)

        said = [
            await refused(liquid="salt", volume=1),
            await refused(liquid="acid", volume=1001),
            await refused(liquid="acid", volume=1, into="B7"),
        ]
        await driver.refilled(GoalContext("r"), liquid="acid", volume=5)
        await driver.dispense(GoalContext("now"), liquid="acid", volume=1001, into="A1")
        return said

    said = played(dispenser(tmp_path, bottle_ml=1, vessels=["A1", "A2"]), story)

    assert said == [
        "NoSuchLiquid: there is no salt; it has acid, base",
        "Empty: 1 mL of acid are left: fill it up",
        "NoSuchVessel: there is no B7; it reaches A1, A2",
    ]
    assert [e["what"] for e in World(tmp_path).truth("dispenser").entries()] == [
        "refilled",
        "dispense",
    ]


def test_a_halt_says_how_much_was_delivered_and_counts_it(tmp_path):
    async def story(driver):
        flow = asyncio.create_task(
            driver.dispense(GoalContext("g"), liquid="acid", volume=1000, into="A1")
        )
        while driver.flowing is None:  # noqa: ASYNC110 - a twin has no event for it
            await asyncio.sleep(0)
        await asyncio.sleep(0.1)  # 2 s of the pump's
        await driver.halt(GoalContext("h"))
        with pytest.raises(ActionFailed, match=r"Halted: .* of 1000 uL were delivered") as failed:
            await flow
        return failed.value.happened, await driver.last_dispense(GoalContext("probe"))

    happened, last = played(dispenser(tmp_path, clock=20, ul_per_s=10), story)

    assert happened is None  # the contract says: yes
    assert 0 < last["volume"] < 1000
    assert World(tmp_path).look("dispenser")["vessels"]["A1"]["acid"] == pytest.approx(
        last["volume"], rel=0.05, abs=1
    )
