"""Any Python class as an instrument: what it takes, what it raises, and where it is looked for."""

import sys

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext

from . import slow_library

MOTOR = {
    "instrument": "slow_library.Motor",
    "arguments": ["m1"],
    "abort": "stop",
    "abort_beside": True,
    "close": "stop",
    "timeout": 500,
    "errors": {"TooFar": {"answer": "^LimitError: .* beyond", "happened": "no"}},
    "actions": {
        "move": {"call": "set", "params": {"to": {"unit": "mm"}, "lasts": {"unit": "s"}}},
        "hurry": {"call": "get", "params": {}, "effect": "pure"},
        "walk": {"call": "set", "params": {"too": {"unit": "mm"}, "lasts": {"unit": "s"}}},
        "stop": {"call": "stop", "effect": "idempotent"},
        "speed": {"get": "speed.value", "returns": {"speed": {"unit": "mm/s"}}},
        "set_speed": {"set": "speed.value", "params": {"to": {"unit": "mm/s"}}, "effect": "idempotent"},
    },
}  # fmt: skip
CELL = {
    "instrument": "slow_library.Compiled",
    "actions": {
        "place": {"call": "place", "effect": "pure", "returns": {"x": {"unit": "um"}, "y": {"unit": "um"}}},
        "go": {
            "call": "go", "effect": "idempotent",
            "params": {"axis": {"type": "string", "default": "XY"}, "x": {"unit": "um"}, "y": {"unit": "um"}},
        },
        "hand_on": {
            "call": "handed_on", "effect": "idempotent",
            "params": {"axis": {"type": "string", "default": "XY"}, "x": {"unit": "um"}, "y": {"unit": "um"}},
        },
        "lamp": {
            "call": "lamp", "effect": "pure",
            "returns": {"state": {"type": "string"}, "code": {"type": "integer"}},
        },
    },
}  # fmt: skip


@pytest.fixture(autouse=True)
def library(monkeypatch):
    monkeypatch.setitem(sys.modules, "slow_library", slow_library)


def test_what_a_class_raises_is_an_error_that_the_lab_names(ask):
    async def story(made):
        faults = []
        for name, given in (
            ("move", {"to": 200.0, "lasts": 0.0}),
            ("hurry", {}),
            ("walk", {"too": 1.0, "lasts": 0.0}),
        ):
            with pytest.raises(ActionFailed) as fault:
                await made.method(name)(GoalContext(f"run/{name}"), **given)
            faults.append((fault.value.name, fault.value.message))
        await made.method("set_speed")(GoalContext("run/1"), to=2.5)
        return faults, await made.method("speed")(GoalContext("run/2"))

    faults, speed = ask("python", MOTOR, story)

    assert faults == [
        ("TooFar", "set: LimitError: 200.0 is beyond 100"),
        ("Rejected", "get: there is nothing to call: 'Motor' object has no attribute 'get'"),
        ("Rejected", "set: it takes (to, lasts): missing a required argument: 'to'"),
    ]
    assert speed == {"speed": 2.5}


@pytest.mark.parametrize(
    ("raised", "errors", "told", "calls"),
    [
        ("closed", {}, "Lost", 0),
        ("again", {"Lost": {"answer": "^Again"}}, "Lost", 0),
        ("again", {"Silent": {"answer": "^Again"}}, "Silent", 1),
        ("closed", {"Shut": {"answer": "Closed", "happened": "no"}}, "Shut", 1),
        ("odd", {}, "Failed", 1),
    ],
)
def test_a_new_instrument_is_made_where_the_connection_is_gone(ask, raised, errors, told, calls):
    """By the name of what is raised, or because the lab calls it `Lost`; its own name for it comes first."""
    said = {
        **MOTOR, "errors": errors,
        "actions": {
            "ask": {"call": "ask", "params": {"fault": {"type": "string"}}, "effect": "idempotent"},
            "calls": {"get": "moves", "returns": {"calls": {"type": "integer"}}},
            "stop": {"call": "stop", "effect": "idempotent"},
        },
    }  # fmt: skip

    async def story(made):
        with pytest.raises(ActionFailed, match=raised) as fault:
            await made.method("ask")(GoalContext("run/1"), fault=raised)
        return fault.value.name, await made.method("calls")(GoalContext("run/2"))

    assert ask("python", said, story) == (told, {"calls": calls})


def test_a_count_is_waited_for_while_the_instrument_starts_anew(ask, monkeypatch):
    monkeypatch.setattr(slow_library.Arm, "picks", 7)
    said = {
        "instrument": "slow_library.Arm",
        "actions": {
            "picks": {"get": "picks", "returns": {"picks": {"type": "integer"}}},
            "pick": {"call": "pick", "count": "picks"},
        },
    }

    async def story(made):
        with pytest.raises(ActionFailed, match="it hung up") as fault:
            await made.method("pick")(GoalContext("run/1"))
        return fault.value.happened, await made.method("last_once")(GoalContext("run/2"))

    assert ask("python", said, story) == ("unknown", {"goal_id": "run/1"})


@pytest.mark.parametrize("way", ["go", "hand_on"])
def test_a_method_that_takes_no_names_is_given_its_values_in_the_order_of_the_lab(ask, way):
    async def story(made):
        await made.method(way)(GoalContext("run/1"), y=2.0, x=1.0)
        return await made.method("place")(GoalContext("run/2"))

    assert ask("python", CELL, story) == {"x": 1.0, "y": 2.0}


def test_a_number_with_a_name_is_its_name_where_a_text_is_returned(ask):
    lamp = ask("python", CELL, lambda made: made.method("lamp")(GoalContext("run/1")))

    assert lamp == {"state": "SHINING", "code": 10}


@pytest.mark.parametrize(
    ("instrument", "words"),
    [
        (
            "no_such_library.Pump",
            "No module named 'no_such_library'. It has to be installed in the",
        ),
        ("slow_library.Moter", "slow_library has no Moter; it has .*Motor"),
    ],
)
def test_a_class_that_is_not_there_is_told_with_the_way_on(once, instrument, words):
    with pytest.raises(OSError, match=words):
        once("python", {**MOTOR, "instrument": instrument}, "stop")
