"""The simulated gantry keeps gantry@1 on a real server."""

from labrun.drivers.contract_tests import Case, KeepsContract


class TestSimGantry(KeepsContract):
    case = Case(
        driver="sim_gantry",
        config={"clock": "fast", "homed": True},
        slow={"clock": "real"},
        limits={"x": {"maximum": "500 mm"}},
        good={"home": {}, "move_to": {"x": 90, "z": 50.5}, "halt": {}, "unlock": {}},
        bad={"move_to": [{"x": 500.1}, {"y": "10 mm"}, {"x": None}]},
        lasting="move_to",
    )

    def is_safe(self, status):
        return status["state"] == "idle"
