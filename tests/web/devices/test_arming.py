"""A hazard that is armed has to be held before it is done, and is done once."""

import asyncio
from types import SimpleNamespace

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.web.devices import arming
from labrun.web.local.refusal import Refusal

ANALYSER = SimpleNamespace(
    name="libs",
    contract=load_lab(None)[0].contracts["libs_analyzer@1"],
    reachable_client=lambda: None,
    status={},
)


def refusals(*spent):
    """The codes with which an armed shot is refused; None where it is not."""

    async def story():
        made = arming.Arming(lambda name: ANALYSER, lambda name: None, lambda name: None)
        told, codes = made.arm("libs", "measure", "Ada"), []
        for by, id in spent:
            try:
                made.spend(ANALYSER, "measure", by, told.id if id is None else id)
                codes.append(None)
            except Refusal as refused:
                codes.append(refused.fault.code)
        made.disarm()
        return codes

    return asyncio.run(story())


@pytest.mark.parametrize(("hold_s", "told"), [(600, ["NOT_HELD"] * 2), (0, [None, "NOT_ARMED"])])
def test_it_is_held_first_and_spent_by_its_one_use(monkeypatch, hold_s, told):
    monkeypatch.setattr(arming, "HOLD_S", hold_s)

    assert refusals(("Ada", None), ("Ada", None)) == told


def test_it_is_for_who_armed_it_by_the_word_that_was_given(monkeypatch):
    monkeypatch.setattr(arming, "HOLD_S", 0)

    assert refusals(("Bo", None), ("Ada", "another"), ("Ada", None)) == [
        "NOT_ARMED", "NOT_ARMED", None,
    ]  # fmt: skip
