"""Arguments reach a driver as bare numbers in the contract's units, or not at all."""

import pytest

from labrun.engine.language.arguments import ArgumentFaults, resolve_arguments
from labrun.schemas.contract import Action
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.lab import Limit
from labrun.schemas.quantity import parse_quantity

MOVE = shipped_contracts()["gantry@1"].actions["move_to"]
BENCH = {"x": Limit(minimum=0, maximum="40 cm")}


@pytest.mark.parametrize(
    ("given", "resolved"),
    [
        ({"x": parse_quantity("1 cm")}, {"x": 10.0}),
        ({"x": "100 um", "y": 3}, {"x": 0.1, "y": 3}),
        ({"x": 400}, {"x": 400}),
        ({"feed": parse_quantity("10 mm/s")}, {"feed": 600.0}),
    ],
)
def test_quantities_become_numbers_in_the_contracts_unit(given, resolved):
    assert resolve_arguments(MOVE, given, BENCH, label="gantry.move_to") == resolved


@pytest.mark.parametrize(
    ("given", "codes", "says"),
    [
        (
            {"x": parse_quantity("4 s")},
            ["E204"],
            "gantry.move_to.x: 4 s is a time, the device wants a length (mm)",
        ),
        ({"x": 401}, ["E207"], "gantry.move_to.x: 401 mm is outside x 0..400 mm"),
        ({"y": -1}, ["E207"], "gantry.move_to.y: -1 mm is outside y 0..810 mm"),
        ({"feed": 0}, ["E207"], "0 excluded"),
        ({"x": True}, ["E206"], "true or false"),
        ({"x": None}, ["E206"], "null"),
        ({"x": float("nan")}, ["E206"], "finite"),
        ({"x": "5"}, ["E206"], "'5' is text, the device wants a length (mm); if 5 mm is meant"),
        ({"x": "12,5"}, ["E206"], "(mm); numbers have a decimal point: 12.5"),
        ({"xx": 1, "x": "4 s"}, ["E203", "E204"], "did you mean x?"),
        ({}, ["E205"], "at least 1 of x, y, z and feed"),
    ],
)
def test_what_does_not_fit_is_said_all_at_once(given, codes, says):
    with pytest.raises(ArgumentFaults) as caught:
        resolve_arguments(MOVE, given, BENCH, label="gantry.move_to")

    assert sorted(fault.code for fault in caught.value.faults) == codes
    assert says in str(caught.value)


def test_lists_and_fields_inside_an_argument_have_their_units_too():
    action = Action(
        params={
            "properties": {
                "path": {"type": "array", "items": {"type": "number", "unit": "mm"}},
                "box": {"type": "object", "properties": {"t": {"type": "number", "unit": "s"}}},
            }
        }
    )
    given = {"path": [parse_quantity("1 cm"), "2 mm", 3], "box": {"t": "2 min"}}

    assert resolve_arguments(action, given, {}, label="a.b") == {
        "path": [10.0, 2, 3],
        "box": {"t": 120.0},
    }
