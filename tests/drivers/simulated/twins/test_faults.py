"""Ordered faults come as often as ordered, and the same goal always meets the same one."""

import pytest

from labrun.drivers.simulated.twins.faults import Faults, chance
from labrun.schemas.contracts import shipped_contracts

LIBS = shipped_contracts()["libs_analyzer@1"]


def names(faults: Faults, action: str, count: int = 4000) -> list[str | None]:
    drawn = [faults.drawn(action, f"goal {n}") for n in range(count)]
    return [None if fault is None else fault.error for fault in drawn]


def test_chance_is_even_and_repeatable():
    numbers = [chance(1, n) for n in range(4000)]

    assert numbers == [chance(1, n) for n in range(4000)]
    assert sum(numbers) / 4000 == pytest.approx(0.5, abs=0.02)


def test_each_error_comes_as_often_as_it_was_ordered():
    ordered = {"measure": {"ButtonNotFound": 0.2, "NoSignal": 0.05}}
    met = names(Faults(ordered, LIBS, 1), "measure")

    assert met.count("ButtonNotFound") / 4000 == pytest.approx(0.2, abs=0.03)
    assert met.count("NoSignal") / 4000 == pytest.approx(0.05, abs=0.02)
    assert met == names(Faults(ordered, LIBS, 1), "measure")
    assert met != names(Faults(ordered, LIBS, 2), "measure")


def test_a_bare_number_is_shared_by_all_errors_of_the_action():
    met = names(Faults({"measure": 0.3}, LIBS, 1), "measure")

    assert set(met) == {None, "ButtonNotFound", "NoSignal", "DialogOpen"}
    assert met.count(None) / 4000 == pytest.approx(0.7, abs=0.03)


def test_what_was_not_ordered_does_not_fail():
    assert set(names(Faults({"measure": 1.0}, LIBS, 1), "export")) == {None}


@pytest.mark.parametrize(
    ("ordered", "message"),
    [
        ({"mesure": 1}, "libs_analyzer@1 has no action 'mesure'"),
        ({"measure": {"Tired": 1}}, "measure of libs_analyzer@1 cannot fail with Tired; its"),
        ({"disarm": 0.5}, "disarm of libs_analyzer@1 cannot fail with any; its errors are: none"),
        ({"measure": {"NoSignal": 1.5}}, "NoSignal is 1.5; a probability is 0 to 1"),
    ],
)
def test_a_fault_that_the_contract_does_not_know_is_refused(ordered, message):
    with pytest.raises(ValueError, match=message):
        Faults(ordered, LIBS, 1)
