"""The simulated leak sensor latches, and a broken cable is not a dry floor."""

from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.simulated.leak_sensor import SimLeakSensor

from ..played import played


def sensor(folder: Path, **config) -> SimLeakSensor:
    place = Place("floor", {"clock": "fast", **config}, {}, folder / "floor", folder)
    return SimLeakSensor(place)


@pytest.mark.slow
class TestSimLeakSensor(KeepsContract):
    case = Case(
        driver="sim_leak_sensor",
        config={"clock": "fast"},
        slow={"clock": 0.2},
        good={"read": {}, "reset": {}, "last_reset": {}},
        lasting="read",
    )


def test_water_that_has_dried_is_an_alarm_until_it_is_reset(tmp_path):
    async def story(driver):
        seen = []
        for step in ("read", "read", "reset", "read", "reset", "read"):
            try:
                found = await getattr(driver, step)(GoalContext(step))
                seen.append(found.get("wet", step))
            except ActionFailed as fault:
                seen.append(fault.name)
        return seen

    seen = played(sensor(tmp_path, leak_after_s=0.9, dry_after_s=1.9), story)

    assert seen == [False, True, "StillWet", True, "reset", False]


def test_a_broken_cable_tells_nothing(tmp_path):
    async def story(driver):
        with pytest.raises(ActionFailed, match="WireBroken"):
            await driver.read(GoalContext("read"))
        with pytest.raises(OSError, match="cable is broken"):
            await driver.status()

    played(sensor(tmp_path, breaks_after_s=0), story)
