"""Bench coordinates become machine coordinates, and what is out of reach is refused."""

import math

import pytest

from labrun.drivers.driver import ActionFailed
from labrun.drivers.grbl.settings import Settings
from labrun.drivers.motion.bench import bench_from_here, read_bench

LEAD = Settings.read(
    ["130=810.000", "131=730.000", "132=90.000", "22=1", "23=3", "27=5.000", "100=199.1"]
)
WHOLE = {"x": (0.0, 730.0), "y": (0.0, 810.0), "z": (0.0, 100.0)}


def test_zero_is_by_default_the_corner_at_the_minus_end():
    bench = read_bench({}, WHOLE, LEAD.ranges)

    assert bench.origin == (-805.0, -725.0, -90.0)
    assert bench.to_bench((-805.003, -725.003, -5.003)) == pytest.approx((-0.003, -0.003, 84.997))


def test_the_reach_is_the_smallest_of_contract_lab_and_machine():
    bench = read_bench({}, {**WHOLE, "z": (10.0, 60.0)}, LEAD.ranges)

    assert (bench.low, bench.high) == ((0.0, 0.0, 10.0), (730.0, 725.0, 60.0))


def test_an_origin_of_ones_own_moves_everything():
    bench = read_bench({"origin": {"x": -700}}, WHOLE, LEAD.ranges)

    assert bench.to_machine(0, 10.0) == (0, -690.0)
    assert bench.high[0] == 700.0


def test_a_firmware_whose_zero_is_where_it_homes_has_its_reach_on_the_other_side():
    lines = [f"{number}={value}" for number, value in LEAD.values.items()]
    bench = read_bench({}, WHOLE, Settings.read(lines, "VZ").ranges)

    assert bench.origin == (0.0, 0.0, -85.0)
    assert (bench.low, bench.high) == ((0.0, 0.0, 0.0), (730.0, 725.0, 85.0))
    assert bench.to_bench((0.0, 0.0, 0.0)) == (0.0, 0.0, 85.0)


def test_axes_may_be_turned():
    bench = read_bench({"axes": {"x": "Y", "y": "-X"}}, WHOLE, LEAD.ranges)

    assert bench.to_machine(0, 10.0) == (1, -715.0)
    assert bench.to_machine(1, 10.0) == (0, -10.0)
    assert bench.to_bench((-10.0, -715.0, -90.0)) == (10.0, 10.0, 0.0)
    assert bench.high[1] == 805.0


def test_a_machine_without_switches_stands_where_somebody_put_it():
    bench = bench_from_here({"home_here": {"z": 50}}, WHOLE, (1.0, 2.0, 3.0))

    assert bench.to_bench((1.0, 2.0, 3.0)) == (0.0, 0.0, 50.0)
    assert bench.high == (730.0, 810.0, 100.0)


@pytest.mark.parametrize("value", [-0.1, 730.1, math.nan, math.inf, -math.inf])
def test_what_is_out_of_reach_or_no_number_is_refused(value):
    with pytest.raises(ActionFailed, match=r"SoftLimit: g was not moved: x .* is outside 0 to 730"):
        read_bench({}, WHOLE, LEAD.ranges).check_range({"x": value}, "g")


CLAMP = {"keep_out": [{"name": "clamp", "x": [100, 140], "y": [50, 100], "z": [0, 35]}]}


@pytest.mark.parametrize(
    ("start", "end", "fine"),
    [
        ((0, 75, 10), (200, 75, 10), False),  # straight through
        ((0, 75, 40), (200, 75, 40), True),  # over it
        ((0, 0, 10), (200, 0, 10), True),  # past it
        ((0, 75, 10), (120, 75, 10), False),  # into it
        ((80, 40, 10), (150, 110, 10), False),  # across a corner
        ((120, 75, 10), (120, 75, 60), True),  # out of it
        ((120, 75, 10), (130, 75, 10), False),  # on within it
        ((0, 50, 0), (200, 50, 0), True),  # along its face
    ],
)
def test_the_way_may_not_go_through_a_keep_out_box(start, end, fine):
    bench = read_bench(CLAMP, WHOLE, LEAD.ranges)
    if fine:
        bench.check_path(start, end, "g")
    else:
        with pytest.raises(ActionFailed, match=r"keep-out box `clamp` \(x 100 to 140"):
            bench.check_path(start, end, "g")


def test_a_held_jog_stops_at_the_box_and_at_the_edge():
    bench = read_bench(CLAMP, WHOLE, LEAD.ranges)

    assert bench.reach((0, 75, 10), {0: 1}) == pytest.approx(100.01)
    assert bench.reach((200, 75, 10), {0: -1}) == pytest.approx(60.01)
    assert bench.reach((200, 75, 10), {0: 1}) == 530.0
    assert bench.reach((0, 0, 10), {2: -1}) == 10.0
    assert bench.reach((40, 0, 10), {0: 1, 1: 1}) == pytest.approx(60.01)
    assert bench.reach((10, 5, 60), {0: -1, 1: -1, 2: -1}) == 5.0


def test_a_held_jog_without_switches_stops_at_the_box():
    bench = bench_from_here({"home_here": {"x": 0, "y": 75, "z": 10}, **CLAMP}, {}, (0.0, 0.0, 0.0))

    assert bench.reach((0, 75, 10), {0: 1}) == pytest.approx(100.01)
    assert bench.reach((0, 75, 10), {0: -1}) == math.inf
