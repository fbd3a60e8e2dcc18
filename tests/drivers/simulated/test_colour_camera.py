"""The simulated colour camera sees what the dispenser has mixed."""

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.colour_camera import SimColourCamera, colour
from labrun.drivers.world import World

from ..played import played

MIXED = {"vessels": {"vessel": {"red": 50.0, "water": 50.0}, "A1": {"blue": 30.0}}}


@pytest.mark.slow
class TestSimColourCamera(KeepsContract):
    case = Case(
        driver="sim_colour_camera",
        config={"clock": "fast"},
        slow={"clock": 0.4},
        good={"look": {}},
        lasting="look",
    )

    def peer(self, folder, *, slow):
        World(folder / "world").publish("dispenser", MIXED)
        return super().peer(folder, slow=slow)


def test_dyes_darken_what_they_absorb_and_an_empty_well_has_no_colour(tmp_path):
    World(tmp_path).publish("dispenser", MIXED)

    async def story(driver):
        seen = await driver.look(GoalContext("1")), await driver.look(GoalContext("2"), into="A1")
        with pytest.raises(ActionFailed, match="Nothing: there is nothing in B7"):
            await driver.look(GoalContext("3"), into="B7")
        return seen

    camera = SimColourCamera(Place("camera", {"clock": "fast"}, {}, tmp_path / "camera", tmp_path))
    red, blue = played(camera, story)

    assert red["red"] > 230 > 160 > red["green"]
    assert blue["blue"] > 220 > 100 > blue["red"]
    assert colour({"water": 1.0}) == (250, 250, 250)
    assert [red[c] for c in ("red", "green", "blue")] == pytest.approx(
        colour(MIXED["vessels"]["vessel"]), abs=4
    )
