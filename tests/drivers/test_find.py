"""Drivers are found by name or path, and one that does not keep its contract does not start."""

import importlib.util

import pytest

from labrun.drivers.driver import Driver
from labrun.drivers.find import SHIPPED, DriverFault, check_driver, driver_places, find_driver
from labrun.schemas.contract import Contract
from labrun.schemas.contracts import shipped_contracts

HEAD = "from labrun.drivers.driver import Driver\n"


def contract(**actions):
    return Contract(type="lamp@1", safe_state=["off"], actions={"off": {}, **actions})


class Lamp(Driver):
    contract = "lamp@1"

    async def off(self, goal):
        return {}


def test_a_shipped_driver_is_found_by_its_name(tmp_path):
    assert find_driver("sim_gantry", tmp_path).contract == "gantry@2"


def test_every_shipped_driver_is_on_the_list_and_there(tmp_path):
    for name in SHIPPED:
        assert issubclass(find_driver(name, tmp_path), Driver)

    assert SHIPPED.items() <= driver_places().items()
    assert all(importlib.util.find_spec(place.partition(":")[0]) for place in SHIPPED.values())


def test_a_driver_of_a_labs_own_is_found_beside_the_lab(tmp_path):
    (tmp_path / "lamp.py").write_text(HEAD + "class Lamp(Driver):\n    contract = 'lamp@1'\n")

    assert find_driver("./lamp.py:Lamp", tmp_path).__name__ == "Lamp"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("sim_gantri", "", "there is no driver 'sim_gantri'; the drivers are"),
        ("./lamp.py:Lamp", None, "there is no file"),
        ("./lamp.py:Lamp", "import nowhere_to_be_found", "ModuleNotFoundError: No module named"),
        ("./lamp.py:Lamp", "class Lamp: pass", "Lamp is not a class in"),
        ("./lamp.py:Lamp", HEAD, "Lamp is not a class in"),
        ("./lamp.py:Lamp", "def", "SyntaxError: invalid syntax"),
    ],
)
def test_a_driver_that_cannot_be_found_is_a_sentence(tmp_path, name, text, words):
    if text is not None:
        (tmp_path / "lamp.py").write_text(text)

    with pytest.raises(DriverFault) as caught:
        find_driver(name, tmp_path)

    assert words in str(caught.value)


def test_a_driver_that_keeps_its_contract_starts():
    check_driver(Lamp, contract())


def test_a_driver_serves_a_contract_of_ones_own_that_keeps_its_contract_too(tmp_path):
    ours = shipped_contracts()["gantry@1"].model_copy(
        update={"type": "stage@1", "also": ["gantry@1"]}
    )

    check_driver(find_driver("grbl", tmp_path), ours)
    with pytest.raises(
        DriverFault, match=r"it is a driver for libs_analyzer@1: .*; .*async def home"
    ):
        check_driver(find_driver("sim_libs", tmp_path), ours)


@pytest.mark.parametrize(
    ("driver", "actions", "words"),
    [
        ({"contract": "pump@1"}, {}, "it is a driver for pump@1: write `contract = "),
        (
            {"contract": None},
            {},
            'it does not say for which it is one: write `contract = "lamp@1"`',
        ),
        ({}, {"blink": {}}, "it has no `async def blink`"),
        ({"blink": lambda self, goal: {}}, {"blink": {}}, "it has no `async def blink`"),
        ({"off": None}, {}, "it has no `async def off`"),
    ],
)
def test_a_driver_that_lacks_something_is_told_what(driver, actions, words):
    changed = type("Changed", (Lamp,), driver)

    with pytest.raises(DriverFault, match="Changed does not keep the contract lamp@1") as caught:
        check_driver(changed, contract(**actions))

    assert words in str(caught.value)


def test_parameters_of_the_contract_are_accepted_and_no_others_needed():
    class Dimmer(Lamp):
        async def dim(self, goal, *, speed):
            return {}

    dim = {"params": {"type": "object", "properties": {"level": {"type": "number"}}}}
    with pytest.raises(DriverFault) as caught:
        check_driver(Dimmer, contract(dim=dim))

    assert "dim does not accept the parameter level" in str(caught.value)
    assert "dim requires speed, which the contract does not require" in str(caught.value)


def test_a_safe_state_must_be_made_of_actions():
    odd = Contract(type="lamp@1", safe_state=["hide"], actions={"off": {}})

    with pytest.raises(DriverFault, match="the safe state names hide, which is not an action"):
        check_driver(Lamp, odd)
