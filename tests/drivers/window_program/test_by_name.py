"""Buttons by the names of their controls: what Windows' UI Automation tells, instead of pictures."""

import json

import pytest
from ruamel.yaml import YAML

from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.find import DriverFault
from labrun.drivers.sciaps_gui.driver import SciapsGui
from labrun.drivers.server.alone import alone_with
from labrun.drivers.window_program.buttons import ButtonsFault, read_buttons
from labrun.drivers.window_program.controls import Control
from labrun.drivers.window_program.controls_uia import UiaControls
from labrun.drivers.window_program.driver import WindowProgram
from labrun.drivers.window_program.recording import named_controls, save_names
from labrun.drivers.window_program.view import View
from labrun.drivers.window_program.windows import NoScreen, Window

from ..played import played
from .bench import QUICK
from .spectra import csv_text
from .test_window_program import CONTRACT
from .ui_automation import install

NAMES = """
labrun_buttons: 1
title: Profile Builder
buttons:
  measure: {control: {name: Measure, type: Button}}
  sample: {control: {id: sample, type: Edit}}
  export: {control: {name: Export*, type: Button}}
  status: {control: {id: status}}
  path: {control: {id: path, type: Edit}, where: dialog}
  separate: {control: {name: Separate spectra, type: CheckBox}, where: dialog}
  own_folder: {control: {name: In a new folder, type: CheckBox}, where: dialog}
  finish: {control: {name: Finish}, where: dialog}
export:
  - {click: sample}
  - {type: "{name}"}
  - {click: export}
  - {click: path}
  - {type: "{folder}"}
  - {press: enter}
  - {tick: separate}
  - {untick: own_folder}
  - {click: finish}
"""
MAIN = Window(7, "Acme", (0, 0, 300, 200), owned=False)


def told(name, kind="Button", known_id="", box=(10, 10, 80, 20), **more):
    return {"name": name, "id": known_id, "type": kind, "box": box, **more}


@pytest.fixture
def uia(monkeypatch):
    """Controls of windows that a test writes down: handle -> controls."""

    def of(windows):
        install(monkeypatch, lambda: windows)
        return UiaControls()

    return of


def test_a_control_is_found_by_name_id_and_type(uia):
    there = [
        told("Save as...", known_id="b1"), told("Save", known_id="b2", enabled=False),
        told("Save", "Text"), told("", "Edit", "path", value="C:/data"),
        told("Fast", "CheckBox", ticked=True), told("Odd", "CheckBox", ticked="neither"),
        told("Slow", "RadioButton", chosen=False), told("Hidden", offscreen=True),
        told("Flat", box=(1, 1, 0, 9)), told("Gone", gone=True),
    ]  # fmt: skip
    controls = uia({7: there})

    def found(**control):
        return [
            (c.name or c.id, c.enabled, c.ticked, c.text)
            for c in controls.find(MAIN, Control(**control))
        ]

    assert found(name="Save", type="Button") == [("Save", False, None, "Save")]
    assert found(name="Save*", type="Button") == [
        ("Save as...", True, None, "Save as..."), ("Save", False, None, "Save"),
    ]  # fmt: skip
    assert found(id="path") == [("path", True, None, "C:/data")]
    assert found(name="*a*t") == [("Fast", True, True, "Fast")]
    assert found(name="Odd") == [("Odd", True, None, "Odd")]
    assert found(name="Slow") == [("Slow", True, False, "Slow")]
    assert [found(name=name) for name in ("Hidden", "Flat", "Gone", "Sav")] == [[]] * 4
    assert controls.find(Window(8, "Closed", MAIN.box, owned=False), Control(name="Save")) == []
    with pytest.raises(NoScreen, match="no control of the type Knob"):
        found(name="Save", type="Knob")


def test_names_are_noted_where_they_tell_one_control_from_all_others(uia, tmp_path):
    box = Window(8, "Export", (50, 50, 100, 100), owned=True)
    there = {
        7: [told("Start!"), told("Start!", "Text"), told("Add", known_id="a"), told("Add", known_id="b"),
            told("Twin"), told("Twin"), told("", "Edit", "x1")],
        8: [told("Start!")],
    }  # fmt: skip
    view = View(None, (0, 0), 1.0, MAIN, (box,), "")  # type: ignore[arg-type]
    entries = named_controls(view, uia(there))
    (tmp_path / "buttons.yaml").write_text("buttons: {start: {file: start.png}} # mine\n")
    new = save_names(tmp_path, "Acme", entries)
    said = YAML(typ="safe").load((tmp_path / "buttons.yaml").read_text())

    assert entries == {
        "start": {"control": {"name": "Start!", "type": "Button"}, "where": "dialog"},
        "start_": {"control": {"name": "Start!", "type": "Button"}},
        "start__": {"control": {"name": "Start!", "type": "Text"}},
        "add": {"control": {"id": "a", "type": "Button"}},
        "add_": {"control": {"id": "b", "type": "Button"}},
        "x1": {"control": {"id": "x1", "type": "Edit"}},
    }
    assert new == ["start_", "start__", "add", "add_", "x1"]
    assert said["title"] == "Acme"
    assert said["buttons"] == entries | {"start": {"file": "start.png"}}


@pytest.mark.parametrize(
    ("written", "words"),
    [
        (
            "title: A\nbuttons: {measure: {control: {type: Button}}}",
            "a control has a `name`, or an `id`",
        ),
        (
            "title: A\nbuttons: {measure: {where: main}}",
            "a button has a picture, `file`, or a `control`",
        ),
        ("buttons: {measure: {control: {name: M}}}", "write `title`"),
    ],
)
def test_what_is_wrong_with_a_button_by_name(tmp_path, written, words):
    (tmp_path / "buttons.yaml").write_text("labrun_buttons: 1\n" + written)

    with pytest.raises(ButtonsFault, match=words):
        read_buttons(tmp_path, needed=())


def test_one_device_server_at_a_time_works_a_window(tmp_path, monkeypatch):
    (tmp_path / "buttons.yaml").write_text(NAMES)
    step = {"steps": [{"click": "measure"}], "proof": {"title": "Done"}}
    config = {"buttons": str(tmp_path), "actions": {"fire": step, "save": step}}

    def recorder(screen, **other):
        monkeypatch.setenv("DISPLAY", screen)
        place = Place("rec", config | other, {}, tmp_path, tmp_path, contract=CONTRACT)
        return WindowProgram(place).alone

    mine = recorder(f":9{tmp_path.name}")
    folders = {name: str(tmp_path) for name in ("buttons", "cache", "exports")}
    analyser = SciapsGui(Place("libs", folders, {}, tmp_path, tmp_path)).alone

    assert mine == recorder(f":9{tmp_path.name}.0") == analyser
    assert len({mine, recorder(":8"), recorder(f":9{tmp_path.name}", title="Other")}) == 3
    with alone_with(mine), pytest.raises(OSError, match=r"on the screen :9.* has a device server"):
        alone_with(analyser)


def test_only_a_controls_text_can_be_read(tmp_path):
    (tmp_path / "buttons.yaml").write_text(NAMES)
    proof = {"reads": "state", "says": "Done"}
    one = {"steps": [{"click": "measure"}], "proof": proof}
    config = {"buttons": str(tmp_path), "actions": {"fire": one, "save": one}}

    with pytest.raises(DriverFault, match=r"proof.reads: state has no `control`"):
        WindowProgram(Place("rec", config, {}, tmp_path, tmp_path, contract=CONTRACT))


@pytest.fixture
def named(screen, tmp_path, monkeypatch):
    """The test's program, whose controls can be asked for; no picture of it was recorded."""
    from labrun.drivers.window_program.windows_x11 import X11Windows

    from .bench import Analyser

    started, desktop = [], X11Windows()

    def start(**options):
        program = tmp_path / "program"
        analyser = Analyser(program, **options).start()
        started.append(analyser)

        def windows():
            told = json.loads(analyser.order("controls"))
            return {w.id: told[w.title] for w in desktop.listed() if w.title in told}

        install(monkeypatch, windows)
        monkeypatch.setattr(
            "labrun.drivers.window_program.program.open_controls", lambda: UiaControls()
        )
        (tmp_path / "buttons.yaml").write_text(NAMES)
        return analyser

    yield start
    for analyser in started:
        analyser.end()
    desktop.close()


@pytest.mark.slow
def test_a_program_is_worked_by_names_alone_and_its_text_is_the_proof(named, tmp_path):
    analyser = named(measure_s=5)  # long enough for the other text to be seen on a busy machine
    exports = str(tmp_path / "program" / "exports")
    said = YAML(typ="safe").load(NAMES)["export"]
    steps = [{w: t.replace("{folder}", exports) for w, t in step.items()} for step in said]
    actions = {
        "fire": {"steps": [{"click": "measure"}], "proof": {"reads": "status", "says": "Rea*"}},
        "save": {
            "steps": steps,
            "file": "file",
            "proof": {"new": exports, "called": "{name}_1.csv"},
        },
    }
    config = {"buttons": str(tmp_path), "actions": actions, "settle_s": 0.4, "dialog_s": 20}

    async def story(driver):
        await driver.fire(GoalContext("g1"))
        goal = GoalContext("g2")
        await driver.save(goal, file="a.csv")
        return goal.files["file"].data

    driver = WindowProgram(Place("rec", config, {}, tmp_path / "mine", tmp_path, contract=CONTRACT))
    data = played(driver, story)
    (entry,) = analyser.entries()

    assert analyser.shots() == 1
    assert data == csv_text(entry, "1", 2000).encode()


@pytest.mark.slow
def test_an_analyser_is_worked_by_names_and_a_disabled_button_is_not_clicked(named, tmp_path):
    analyser = named()
    program = tmp_path / "program"
    config = {
        "buttons": str(tmp_path), "cache": str(program / "cache"), "exports": str(program / "exports"),
        **QUICK, "busy_s": 1,
    }  # fmt: skip

    async def story(driver):
        await driver.locate(GoalContext("l"))
        shot = (await driver.measure(GoalContext("m")))["shot_id"]
        goal = GoalContext("e")
        await driver.export(goal, shot=shot, file="a.csv")
        analyser.order("open set_busy_for_ever")
        with pytest.raises(ActionFailed) as caught:
            await driver.measure(GoalContext("m2"))
        return goal.files["file"].data, caught.value

    data, failure = played(SciapsGui(Place("libs", config, {}, tmp_path / "mine", tmp_path)), story)
    (entry,) = analyser.entries()

    assert data == csv_text(entry, "1", 2000).encode()
    assert (failure.name, failure.happened, analyser.shots()) == ("Busy", "no", 1)
    assert "greyed out" in failure.message
