"""The driver against a real program on a real screen: one click a goal, whole files, nothing unseen."""

import asyncio

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.drivers.find import check_driver, find_driver
from labrun.schemas.contracts import shipped_contracts

CHANNELS = 2000


async def failing(action, *args, **named) -> ActionFailed:
    with pytest.raises(ActionFailed) as caught:
        await action(*args, **named)
    return caught.value


async def exported(driver, shot: str, goal: str = "export") -> bytes:
    context = GoalContext(goal)
    await driver.export(context, shot=shot, file="a.csv")
    return context.files["file"].data


def test_it_keeps_the_contract(tmp_path):
    check_driver(find_driver("sciaps_gui", tmp_path), shipped_contracts()["libs_analyzer@1"])


@pytest.mark.parametrize(
    ("look", "scale", "steps"), [("grey", 1.0, 2), ("dark", 1.4, 1), ("paper", 0.8, 2)]
)
def test_shots_are_fired_and_exported_whatever_the_program_looks_like(gui, look, scale, steps):
    analyser = gui.start(look=look, scale=scale, steps=steps)

    async def story(driver):
        await driver.locate(GoalContext("l"))
        data = []
        for n in range(2):
            shot = (await driver.measure(GoalContext(f"m{n}")))["shot_id"]
            data.append(await exported(driver, shot, f"e{n}"))
        return data, await driver.last_shot(GoalContext("p"))

    data, last = gui.play(story, look)

    assert analyser.shots() == 2
    assert [len(d.splitlines()) for d in data] == [CHANNELS + 1] * 2
    assert data[0] != data[1]
    assert last == {"shot_id": "shot-000002", "goal_id": "m1"}
