"""Gaussian processes find the best place, spread a batch, and look for edges on a map."""

import numpy as np
import pytest

from labrun.drivers.optimizer.gp import Gp

from .stories import BEST, SPACE, Asker, loss, played


@pytest.mark.slow
def test_it_finds_the_best_place_in_few_turns(tmp_path):
    async def story(driver):
        asker = Asker(driver)
        await asker.do(
            "define", space=SPACE, goals={"loss": "minimize"}, constraints=["x + y < 2.5"]
        )
        await asker.search(7, n=3)
        model = await asker.do("model", at=[BEST, {**BEST, "x": -2}])
        return await asker.do("best"), model

    best, model = played(Gp, tmp_path, story)

    assert loss(best["at"]) < 0.02
    assert best["at"]["y"] in [round(n * 0.05, 10) for n in range(21)]
    assert model["mean"]["loss"][0] < 0.3 < model["mean"]["loss"][1]


@pytest.mark.slow
def test_a_map_is_measured_at_its_edges(tmp_path):
    space = {
        "x": {"minimum": 0, "maximum": 3, "step": 0.2},
        "y": {"minimum": 0, "maximum": 3, "step": 0.2},
    }

    def edge(point):
        return abs(np.hypot(point["x"] - 1.4, point["y"] - 1.6) - 0.9)

    async def story(driver):
        asker = Asker(driver)
        places = (await asker.do("define", space=space, goals={"Li": "map"}))["places"]
        even, later = [], []
        for n in range(6):
            points = (await asker.do("ask", n=16))["suggestions"]
            (even if n < 2 else later).extend(points)
            for point in points:
                inside = np.hypot(point["x"] - 1.4, point["y"] - 1.6) < 0.9
                await asker.do("tell", at=point, values={"Li": 800.0 * inside})
        return places, even, later, await asker.do("model", at=[{"x": 1.4, "y": 1.6}])

    places, even, later, model = played(Gp, tmp_path, story)

    assert places == 256
    assert len({(p["x"], p["y"]) for p in even + later}) == 96
    assert np.mean([edge(p) for p in later]) < 0.5 * np.mean([edge(p) for p in even])
    assert 700 < model["mean"]["Li"][0] < 900
