"""What `until` waits for, of what an instrument answers."""

import pytest

from labrun.drivers.bridges.config import awaited


@pytest.mark.parametrize(
    ("until", "told", "over"),
    [
        ({"busy": False}, {"busy": False}, True),
        ({"busy": False}, {"busy": True, "within": 1}, False),
        ({"t": "{to}"}, {"t": 37.02}, False),
        ({"t": "{to}", "within": 0.1}, {"t": 37.02}, True),
        ({"t": "{to}", "within": 0.1}, {"t": 36.9}, True),  # 0.10000000000000142 off
        ({"t": "{to}", "within": 0.1}, {"t": 36.8}, False),
        ({"t": "{to}", "within": 0.1}, {"t": None}, False),
        ({"t": "{to}", "state": "still", "within": 0.1}, {"t": 37.0, "state": "moving"}, False),
        ({"on": True, "within": 2}, {"on": False}, False),
    ],
)
def test_until_waits_for_the_same_or_for_a_number_that_is_near(until, told, over):
    assert awaited({"do": "ask", **until}, {"to": 37.0}, told) is over
