"""G-code of moves, as people and the paper's programs write it."""

import pytest

from labrun.web.ros.aliases.gcode import GcodeFault, Step, steps

HERE = {"x": 10.0, "y": 20.0, "z": 5.0}


def places(program):
    return [dict(step.place_mm) for step in steps(program, HERE)]


def test_absolute_and_relative_moves():
    assert places("G90 G0 X1 Y2\nG91 G1 X1 Z-2") == [{"x": 1, "y": 2}, {"x": 2, "z": 3}]


def test_words_stand_close_or_apart_in_either_case_with_numbers_and_comments():
    assert places("N10 g0x1.5y.5 (over there) ; and stay\n\n%".replace("%", "")) == [
        {"x": 1.5, "y": 0.5}
    ]


def test_inches_are_millimetres_in_the_end():
    assert places("G20 G0 X1\nG21 G0 X1") == [{"x": 25.4}, {"x": 1}]


def test_a_feed_counts_for_g1_alone():
    assert [step.feed_mm_min for step in steps("G1 X1 F600\nG0 X2\nG1 X3", HERE)] == [
        600,
        None,
        600,
    ]


def test_homing_is_a_step_of_its_own():
    assert steps("$H\nG0 X1", HERE)[0] == Step("home")


@pytest.mark.parametrize(
    "program", ["G2 X1 Y1 I1", "M5", "G0 Xfar", "G0 X1e3", "G0 X1 X2", "!", "G92 X0", ""]
)
def test_anything_else_is_refused(program):
    with pytest.raises(GcodeFault):
        steps(program, HERE)


def test_a_relative_move_from_nowhere_is_refused():
    with pytest.raises(GcodeFault, match="unknown position"):
        steps("G91 G0 X1", {})


def test_where_homing_ends_is_not_known():
    with pytest.raises(GcodeFault, match="x is relative to an unknown position"):
        steps("$H\nG91 G0 X1", {"x": 5.0})
