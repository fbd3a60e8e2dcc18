"""What is said of a controller's settings."""

import pytest

from labrun.drivers.grbl.advice import advice
from labrun.drivers.grbl.firmware import firmware_of
from labrun.drivers.grbl.settings import Settings

from .peer import SETTINGS

GOOD = {**SETTINGS, 1: 255, 20: 1, 130: 725.0}


def told(changes):
    return [one.line or one.why for one in advice(Settings({**GOOD, **changes}))]


def test_good_settings_need_nothing():
    assert told({}) == []


def test_each_setting_that_costs_the_position_is_named():
    for number, value in ((1, 25), (20, 0), (21, 0), (22, 0)):
        (line,) = told({number: value})

        assert line.startswith(f"${number}=")


@pytest.mark.parametrize(("banner", "moves"), [("GrblHAL 1.1f", True), ("Grbl 1.1h", False)])
def test_soft_limits_that_move_bench_zero_are_told_as_such(banner, moves):
    settings = Settings({**GOOD, 20: 0}, firmware=firmware_of(banner))
    (one,) = advice(settings)

    assert one.line == "$20=1"
    assert ("bench zero moves" in one.why) == moves


def test_an_axis_longer_than_gantry_1_goes_is_told():
    (why,) = told({130: 810.0})

    assert "X travels 810 mm ($130), and gantry@1 goes to 730 along x" in why
    assert "gantry@2" in why


def test_the_firmwares_own_defaults_are_no_measurement():
    (why,) = told({102: 250.0, 132: 200.0})

    assert "Z has the firmware's own defaults" in why
