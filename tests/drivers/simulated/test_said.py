"""The twin of a device whose lab entry says its actions: it remembers, counts, and keeps the contract."""

import asyncio
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.find import BRIDGES, find_driver

LAB = Path(__file__).parent / "dmm.yaml"


def test_what_is_set_is_read_back_and_a_count_goes_up(tmp_path):
    config = Case.of_lab(LAB, "dmm").config

    async def story():
        twin = find_driver("sim_pymeasure", Path())(Place("dmm", config, {}, tmp_path, tmp_path))
        await twin.open()
        await twin.method("set_range")(GoalContext("run/1"), range=2.5)
        await twin.method("fire")(GoalContext("run/2"))
        await twin.method("ramp")(GoalContext("run/3"), range=5.0)
        asked = ("read_range", "state", "trace", "shots", "last_once")
        found = [await twin.method(n)(GoalContext("r")) for n in asked]
        await twin.close()
        return found

    assert asyncio.run(story()) == [
        {"range": 5.0}, {"at": 5.0}, {"at": []}, {"shots": 1}, {"goal_id": "run/2"},
    ]  # fmt: skip


@pytest.mark.parametrize("bridge", BRIDGES)
def test_every_bridge_has_a_twin_that_takes_its_config(bridge):
    twin, real = find_driver(f"sim_{bridge}", Path()), find_driver(bridge, Path())

    assert issubclass(twin.config_model, real.config_model)


@pytest.mark.slow
class TestSimDmm(KeepsContract):
    case = Case.of_lab(LAB, "dmm")
