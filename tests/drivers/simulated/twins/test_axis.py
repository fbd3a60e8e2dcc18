"""A move is a trapezoid of speed: no axis too fast, no jump, no step too many."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.drivers.simulated.twins.axis import (
    ACCELERATION_MM_PER_S2,
    SPEED_MM_PER_S,
    STEPS_PER_MM,
    plan,
    to_mm,
    to_steps,
)

places = st.tuples(*(st.floats(0, limit) for limit in (730, 810, 100)))


@given(places)
def test_whole_steps_are_never_further_than_half_a_step_away(place):
    stands = to_mm(to_steps(place))

    assert stands == pytest.approx(place, abs=0.5 / STEPS_PER_MM + 1e-9)


@given(places, places, st.floats(0, 1))
def test_no_axis_is_faster_than_it_can_be(start, end, part):
    move = plan(start, end)
    speed = move.speed_at(part * move.duration_s)
    for a, b in zip(start, end, strict=True):
        share = abs(b - a) / move.length if move.length else 0

        assert speed * share <= SPEED_MM_PER_S * (1 + 1e-9)


@given(places, places, st.floats(0, 1), st.floats(0, 1))
def test_the_way_only_grows_and_ends_at_the_end(start, end, one, other):
    move = plan(start, end)
    early, late = sorted((one * move.duration_s, other * move.duration_s))

    assert move.travelled(early) <= move.travelled(late) + 1e-9
    assert move.travelled(move.duration_s) == pytest.approx(move.length)


@given(places, places, st.floats(0, 1))
def test_a_brake_never_carries_it_past_the_end(start, end, part):
    move = plan(start, end)
    t = part * move.duration_s

    assert move.travelled(t) <= move.braked_at(t) + 1e-9
    assert move.braked_at(t) <= move.length


def test_a_long_move_has_two_ramps_and_an_even_stretch():
    move = plan((0, 0, 0), (100, 0, 0))
    ramp_s = SPEED_MM_PER_S / ACCELERATION_MM_PER_S2

    assert move.duration_s == pytest.approx(100 / SPEED_MM_PER_S + ramp_s)
    assert move.speed_at(move.duration_s / 2) == pytest.approx(SPEED_MM_PER_S)
    assert move.travelled(ramp_s) == pytest.approx(SPEED_MM_PER_S * ramp_s / 2)


def test_a_short_move_never_reaches_full_speed():
    move = plan((0, 0, 0), (0.2, 0, 0))

    assert move.peak_speed == pytest.approx((0.2 * ACCELERATION_MM_PER_S2) ** 0.5)
    assert move.duration_s == pytest.approx(2 * (0.2 / ACCELERATION_MM_PER_S2) ** 0.5)


def test_a_feed_slows_it_down():
    assert plan((0, 0, 0), (10, 0, 0), 60).peak_speed == 1.0


def test_a_diagonal_may_be_faster_than_one_axis():
    assert plan((0, 0, 0), (300, 300, 0)).speed == pytest.approx(SPEED_MM_PER_S * 2**0.5)


def test_no_way_takes_no_time():
    assert plan((1, 2, 3), (1, 2, 3)).duration_s == 0
