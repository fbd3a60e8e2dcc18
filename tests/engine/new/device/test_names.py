"""Names from names that stand in a tree."""

from labrun.engine.new.device.names import short_names, snake


def test_a_name_is_as_short_as_it_can_be():
    paths = [("Oven", "A", "CurrentValue"), ("Oven", "B", "CurrentValue"), ("Oven", "B", "Doses")]

    assert short_names(paths) == ["a_current_value", "b_current_value", "doses"]
    assert short_names([("X",), ("X",)]) == ["x_1", "x_2"]


def test_a_name_is_one_of_a_contract():
    names = ["TargetSpeed", "pH Value", "2ndValve", "°"]

    assert [snake(one) for one in names] == ["target_speed", "p_h_value", "_2nd_valve", "_"]
