"""One good call of every action of gantry@2, and the frame of its real drivers' contract tests."""

from labrun.drivers.contract_tests import Case, KeepsContract

GOOD = {
    "home": {},
    "move_to": {"x": 90, "z": 50.5},
    "jog": {"axis": "x", "distance": 100, "feed": 2000},
    "hold": {},
    "resume": {},
    "set_zero": {"axes": ["x", "y"]},
    "last_by_hand": {},
    "go_to_zero": {"axes": ["x"], "feed": 2000},
    "halt": {},
    "touch": {"to": 5, "feed": 1000},
    "set_output": {"output": "laser", "on": True, "power": 10},
    "override": {"feed": 100, "rapid": 100},
    "unlock": {},
}

CONFIG = {"outputs": {"laser": "spindle"}}

BAD = {
    "move_to": [{"feed": 100, "safe_z": "high"}],
    "touch": [{"to": 5, "axis": "a"}],
    "jog": [{"axis": "x"}],
    "set_zero": [{"axes": []}],
}

NEEDS = {
    **{action: ["home"] for action in ("move_to", "jog", "set_zero", "touch", "set_output")},
    "go_to_zero": ["home", "move_to", "set_zero", "jog"],
}
"""What a controller that was just switched on wants before."""


def case_of(driver):
    """The contract's tests for a driver in front of a controller."""
    return Case(
        driver=driver, good=GOOD, config=CONFIG, bad=BAD, needs=NEEDS,
        quick=frozenset({"set_zero"}), lasting="move_to",
    )  # fmt: skip


class KeepsGantryContract(KeepsContract):
    """What a controller shows of safety, and of what has happened."""

    def started(self, peers, *, slow):
        self.controller = peers(speed=1 if slow else 20, homing_s=3 if slow else None)
        self.controller.surface = -80.0
        return self.controller

    def is_safe(self, status):
        return self.controller.move is None and status["state"] in ("idle", "alarm")

    def happened(self, folder, goal_id):
        """A controller knows of no goals: after homing only what the test did moves it."""
        return len(self.controller.stands) > 1 or any(self.controller.offset)
