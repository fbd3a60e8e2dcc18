"""The simulated gantry keeps gantry@2 on a real server."""

from labrun.drivers.contract_tests import Case, KeepsContract

from ..gantry_calls import CONFIG, GOOD


class TestSimGantry(KeepsContract):
    case = Case(
        driver="sim_gantry",
        config={"clock": "fast", "homed": True, **CONFIG},
        needs={"touch": ["move_to"]},
        slow={"clock": "real"},
        limits={"x": {"maximum": "500 mm"}},
        good={**GOOD, "go_to_zero": {"axes": ["z"], "feed": 1500}},
        bad={
            "move_to": [{"x": 500.1}, {"y": "10 mm"}, {"x": None}],
            "jog": [{"axis": "x", "distance": 1, "direction": "+"}, {"axis": "x"}, {"axis": "w"}],
            "set_zero": [{"axes": []}],
        },
        quick=frozenset({"set_zero"}),
        lasting="move_to",
    )

    def is_safe(self, status):
        return status["state"] == "idle"
