"""The driver that `labrun new device` writes, with an instrument that speaks in its frames."""

import asyncio
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.find import find_driver
from labrun.engine.new.device.make import new_device
from labrun.engine.new.device.render import contract_text
from labrun.schemas.contracts import parse_contract, read_contract

from .instruments import running_peer


def written(folder: Path) -> Path:
    for name, text in new_device("hot_plate", None, with_lab=True).files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def story(tmp_path):
    """Runs actions one after another with what was written; a failure stands in place of a result."""

    def run(where, *actions):
        folder = written(tmp_path)
        contract = read_contract(folder / "hot_plate.yaml")
        there = Place("plate", {"resource": where}, {}, folder, folder, contract)

        async def all_of_it():
            driver = find_driver("./hot_plate.py:HotPlate", folder)(there)
            await driver.open()
            told = []
            for number, (name, values) in enumerate(actions):
                try:
                    told.append(await driver.method(name)(GoalContext(f"run/{number}"), **values))
                except ActionFailed as failure:
                    told.append((failure.name, failure.happened, failure.message))
            await driver.close()
            return told

        return asyncio.run(all_of_it())

    return run


def test_noise_pieces_and_frames_that_nobody_asked_for_are_passed_over(peer, story):
    there = peer("frame_peer.py")
    set_level = ("set_level", {"level": 12.5})
    told = story(there.where, set_level, ("read_level", {}), ("fire", {}), ("last_once", {}))

    assert told == [{"level": 12.5}, {"level": 12.5}, {}, {"goal_id": "run/2"}]
    assert there.done("fire") == [{"done": "fire"}]


def test_a_refusal_has_the_contracts_name_and_what_was_sent(peer, story):
    (told,) = story(peer("frame_peer.py").where, ("set_level", {"level": 60.0}))

    assert told[:2] == ("OutOfRange", "no")
    assert "plate was sent 05 10 00 00 70 42 and refused with status 1" in told[2]


def test_after_a_cut_a_reading_is_asked_again_and_a_count_tells_of_what_must_not_happen_twice(
    peer, story
):
    (read,) = story(peer("frame_peer.py", name="a", cuts=1).where, ("read_level", {}))
    there = peer("frame_peer.py", name="b", cuts=2)  # the first answer is the count before
    fire, last = story(there.where, ("fire", {}), ("last_once", {}))

    assert read == {"level": 0.0}
    assert fire[:2] == ("Lost", "unknown")
    assert last == {"goal_id": "run/0"}
    assert len(there.done("fire")) == 1


@pytest.mark.soak
class TestHotPlate(KeepsContract):
    case = Case(
        contract=parse_contract(contract_text("hot_plate"), "hot_plate.yaml"),
        lasting="fire", config={"timeout": "20 s"},
        good={
            "set_level": {"level": 40.0}, "read_level": {}, "shots": {}, "fire": {},
            "last_once": {}, "standby": {},
        },
    )  # fmt: skip

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def _written(cls, tmp_path_factory):
        folder = written(tmp_path_factory.mktemp("written"))
        place = f"{folder / 'hot_plate.py'}:HotPlate"
        cls.case = replace(cls.case, driver=place, contract=folder / "hot_plate.yaml")

    @contextmanager
    def peer(self, folder, *, slow):
        with running_peer(folder / "peer", "frame_peer.py", work_s=4.0 * slow) as there:
            yield {"resource": there.where}

    def happened(self, folder, goal_id):
        return '"fire"' in (folder / "peer" / "done.jsonl").read_text("utf-8")

    def rest(self, folder):
        time.sleep(5.0)
