"""Optimizers that other people wrote, each where its library is installed."""

import pytest

from labrun.drivers.driver import ActionFailed
from labrun.drivers.optimizer.by_optuna import Optuna

from .stories import SPACE, Asker, loss, played

DRIVERS = [
    pytest.param(Optuna, id="optuna", marks=[pytest.mark.soak, pytest.mark.needs("optuna")]),
]


@pytest.mark.parametrize("kind", DRIVERS)
def test_it_comes_nearer_keeps_the_constraints_and_goes_on_after_a_restart(kind, tmp_path):
    async def begin(driver):
        asker = Asker(driver)
        await asker.do(
            "define", space=SPACE, goals={"loss": "minimize"}, constraints=["x + y < 2.5"]
        )
        await asker.search(15, n=3)
        return asker.number, await asker.do("best"), driver._study.at

    async def go_on(driver):
        asker = Asker(driver, begin=number)
        return (await asker.do("ask", n=3))["suggestions"]

    number, best, told = played(kind, tmp_path / "killed", begin)
    played(kind, tmp_path / "whole", begin)

    assert loss(best["at"]) < min(0.3, *(loss(point) for point in told[:9]))
    assert all(point["x"] + point["y"] < 2.5 for point in told)
    assert len({str(point) for point in told}) == len(told) == 45
    assert played(kind, tmp_path / "killed", go_on) == played(kind, tmp_path / "whole", go_on)


@pytest.mark.parametrize("kind", DRIVERS)
def test_several_goals_are_taken_and_maps_refused(kind, tmp_path):
    async def story(driver):
        asker = Asker(driver)
        space = {"x": {"minimum": 0, "maximum": 1}}
        await asker.do("define", space=space, goals={"a": "minimize", "b": "maximize"})
        for _ in range(12):
            (point,) = (await asker.do("ask"))["suggestions"]
            values = {"a": point["x"] ** 2, "b": 1 - (point["x"] - 1) ** 2}
            await asker.do("tell", at=point, values=values)
        front = (await asker.do("best"))["front"]
        await asker.do("define", space=space, goals={"a": "map"}, study="map")
        with pytest.raises(ActionFailed, match=r"WrongStudy: .* looks for the best"):
            await asker.do("ask")
        return front

    assert len(played(kind, tmp_path, story)) == 12
