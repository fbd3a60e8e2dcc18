"""An optimizer remembers every ask and tell, and says what is wrong in a sentence."""

import asyncio
import os
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from labrun.drivers.client.launch import start_server
from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.contract_tests.session import connected, settings
from labrun.drivers.driver import ActionFailed
from labrun.drivers.optimizer.gp import Gp

from .stories import SPACE, Asker, loss, played

DEFINED = {"space": SPACE, "goals": {"loss": "minimize"}, "seed": 3}
HERE = {"x": 0, "y": 0.5, "base": "lime"}
CASE = Case(
    driver=f"{Path(__file__).with_name('patient.py')}:PatientGp",
    slow={"pause": 2.5},
    good={
        "define": DEFINED, "ask": {"n": 2}, "last_ask": {}, "last_tell": {}, "best": {},
        "tell": {"at": HERE, "values": {"loss": 1.5}}, "model": {"at": [HERE]},
    },
    needs={
        "ask": ["define"], "tell": ["define"], "best": ["define", "tell"],
        "model": ["define", "tell", "tell"],
    },
    bad={
        "define": [{**DEFINED, "space": {"x": {"minimum": 0, "maximun": 1}}}],
        "tell": [{"at": HERE, "values": {"loss": float("nan")}}],
    },
    lasting="ask",
)  # fmt: skip


@pytest.mark.slow
class TestGp(KeepsContract):
    case = CASE

    def happened(self, folder, goal_id):
        found = next(folder.rglob("studies.sqlite"), None)
        if found is None:
            return False
        with closing(sqlite3.connect(found)) as disk:
            return bool(disk.execute("SELECT 1 FROM lines WHERE goal = ?", (goal_id,)).fetchall())


async def failure(doing) -> str:
    with pytest.raises(ActionFailed) as failed:
        await doing
    return str(failed.value)


def test_what_makes_no_sense_is_said_in_a_sentence(tmp_path):
    def x(**bounds):
        return {"space": {"x": bounds}, "goals": {"loss": "minimize"}}

    wrong = {
        "x: the minimum 3 is not below the maximum 2": x(minimum=3, maximum=2),
        "x: a step of 2 is wider than 0 to 1": x(minimum=0, maximum=1, step=2),
        "x needs a minimum and a maximum, or choices": x(minimum=0),
        "x: a choice comes twice": x(choices=["a", "a"]),
        "x cannot be varied and be a goal": {**x(minimum=0, maximum=1), "goals": {"x": "map"}},
        "all goals are maps or none": {**DEFINED, "goals": {"a": "map", "b": "minimize"}},
        "cannot be computed from x, y, base": {**DEFINED, "constraints": ["x + z < 3"]},
        "gives -1.0, which is neither true nor false": {**x(minimum=-2, maximum=0), "constraints": ["x"]},
        "nothing keeps all constraints": {**x(minimum=0, maximum=1, step=0.5), "constraints": ["x > 1"]},
    }  # fmt: skip

    async def story(driver):
        asker = Asker(driver)
        early = [await failure(asker.do("ask")), await failure(asker.do("best"))]
        for words, said in wrong.items():
            assert words in await failure(asker.do("define", **said))
        await asker.do("define", **DEFINED)
        at, more = {"x": 1, "y": 0}, {"loss": 1, "yield": 2}
        return early, [
            await failure(asker.do("best")),
            await failure(asker.do("model", at=[HERE])),
            await failure(asker.do("tell", at=at, values={"loss": 1})),
            await failure(asker.do("tell", at=HERE, values=more)),
            await failure(asker.do("tell", at={**HERE, "base": "salt"}, values={"loss": 1})),
            await failure(asker.do("tell", at={**HERE, "x": "far"}, values={"loss": 1})),
            await failure(asker.do("define", **{**DEFINED, "goals": {"cost": "minimize"}})),
            await driver.status(),
        ]

    early, late = played(Gp, tmp_path, story)

    assert early == ["NotDefined: nothing is defined yet: `define` says what is wanted"] * 2
    assert late == [
        "NoData: nothing has been told of run yet",
        "NoData: a model needs 2 places told; there are 0",
        "WrongNames: x, y is told; asked was x, y, base",
        "WrongNames: values of loss, yield are told; the goals are loss",
        "WrongValue: base is salt, none of lime, soda",
        "WrongValue: x is 'far', which is no number",
        "WrongStudy: the study run varies x, y, base and wants loss: minimize; give this one another name",
        {"study": "run", "told": 0, "waiting": 0},
    ]


@pytest.mark.slow
def test_after_a_restart_the_same_is_suggested_and_nothing_is_told_twice(tmp_path):
    async def begin(driver):
        asker = Asker(driver)
        await asker.do("define", **DEFINED)
        await asker.search(8)
        return asker.number

    async def go_on(driver):
        asker = Asker(driver, begin=at)
        before = await driver.last_tell(None)
        asker.number -= 1
        told_again = await asker.do("tell", at=HERE, values={"loss": 0.0})  # the goal of the last
        return before, told_again, await driver.status(), await asker.do("ask", n=3)

    at = played(Gp, tmp_path / "killed", begin)
    played(Gp, tmp_path / "whole", begin)
    before, told_again, status, resumed = played(Gp, tmp_path / "killed", go_on)
    *_, other = played(Gp, tmp_path / "whole", go_on)

    assert before == {"goal_id": f"run/{at}", "told": 8}
    assert told_again == {"told": 8} and status["told"] == 8
    assert resumed == other and len(resumed["suggestions"]) == 3


def test_a_later_run_goes_on_with_a_study_by_its_name_and_others_begin_anew(tmp_path):
    async def story(driver):
        monday, tuesday, other = Asker(driver, "mon"), Asker(driver, "tue"), Asker(driver, "wed")
        await monday.do("define", **DEFINED, study="glass")
        await monday.do("tell", at=HERE, values={"loss": 1})
        fresh = await other.do("define", **DEFINED)
        again = await tuesday.do("define", **DEFINED, study="glass")
        resumed = await other.do("tell", at=HERE, values={"loss": 1})
        return fresh["told"], again["told"], resumed["told"]

    assert played(Gp, tmp_path, story) == (0, 1, 1)


def test_what_came_to_nothing_is_not_suggested_again_and_everything_only_once(tmp_path):
    small = {"x": {"minimum": 0, "maximum": 2, "step": 1}, "base": SPACE["base"]}

    async def story(driver):
        asker = Asker(driver)
        defined = {**DEFINED, "space": small, "constraints": ["x < 2 or base == 'soda'"]}
        places = (await asker.do("define", **defined))["places"]
        seen = (await asker.do("ask", n=2))["suggestions"]
        await asker.do("tell", at=seen[0], values={"loss": None})
        seen += (await asker.do("ask", n=10))["suggestions"]
        return places, seen, await failure(asker.do("ask")), await failure(asker.do("best"))

    places, seen, ended, best = played(Gp, tmp_path, story)

    assert places == 6
    assert sorted((p["x"], p["base"]) for p in seen) == [
        (0, "lime"), (0, "soda"), (1, "lime"), (1, "soda"), (2, "soda"),
    ]  # fmt: skip
    assert ended == "Exhausted: all 5 possible suggestions have been made"
    assert best.startswith("NoData")


def test_with_several_goals_the_front_is_told(tmp_path):
    goals = {"cost": "minimize", "yield": "maximize"}
    told = [(1, 1), (2, 3), (2, 2), (5, 4), (6, 4)]

    async def story(driver):
        asker = Asker(driver)
        await asker.do("define", space={"x": {"minimum": 0, "maximum": 9}}, goals=goals)
        for x, (cost, gain) in enumerate(told):
            await asker.do("tell", at={"x": x}, values={"cost": cost, "yield": gain})
        await asker.do("ask", n=2)
        return await asker.do("best")

    best = played(Gp, tmp_path, story)

    assert [row["at"]["x"] for row in best["front"]] == [0, 1, 3]
    assert best["values"] == {"cost": 2, "yield": 3}


@pytest.mark.slow
@pytest.mark.posix("SIGKILL")
def test_a_killed_server_has_every_tell_once_and_goes_on_as_if_nothing_was(tmp_path):
    """Told again with the same goals after each SIGKILL, as an engine would."""

    async def told(folder, kills) -> list:
        wanted = settings(CASE, CASE.read_contract(), {}, folder)
        points, server = [], None
        try:
            for turn in range(6):
                if server is None:
                    server = await start_server(wanted, folder)
                async with connected(CASE, CASE.read_contract(), server.url) as at:
                    if not turn:
                        assert (await at.do("define")).state == "SUCCEEDED"
                    (point,) = (await at.do("ask", {"n": 1})).result["suggestions"]
                    points.append(point)
                    tell = at.goal("tell", {"at": point, "values": {"loss": loss(point)}})
                    assert (await at.client.follow(tell)).state == "SUCCEEDED"
                    if kills:
                        os.kill(server.process.pid, signal.SIGKILL)
                        await server.process.wait()
                        await server.stop()
                        server = await start_server(wanted, folder)
                        async with connected(CASE, CASE.read_contract(), server.url) as again:
                            assert (await again.client.follow(tell, send=False)).result == {
                                "told": turn + 1
                            }
                            assert (await again.newest_status())["told"] == turn + 1
        finally:
            if server is not None:
                await server.stop()
        return points

    whole = asyncio.run(told(tmp_path / "whole", False))
    killed = asyncio.run(told(tmp_path / "killed", True))

    assert killed == whole
