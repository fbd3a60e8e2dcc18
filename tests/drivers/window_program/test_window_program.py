"""Any contract kept with a program's window: steps, a proof for each, one pass a goal."""

import asyncio

import pytest
from ruamel.yaml import YAML

from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.find import DriverFault
from labrun.drivers.window_program.config import read_config
from labrun.drivers.window_program.driver import WindowProgram
from labrun.schemas.contract import Contract

from .spectra import csv_text

CONTRACT = Contract.model_validate(
    YAML(typ="safe").load("""
type: recorder@1
summary: Something that records
actions:
  fire: {summary: Record once, effect: once, probe: last, duration: 1 s}
  save:
    summary: Write what was recorded
    effect: idempotent
    duration: 1 s
    params: {type: object, required: [file], properties: {file: {type: string, format: path}}}
    returns: {type: object, properties: {file: {type: string, format: path}, sha256: {type: string}}}
    errors: {DialogOpen: {happened: unknown}}
  last:
    summary: The newest
    effect: pure
    duration: 1 s
    returns: {type: object, properties: {goal_id: {type: string}}}
""")
)
SAVE = [
    {"click": "sample_name"}, {"type": "{name}"}, {"click": "export"}, {"wait": "folder"},
    {"type": "EXPORTS"}, {"press": "enter"}, {"tick": "separate_spectrum"},
    {"untick": "new_folder"}, {"click": "export_finish"},
]  # fmt: skip


class Recorder:
    """The analyser's program under another contract."""

    def __init__(self, gui) -> None:
        self.gui = gui
        known = gui.config()
        steps = [{w: t.replace("EXPORTS", known["exports"]) for w, t in s.items()} for s in SAVE]
        self.config = {
            "buttons": known["buttons"],
            "dialog_s": 10, "busy_s": 30, "settle_s": 0.4,
            "actions": {
                "fire": {"steps": [{"click": "measure"}], "proof": {"new": known["cache"]}, "within_s": 30},
                "save": {
                    "steps": steps, "file": "file", "within_s": 30,
                    "proof": {"new": known["exports"], "called": "{name}_1.csv"},
                },
            },
        }  # fmt: skip

    def play(self, story):
        async def played():
            mine = self.gui.folder / "mine"
            driver = WindowProgram(
                Place("rec", self.config, {}, mine, self.gui.folder, contract=CONTRACT)
            )
            await driver.open()
            try:
                return await story(driver)
            finally:
                await driver.close()

        return asyncio.run(played())


@pytest.fixture
def recorder(gui):
    return Recorder(gui)


@pytest.mark.slow
def test_a_goal_is_one_pass_of_its_steps_and_its_file_is_the_new_one(recorder):
    analyser = recorder.gui.start()

    async def story(driver):
        empty = await driver.last(GoalContext("p0"))
        await driver.fire(GoalContext("g1"))
        goal = GoalContext("g2")
        result = await driver.save(goal, file="out/a.csv")
        with pytest.raises(ActionFailed) as again:
            await driver.fire(GoalContext("g1"))
        return empty, result, goal.files["file"], again.value, await driver.last(GoalContext("p"))

    empty, result, file, again, last = recorder.play(story)
    (entry,) = analyser.entries()

    assert (empty, last) == ({"goal_id": None}, {"goal_id": "g1"})
    assert file.data == csv_text(entry, "1", 2000).encode()
    assert result == {"file": "out/a.csv", "sha256": file.sha256}
    assert (again.name, again.happened, analyser.shots()) == ("Rejected", "unknown", 1)


@pytest.mark.slow
def test_a_goal_that_is_stopped_after_a_look_does_no_further_step(recorder):
    analyser = recorder.gui.start()

    async def story(driver):
        goal = GoalContext("g1")
        goal.tell = lambda progress, message: goal.cancelled.set()  # as its first step is told
        with pytest.raises(ActionFailed, match="it was stopped") as caught:
            await driver.fire(goal)
        return caught.value.happened

    assert (recorder.play(story), analyser.shots()) == ("no", 0)


@pytest.mark.slow
def test_steps_without_their_proof_are_unknown_and_the_probe_finds_a_late_one(recorder):
    analyser = recorder.gui.start(measure_s=12.0)
    recorder.config["actions"]["fire"]["within_s"] = 2

    async def story(driver):
        with pytest.raises(ActionFailed) as caught:
            await driver.fire(GoalContext("g1"))
        unclear = await driver.last(GoalContext("p1"))
        async with asyncio.timeout(500):
            while not analyser.entries():  # noqa: ASYNC110 - another process makes them
                await asyncio.sleep(0.1)
        return caught.value, unclear, await driver.last(GoalContext("p2"))

    failure, unclear, last = recorder.play(story)

    assert (failure.name, failure.happened) == ("Timeout", "unknown")
    assert "after 2 s there is no proof: {'new': " in failure.message
    assert (unclear, last) == ({"goal_id": None}, {"goal_id": "g1"})


@pytest.mark.slow
def test_a_dialog_of_somebody_else_is_not_touched(recorder):
    analyser = recorder.gui.start()
    analyser.order("open ask_boxes_here")

    async def story(driver):
        with pytest.raises(ActionFailed) as caught:
            await driver.save(GoalContext("g"), file="a.csv")
        return caught.value

    failure = recorder.play(story)

    assert (failure.name, failure.happened) == ("DialogOpen", "no")
    assert "export_finish" in analyser.places()


@pytest.mark.slow
def test_a_picture_named_by_a_parameter_that_was_not_recorded_is_told(recorder):
    recorder.gui.start()
    recorder.config["actions"]["save"]["steps"] = [{"click": "to_{file}"}]

    async def story(driver):
        with pytest.raises(ActionFailed) as caught:
            await driver.save(GoalContext("g"), file="a.csv")
        return caught.value

    failure = recorder.play(story)

    assert (failure.name, failure.happened) == ("Rejected", "no")
    assert "click to_a.csv: it was not recorded" in failure.message


FIRE = {"steps": [{"click": "measure"}], "proof": {"shows": "measure"}}


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        ({"fire": FIRE}, "save of recorder@1 has no steps"),
        ({"fire": FIRE, "save": FIRE, "go": FIRE}, "config.actions.go: recorder@1 has fire, save, last"),
        ({"fire": {"steps": FIRE["steps"]}, "save": FIRE}, "fire: it has no proof that it is done"),
        ({"fire": FIRE | {"proof": {}}, "save": FIRE}, "a proof has one of new, shows, gone, title"),
        ({"fire": FIRE | {"steps": [{"type": "{x}"}]}, "save": FIRE}, "'{x}' cannot be filled in"),
        ({"fire": FIRE | {"steps": [{"hit": "x"}]}, "save": FIRE}, "actions.fire.steps.0.hit"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_configuration(actions, words):
    with pytest.raises(ValueError, match=words):
        read_config({"buttons": "b", "actions": actions}, CONTRACT)


def test_a_button_that_was_not_recorded_is_told_at_the_start(recorder, tmp_path):
    recorder.config["actions"]["fire"]["steps"] = [{"click": "start"}]

    with pytest.raises(DriverFault, match=r"start was not recorded; record it with `labrun"):
        recorder.play(lambda driver: driver.safe())
