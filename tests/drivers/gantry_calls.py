"""One good call of every action of gantry@1, which its drivers' contract tests share."""

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
    "unlock": {},
}

BAD = {"move_to": [{"x": 731}], "jog": [{"axis": "x"}], "set_zero": [{"axes": []}]}

NEEDS = {
    **{action: ["home"] for action in ("move_to", "jog", "set_zero")},
    "go_to_zero": ["home", "move_to", "set_zero", "jog"],
}
"""What a controller that was just switched on wants before."""
