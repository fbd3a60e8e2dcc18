"""Places in messages, and what lies there."""

import math

import pytest

from labrun.drivers.ros_action.field_path import gap, get, put, read_path
from labrun.drivers.ros_action.spots import quaternion_of, read_spots, yaw_of


def test_a_path_goes_through_lists_and_messages_there_and_back():
    message: dict = {"points": [{"velocities": [0.0]}]}
    put(message, read_path("points[0].positions"), [1.0, 2.0])
    put(message, read_path("points[1].time.sec"), 3)

    assert message["points"][0] == {"velocities": [0.0], "positions": [1.0, 2.0]}
    assert get(message, read_path("points[1].time.sec")) == 3
    assert get(message, read_path("points[2].time")) is None
    assert get(message, read_path("points.x")) is None
    assert gap(message) is None


def test_a_place_in_a_list_that_nothing_was_put_into_is_named():
    message: dict = {}
    put(message, read_path("positions[2]"), 1.0)

    assert gap(message) == "positions[0]"


@pytest.mark.parametrize("written", ["", "a..b", "a[", "a[x]", "[0].a", "a[-1]", "a b"])
def test_a_path_that_is_none_is_a_sentence(written):
    with pytest.raises(ValueError, match="is not a place in a message"):
        read_path(written)


@pytest.mark.parametrize("degrees", [-179, -90, 0, 12.5, 90, 180])
def test_a_yaw_is_a_quaternion_of_length_one_and_back(degrees):
    q = quaternion_of(math.radians(degrees))

    assert math.hypot(*q.values()) == pytest.approx(1)
    assert math.degrees(yaw_of(q)) == pytest.approx(degrees)


def test_units_of_lists_and_forms_are_those_of_the_contract():
    schemas = {
        "joints": {"type": "array", "items": {"type": "number", "unit": "deg"}},
        "turn": {"type": "number", "unit": "deg"}, "time": {"type": "number", "unit": "min"},
    }  # fmt: skip
    written = {
        "joints": {"field": "q", "unit": "rad"}, "turn": {"field": "o", "as": "yaw"},
        "time": {"field": "t", "as": "duration"},
    }  # fmt: skip
    spots = read_spots(written, schemas, "goal")
    message: dict = {}
    for name, value in {"joints": [180, 0], "turn": 90, "time": 1.5}.items():
        spots[name].put(message, value)

    assert message["q"] == pytest.approx([math.pi, 0])
    assert message["o"]["z"] == pytest.approx(math.sin(math.pi / 4))
    assert message["t"] == {"sec": 90, "nanosec": 0}
    assert spots["joints"].get(message) == pytest.approx([180, 0])
    assert spots["turn"].get(message) == pytest.approx(90)
    assert spots["time"].get(message) == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ({"field": "x", "as": "euler"}, "'euler' is not one of yaw, duration"),
        ({"field": "x", "as": "yaw", "unit": "deg"}, "has a unit of its own, rad"),
        ({"field": "x..y"}, "is not a place in a message"),
    ],
)
def test_a_form_that_cannot_be_is_a_sentence(written, words):
    with pytest.raises(ValueError, match=words):
        read_spots({"turn": written}, {"turn": {"type": "number", "unit": "deg"}}, "goal")
