"""One good call of every action of gantry@2, which its drivers' contract tests share."""

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
