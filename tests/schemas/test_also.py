"""A contract that says `also` keeps the earlier one's promises; the check that says so sees each breach."""

import re

import pytest

from labrun.schemas.also import broken_promises
from labrun.schemas.contract import Contract
from labrun.schemas.contracts import shipped_contracts

ALSO = [
    pytest.param(contract, earlier, id=f"{contract.type} keeps {earlier}")
    for contract in shipped_contracts().values()
    for earlier in contract.also
]


@pytest.mark.parametrize(("contract", "earlier"), ALSO)
def test_what_ships_keeps_what_it_says(contract, earlier):
    assert list(broken_promises(contract, shipped_contracts()[earlier])) == []


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda c: c["actions"].pop("jog"), "it has no action jog"),
        (lambda c: c["actions"]["home"].update(effect="once"), "home: effect is once"),
        (lambda c: c["actions"]["home"]["errors"].pop("Offline"), "home: it has no error Offline"),
        (
            lambda c: of(c)["x"].update(maximum=500),
            r"move_to\.x: minimum is 500|move_to\.x: maximum is 500",
        ),
        (lambda c: of(c)["x"].update(unit="cm"), "move_to.x: unit is cm"),
        (lambda c: of(c).pop("z"), "move_to: it has no parameter z"),
        (lambda c: c["actions"]["move_to"]["params"].update(required=["x"]), "move_to: it needs x"),
        (lambda c: c["actions"]["jog"]["params"]["properties"]["axis"].update(enum=["x"]), "only"),
        (lambda c: c["actions"]["home"].update(cancel=False), "home: cancel is False"),
        (lambda c: c["status"]["properties"].pop("work_x"), "status: it does not tell work_x"),
        (lambda c: c.update(safe_state=[]), "its safe state is"),
        (lambda c: c.update(concurrent=True), "concurrent is True"),
        (lambda c: c["actions"]["move_to"]["returns"].update(required=[]), "may be missing"),
    ],
)
def test_each_breach_is_told(change, told):
    earlier = shipped_contracts()["gantry@1"]
    changed = earlier.model_dump(mode="json")
    change(changed)
    later = Contract.model_validate({**changed, "type": "gantry@9", "also": ["gantry@1"]})

    (one,) = broken_promises(later, earlier)

    assert re.search(told, one)


def of(contract):
    """The parameters of move_to."""
    return contract["actions"]["move_to"]["params"]["properties"]
