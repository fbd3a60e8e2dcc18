"""The simulated camera keeps depth_camera@1 on a real server."""

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract


@pytest.mark.soak
class TestSimDepthCamera(KeepsContract):
    case = Case(
        driver="sim_depth_camera",
        config={
            "clock": "fast",
            "place": {"x": 60, "y": 40, "z": 400, "tilt": 30},
            "board": {"columns": 9, "rows": 6, "square": 25, "x": 60, "y": 140},
            "stones": [[100, 300, 60, 40, 25]],
        },
        slow={"clock": 2},
        good={
            "capture": {"image": "pictures/a.png", "depth": "pictures/a_depth.png"},
            "calibrate": {"x": 60, "y": 140},
            "last_calibration": {},
            "locate_point": {"u": 640, "v": 300},
            "locate_samples": {"min_height": 5},
        },
        needs={"locate_point": ["calibrate"], "locate_samples": ["calibrate"]},
        lasting="calibrate",
    )
