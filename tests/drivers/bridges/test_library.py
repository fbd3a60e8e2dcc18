"""What every library's driver does: its own thread, limits, a stop beside what runs, an end of every wait."""

import asyncio
import sys

import pytest

from labrun.drivers.bridges import bridge
from labrun.drivers.bridges.data import plain
from labrun.drivers.bridges.library import returned
from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext

from . import slow_library

CONFIG = {
    "instrument": "slow_library.Motor",
    "abort": "stop",
    "timeout": 5,
    "actions": {
        "move": {
            "call": "set", "params": {"to": {"unit": "mm"}, "lasts": {"unit": "s"}}, "cancel": True,
        },
        "hang": {"call": "set", "params": {"to": {}, "lasts": {}}, "timeout": 0.3},
        "stop": {"call": "stop", "effect": "idempotent"},
        "moves": {"call": "read", "effect": "pure", "returns": {"moves": {"type": "integer"}}},
        "speed": {"get": "speed", "returns": {"speed": {"unit": "mm/s"}}},
        "set_speed": {"set": "speed", "params": {"speed": {}}, "effect": "idempotent"},
        "set_of": {
            "set": "{signal}.value", "params": {"signal": {"enum": ["speed", "far"]}, "to": {}},
            "effect": "idempotent",
        },
        "nonsense": {"get": "moves", "returns": {"moves": {}}},
    },
}  # fmt: skip


@pytest.fixture
def config(monkeypatch):
    monkeypatch.setitem(sys.modules, "slow_library", slow_library)
    return CONFIG


def test_it_blocks_in_a_thread_of_its_own_and_is_stopped_beside_it(config, ask, monkeypatch):
    monkeypatch.setattr(bridge, "ABORTED_S", 500.0)
    slow_library.MOVING.clear()

    async def story(made):
        await made.method("set_speed")(GoalContext("run/1"), speed=4.5)
        goal = GoalContext("run/2")
        moving = asyncio.create_task(made.method("move")(goal, to=50.0, lasts=100.0))
        assert await asyncio.to_thread(slow_library.MOVING.wait, 500)  # the loop goes on meanwhile
        goal.cancelled.set()
        with pytest.raises(ActionCanceled):
            await moving
        again = await made.method("moves")(GoalContext("run/3"))
        return again, await made.method("speed")(GoalContext("run/4"))

    moves, speed = ask("ophyd", {**config, "timeout": 500}, story)

    assert moves == {"moves": 1} and speed == {"speed": 4.5}  # of a new connection, it would be 0


def test_a_channel_is_a_parameter_of_the_path(config, ask):
    config = {**config, "abort": None, "actions": {n: config["actions"][n] for n in ("set_of",)}}
    config["actions"]["value_of"] = {
        "get": "{signal}.value", "params": {"signal": {"enum": ["speed", "far"]}}, "returns": {"x": {}},
    }  # fmt: skip

    async def story(made):
        await made.method("set_of")(GoalContext("run/1"), signal="speed", to=7.5)
        return [
            await made.method("value_of")(GoalContext("run/2"), signal=signal)
            for signal in ("speed", "far")
        ]

    assert ask("pymeasure", {**config, "instrument": "slow_library.Pair", "resource": "x"}, story) == [
        {"x": 7.5}, {"x": 1.0},
    ]  # fmt: skip
    twin = {**config, "instrument": "slow_library.Pair", "resource": "x", "clock": "fast"}
    assert ask("sim_pymeasure", twin, story)[0] == {"x": 7.5}


def test_what_does_not_return_in_time_is_a_timeout_and_it_is_opened_anew(config, ask):
    async def story(made):
        with pytest.raises(ActionFailed, match=r"has not returned within 0\.3 s") as fault:
            await made.method("hang")(GoalContext("run/1"), to=1.0, lasts=1.0)
        return fault.value, await made.method("moves")(GoalContext("run/2"))

    failure, moves = ask("ophyd", config, story)

    assert (failure.name, failure.happened) == ("Timeout", "unknown")
    assert moves == {"moves": 0}


def test_a_limit_of_the_library_says_that_nothing_happened(config, once):
    with pytest.raises(ActionFailed, match="beyond 100") as fault:
        once("ophyd", config, "move", to=200.0, lasts=0.0)

    assert (fault.value.name, fault.value.happened) == ("Rejected", "no")


@pytest.mark.parametrize(
    ("asked", "name"), [({"get": "gauge"}, "p"), ({"call": "gauge.read"}, "value")]
)
def test_a_value_that_epics_marks_as_invalid_is_none(config, once, asked, name):
    gauge = {**asked, "returns": {name: {"unit": "mbar"}}}
    none = {**asked, "returns": {name: {"type": ["number", "null"], "unit": "mbar"}}}
    said = {**config, "actions": {**config["actions"], "gauge": gauge, "none": none}}
    with pytest.raises(ActionFailed, match=r"EPICS marks \w+ as INVALID, and its 1\.5") as fault:
        once("ophyd", said, "gauge")

    assert (fault.value.name, fault.value.happened) == ("NotANumber", "yes")
    assert once("ophyd", said, "none") == {name: None}


def test_what_the_config_names_wrongly_is_a_failure_not_a_traceback(config, once):
    with pytest.raises(ActionFailed, match="'int' object has no attribute 'get'"):
        once("ophyd", config, "nonsense")
    with pytest.raises(OSError, match="ophyd's slow_library has no Moter"):
        once("ophyd", {**config, "instrument": "slow_library.Moter"}, "moves")


@pytest.mark.parametrize(
    ("found", "returns", "made"),
    [
        ((1.0, 2.0), {"x": {"type": "number"}, "y": {"type": "number"}}, {"x": 1.0, "y": 2.0}),
        ("12.5 V", {"v": {"type": "number", "unit": "V"}}, {"v": 12.5}),
        (3, {"text": {"type": "string"}}, {"text": "3"}),
        (1, {"on": {"type": "boolean"}}, {"on": True}),
    ],
)
def test_what_is_returned_is_read_as_the_contract_says(found, returns, made):
    assert returned(found, returns, "ophyd") == made


def test_nothing_is_no_number():
    with pytest.raises(ValueError, match="it returned nothing, where number is expected"):
        plain(None, {"type": "number"})


def test_what_is_set_is_an_attribute_that_is_there_and_no_method(config, ask):
    params = {"value": {}}
    names = {"ok": "voltage", "typo": "voltge", "method": "reset"}
    actions = {name: {"set": path, "params": params} for name, path in names.items()}
    actions["reset"] = {"call": "reset"}
    said = {"instrument": "slow_library.Source", "resource": "ASRL1", "actions": actions}

    async def story(made):
        await made.method("ok")(GoalContext("run/1"), value=2.0)
        faults = []
        for name in ("typo", "method"):
            with pytest.raises(ActionFailed) as fault:
                await made.method(name)(GoalContext(f"run/{name}"), value=2.0)
            faults.append((fault.value.name, fault.value.happened, fault.value.message))
        await made.method("reset")(GoalContext("run/2"))
        return faults, made._instrument.voltage, made._instrument.resets

    faults, volts, resets = ask("pymeasure", said, story)

    assert [fault[:2] for fault in faults] == [("Rejected", "no")] * 2
    assert "Source has no voltge" in faults[0][2]
    assert "reset is a method of Source: say `call: reset`" in faults[1][2]
    assert (volts, resets) == (2.0, 1)


def test_what_is_only_written_has_happened_when_its_count_says_so(config, ask):
    actions = {
        "points": {"get": "points", "returns": {"points": {"type": "integer"}}},
        "trigger": {"call": "trigger", "count": "points", "timeout": 0.3},
    }
    said = {"instrument": "slow_library.Source", "resource": "ASRL1", "actions": actions}

    async def story(made):
        await made.method("trigger")(GoalContext("run/1"))
        made._instrument.deaf = True  # a write that was lost with the connection raises nothing
        with pytest.raises(ActionFailed, match=r"points is still \{'points': 1\}") as lost:
            await made.method("trigger")(GoalContext("run/2"))
        return lost.value, await made.method("last_once")(GoalContext("run/3"))

    lost, last = ask("pymeasure", said, story)

    assert (lost.name, lost.happened) == ("Timeout", "unknown")
    assert last == {"goal_id": "run/1"}
