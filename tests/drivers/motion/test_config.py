"""What a lab says of a gantry is read at once, and refused in words."""

import pytest

from labrun.drivers.driver import Place
from labrun.drivers.grbl.gantry import Grbl


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({"prot": 1}, "config has no key prot; its keys are: port, baud"),
        ({"port": "x", "Bauds": 1}, "; perhaps baud is meant$"),
        ({"port": ""}, "config needs `port`"),
        ({"baud": "fast"}, "baud is 'fast'; it must be a number above 0"),
        ({"axes": {"x": "X", "y": "X"}}, "each once"),
        ({"axes": {"w": "X"}}, "axes has no key w; its keys are: x, y"),
        ({"axes": "XY"}, "axes is"),
        ({"origin": {"w": 1}}, "origin has no key w"),
        ({"origin": {"x": "left"}}, "write it as {x: -805"),
        ({"origin": {"x": float("nan")}}, "write it as {x: -805"),
        ({"home_first": "yes"}, "home_first is 'yes'; it must be true or false"),
        ({"keep_out": [{"x": [5, 1]}]}, r"keep_out box 1: x is \[5, 1\]"),
        ({"keep_out": [{"name": "all"}]}, "keep_out box all has no range; write x"),
        ({"keep_out": [{"w": [0, 1]}]}, "keep_out box 1 has no key w; its keys are: name, x, y, z"),
    ],
)
def test_a_wrong_config_is_refused_with_what_is_wrong(config, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        Grbl(Place("gantry", {"port": "COM5", **config}, {}, tmp_path, tmp_path))
