"""The simulated electrode reads a weak acid with a base in it, slowly where the pH jumps."""

from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.simulated.ph_probe import SimPhProbe
from labrun.drivers.world import World

from ..played import played


def electrode(folder: Path) -> SimPhProbe:
    config = {"clock": "fast", "acid_ml": 20, "acid_m": 0.1, "titrant_m": 0.1, "pka": 4.756}
    return SimPhProbe(Place("electrode", config, {}, folder / "electrode", folder))


@pytest.mark.slow
class TestSimPhProbe(KeepsContract):
    case = Case(
        driver="sim_ph_probe",
        config={"clock": "fast"},
        slow={"clock": 1.5},
        good={"read": {"patience": 5.0}},
        lasting="read",
    )


@pytest.mark.parametrize(("dosed_ml", "ph"), [(10, 4.756), (20, 8.58), (40, 12.35)])
def test_the_flask_has_the_ph_of_the_textbook(tmp_path, dosed_ml, ph):
    """Half titrated it is the pKa; at the end point that of the acetate; then the base alone."""
    World(tmp_path).publish("pump", {"dosed_ml": float(dosed_ml)})

    assert electrode(tmp_path).true_ph() == pytest.approx(ph, abs=0.03)


def test_it_is_slow_where_the_ph_jumps_and_says_when_it_stands_still(tmp_path):
    async def story(driver):
        took = []
        for dosed_ml in (5, 8, 19.95, 20.05):
            World(tmp_path).publish("pump", {"dosed_ml": float(dosed_ml)})
            began = driver.clock.elapsed_s
            reading = await driver.read(GoalContext(f"at {dosed_ml}"))
            took.append((driver.clock.elapsed_s - began, reading))
        World(tmp_path).publish("pump", {"dosed_ml": 15.0})
        return took, await driver.read(GoalContext("hasty"), patience=1)

    took, hasty = played(electrode(tmp_path), story)

    assert all(reading["stable"] for _, reading in took) and not hasty["stable"]
    assert took[3][0] > 2 * took[1][0]
    assert took[1][1]["ph"] == pytest.approx(4.58, abs=0.1)
