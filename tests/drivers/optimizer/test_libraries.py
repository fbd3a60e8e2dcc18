"""Optimizers that other people wrote, each where its library is installed."""

import pytest

from labrun.drivers.driver import ActionFailed
from labrun.drivers.optimizer.by_baybe import Baybe
from labrun.drivers.optimizer.by_gpcam import Gpcam
from labrun.drivers.optimizer.by_optuna import Optuna

from .stories import SPACE, Asker, loss, played

DRIVERS = [
    pytest.param(kind, id=name, marks=[pytest.mark.soak, pytest.mark.needs(name)])
    for name, kind in (("optuna", Optuna), ("gpcam", Gpcam), ("baybe", Baybe))
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
def test_several_goals_are_taken(kind, tmp_path):
    async def story(driver):
        asker = Asker(driver)
        space = {"x": {"minimum": 0, "maximum": 1}}
        await asker.do("define", space=space, goals={"a": "minimize", "b": "maximize"})
        for _ in range(12):
            (point,) = (await asker.do("ask"))["suggestions"]
            values = {"a": point["x"] ** 2, "b": 1 - (point["x"] - 1) ** 2}
            await asker.do("tell", at=point, values=values)
        return (await asker.do("best"))["front"]

    assert len(played(kind, tmp_path, story)) == 12


@pytest.mark.parametrize("kind", DRIVERS)
def test_maps_are_chosen_or_refused_with_what_does(kind, tmp_path):
    space = {axis: {"minimum": 0, "maximum": 4, "step": 1} for axis in "xy"}

    async def story(driver):
        asker = Asker(driver)
        await asker.do("define", space=space, goals={"Li": "map", "K": "map"})
        for x, y in ((0, 0), (4, 4), (0, 4), (4, 0)):
            await asker.do("tell", at={"x": x, "y": y}, values={"Li": x, "K": y % 4})
        if not hasattr(driver, "choose"):
            with pytest.raises(ActionFailed, match=r"WrongStudy: .* take the driver gp"):
                await asker.do("ask")
            return None
        points = (await asker.do("ask", n=6))["suggestions"]
        return points, await asker.do("model", at=[{"x": 0, "y": 0}, {"x": 2, "y": 2}])

    if (told := played(kind, tmp_path, story)) is not None:
        points, model = told
        assert len({(point["x"], point["y"]) for point in points}) == 6
        assert model["mean"]["Li"] == pytest.approx([0, 2], abs=0.7)
        assert model["deviation"]["Li"][0] < model["deviation"]["Li"][1]
