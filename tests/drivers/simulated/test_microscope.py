"""The simulated microscope is sharp at one height, and how sharp depends on what is there."""

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.simulated.microscope import SimMicroscope
from labrun.drivers.world import World

from ..played import played


@pytest.mark.slow
class TestSimMicroscope(KeepsContract):
    case = Case(
        driver="sim_microscope",
        config={"clock": "fast"},
        slow={"clock": 0.2},
        good={"look": {}},
        lasting="look",
    )


def test_it_is_sharpest_in_focus_and_a_smooth_place_is_less_sharp(tmp_path):
    place = Place("eye", {"clock": "fast"}, {}, tmp_path / "eye", tmp_path)

    async def story(driver):
        found = {}
        for x, z in [(3, 19.8), (3, 20.06), (3, 20.3), (3, 25), (1, 20.1)]:
            World(tmp_path).publish("gantry", {"x": x, "y": 0, "z": z})
            found[x, z] = (await driver.look(GoalContext(f"{x} {z}")))["sharpness"]
        return found

    found = played(SimMicroscope(place), story)

    assert max(found[3, 19.8], found[3, 20.3]) < 0.3 * found[3, 20.06]
    assert found[3, 25] == pytest.approx(4, rel=0.1)
    assert found[1, 20.1] > found[3, 20.06]  # a rough place that is not in focus
