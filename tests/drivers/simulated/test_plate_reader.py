"""The simulated reader sees all that a well holds, and saturates without a word."""

from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.simulated.plate_reader import SimPlateReader
from labrun.drivers.world import World

from ..played import played


def reader(folder: Path) -> SimPlateReader:
    config = {"clock": "fast", "absorbs": {"dye": 10}}
    return SimPlateReader(Place("reader", config, {}, folder / "reader", folder))


@pytest.mark.slow
class TestSimPlateReader(KeepsContract):
    case = Case(
        driver="sim_plate_reader",
        config={"clock": "fast"},
        slow={"clock": 0.5},
        good={"read": {"well": "A1"}},
        bad={"read": [{"well": "I1"}, {"well": "A13"}]},
        lasting="read",
    )


def test_it_follows_beer_to_two_and_never_shows_more_than_three(tmp_path):
    volumes_ul = {"A1": 0, "A2": 10, "A3": 30, "A4": 60, "A5": 100, "A6": 200}

    async def story(driver):
        filled = {well: {"dye": v, "water": 200 - v} for well, v in volumes_ul.items()}
        filled["B2"] = {"dye": 10, "water": 50}  # the rest has evaporated
        World(tmp_path).publish("dispenser", {"vessels": filled})
        reads = {w: await driver.read(GoalContext(w), well=w) for w in filled}
        return {well: read["absorbance"] for well, read in reads.items()}

    shown = played(reader(tmp_path), story)
    truly = {well: 0.04 + 10 * v / 1000 / 0.34 for well, v in volumes_ul.items()}

    for well in ("A1", "A2", "A3", "A4"):
        assert shown[well] == pytest.approx(truly[well], rel=0.04)
    assert shown["B2"] == pytest.approx(shown["A2"], abs=0.01)
    assert 2 < shown["A5"] < truly["A5"] - 0.2
    assert shown["A6"] == pytest.approx(3, abs=0.1) and truly["A6"] > 5
