"""`labrun record-program` while somebody works the program, and the driver that does it again."""

import asyncio
import time

import pytest
from ruamel.yaml import YAML

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.window_program.driver import WindowProgram
from labrun.drivers.window_program.hands import Hands
from labrun.schemas.contracts import read_contract

from .spectra import csv_text

CONTRACT = """
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
  last:
    summary: The newest
    effect: pure
    duration: 1 s
    returns: {type: object, properties: {goal_id: {type: string}}}
"""


class Person:
    """Somebody at the screen, with a mouse and a keyboard, who looks where things are."""

    def __init__(self, analyser) -> None:
        import pyautogui

        self.analyser, self.hands, self.keyboard = analyser, Hands(), pyautogui
        self.rest()

    def rest(self):
        self.hands.move(1700, 1000)
        time.sleep(0.4)

    def click(self, name, dx=0):
        x, y, w, h = self.analyser.places()[name]
        at = x + w // 2 + dx, y + h // 2
        self.rest()
        self.hands.move(*at)
        self.hands.press_mouse(*at)

    def until(self, seen):
        while not seen():
            time.sleep(0.05)

    def type(self, text):
        self.keyboard.write(text, interval=0.02)

    def press(self, key):
        self.keyboard.press(key)


@pytest.mark.slow
def test_what_somebody_did_once_the_driver_does_again(gui, terminal, tmp_path):
    (tmp_path / "recorder.yaml").write_text(CONTRACT)
    analyser = gui.start()
    cache, exports = analyser.folder / "cache", analyser.folder / "exports"
    person = Person(analyser)
    terminal = terminal(
        "record-program", "-o", "mine", "--contract", "recorder.yaml", "--title", "Profile Builder",
        "--watch", str(cache), "--watch", str(exports),
    )  # fmt: skip

    terminal.answer("fire (Record once): Enter", "")
    terminal.wait_for("recording fire")
    person.rest()
    person.click("measure")
    person.until(lambda: analyser.entries() and analyser.order("state") == "idle")
    terminal.press("\n")
    terminal.answer("is that the proof?", "")
    terminal.answer("save (Write what was recorded, with file)", "")
    terminal.wait_for("recording save")
    person.rest()
    person.click("sample_name", dx=140)
    person.type("K17 x-Y")
    person.click("export")
    person.until(lambda: "folder" in analyser.places())
    person.click("folder", dx=120)
    person.type(str(exports))
    person.press("enter")
    person.until(lambda: "export_finish" in analyser.places())
    person.click("export_finish")
    person.until(lambda: list(exports.iterdir()) and analyser.order("state") == "idle")
    terminal.press("\n")
    terminal.answer("'K17 x-Y' was typed: is it file, name", "name")
    terminal.answer("exports' was typed", "")
    terminal.answer("is that the proof?", "")
    terminal.wait_for("labrun call --lab")
    terminal.end()

    entry = YAML(typ="safe").load(tmp_path / "mine" / "lab.yaml")["devices"]["recorder"]
    save = entry["config"]["actions"]["save"]
    assert entry["config"]["actions"]["fire"] == {
        "steps": [{"click": "fire_1"}], "proof": {"new": str(cache), "called": "*"},
    }  # fmt: skip
    assert save["proof"] == {"new": str(exports), "called": "{name}*.csv"}
    assert save["file"] == "file"
    assert [word for step in save["steps"] for word in step] == [
        "click", "type", "click", "click", "type", "press", "click",
    ]  # fmt: skip

    async def again():
        place = Place(
            "rec", {**entry["config"], "dialog_s": 120}, {}, tmp_path / "work", tmp_path,
            read_contract(tmp_path / "recorder.yaml"),
        )  # fmt: skip
        driver = WindowProgram(place)
        await driver.open()
        try:
            await driver.method("fire")(GoalContext("g1"))
            goal = GoalContext("g2")
            await driver.method("save")(goal, file="out/a.csv")
            return goal.files["file"].data
        finally:
            await driver.close()

    data = asyncio.run(again())

    assert analyser.shots() == 2
    assert data == csv_text(max(analyser.entries()), "all", 2000).encode()
