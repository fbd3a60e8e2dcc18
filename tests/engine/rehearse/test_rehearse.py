"""A rehearsal predicts a run: how long, how far, how often, and what would go wrong."""

import asyncio
import time
from pathlib import Path
from typing import Any

import pytest

from labrun.drivers import reducer
from labrun.drivers.driver import Driver, GoalContext, Place
from labrun.drivers.world import WorldInMemory
from labrun.engine.check import check_file
from labrun.engine.commands.options import WrongUsage
from labrun.engine.commands.rehearse import looked_at, ordered
from labrun.engine.journal.gantt import Gantt
from labrun.engine.lab.lab import load_lab
from labrun.engine.rehearse import twin_choice
from labrun.engine.rehearse.rehearse import NoRehearsal, Rehearsal, devices_heard, devices_read
from labrun.engine.rehearse.table import duration, gantt, lines
from labrun.schemas.contracts import shipped_contracts
from labrun.schemas.messages import FileContent

SHIPPED = Path(__file__).parents[3] / "protocols"
HEAD = "labrun: 1\nname: r\ndevices: {gantry: gantry@1, libs: libs_analyzer@1}\n"


def rehearsed(folder, steps, *, faults=None, lab=None, seed=None, head=HEAD, shown=None):
    path = folder / "r.yaml"
    path.write_text(head + steps, encoding="utf-8")
    checked = check_file(path, lab=lab)
    assert checked.ok, checked.problems
    return Rehearsal(checked, faults or {}, seed, gantt=shown or Gantt()).play()


SCAN = """
steps:
  - id: scan
    foreach: {x: "${{ span(0, 10, 2) }}"}
    keep_going: {max_failed: 9}
    steps:
      - repeat: 2
        steps: [{id: move, do: gantry.move_to, with: {x: "${{ x }}", y: 1 mm, z: 0 mm}}]
      - {id: shoot, do: libs.measure, timeout: 20 s, retry: {attempts: 2, wait: 5 s}}
"""


def test_a_scan_takes_as_long_as_the_twins_say(tmp_path):
    totals = rehearsed(tmp_path, SCAN)

    assert totals.fate == "succeeded"
    assert totals.once["libs.measure"] == 6
    assert totals.seconds["libs.measure"] == pytest.approx(6 * 8, abs=0.1)
    assert totals.lasts_s == pytest.approx(sum(totals.seconds.values()), abs=0.5)
    assert [(p.name, p.iterations) for p in totals.parts] == [("scan", 6)]
    assert totals.points.words() == "6 of 6 measured"


def test_the_path_is_the_way_that_the_gantry_really_went(tmp_path):
    steps = "steps:\n" + "".join(
        f"  - {{do: gantry.move_to, with: {{x: {x}, y: {y}, z: 100}}}}\n"
        for x, y in [(30, 40), (30, 0), (0, 0)]
    )

    assert rehearsed(tmp_path, steps).path_mm["gantry"] == pytest.approx(50 + 40 + 30, abs=0.1)


@pytest.mark.parametrize(
    ("steps", "ends"),
    [
        ("[{wait: 20 min}, {wait: 1 h}]", ""),
        ("[{steps: [{repeat: 9, steps: [{wait: 5 min}], timeout: 2 h}]}]", ""),
        ("[{wait: '${{ params.cool }}'}]", ""),
        ("[{repeat: 9, steps: [{wait: 5 min}]}]", "finally: not finished within 900 s; a step"),
    ],
)
def test_finally_may_take_what_its_steps_state_and_ten_minutes(tmp_path, steps, ends):
    main = "params: {cool: {type: quantity, unit: h, default: 3 h}}\nsteps: [{do: gantry.home}]\n"
    totals = rehearsed(tmp_path, f"{main}finally: {steps}\n")

    assert totals.fate == ("failed" if ends else "succeeded")
    assert totals.reason.startswith(ends)


def test_faults_to_order_show_what_would_happen(tmp_path):
    calm = rehearsed(tmp_path, SCAN)
    totals = rehearsed(tmp_path, SCAN, faults={"libs": {"measure": {"ButtonNotFound": 0.5}}})
    told = "\n".join(lines(totals, 0.1))

    (trouble,) = totals.troubles
    assert (trouble.action, trouble.error) == ("libs.measure", "ButtonNotFound")
    assert trouble.count == totals.sent_again + totals.holes
    assert totals.lasts_s != calm.lasts_s
    assert f"libs.measure: ButtonNotFound, {trouble.count} time" in told
    assert f"points: {6 - totals.holes} of 6 measured, {totals.holes} failed" in told


def test_what_each_device_does_when_is_drawn(tmp_path):
    steps = (
        "steps:\n  - {do: libs.locate}\n  - {wait: 20 s}\n  - parallel:\n"
        "      - {do: gantry.move_to, with: {x: 200 mm, y: 0 mm, z: 100 mm}}\n"
        "      - steps: [{wait: 1 s}, {do: libs.locate}]\n"
    )
    whole = rehearsed(tmp_path, steps)
    drawn = {row.split()[0]: row for row in gantt(whole) if row}
    late = "\n".join(gantt(rehearsed(tmp_path, steps, shown=looked_at("1 h", ""))))

    assert list(whole.gantt) == ["libs.locate", "gantry.move_to"]
    assert sum(whole.gantt["libs.locate"]) / 120 * whole.lasts_s == pytest.approx(
        whole.seconds["libs.locate"], rel=0.05
    )
    assert drawn["when"].startswith("when            0")
    assert drawn["gantry.move_to"].index("█") > 40
    assert "No action is under way from 1 h 00 min" in late


def test_the_same_seed_has_the_same_luck(tmp_path):
    faults = {"libs": {"measure": 0.3}}
    one, same, other = (
        rehearsed(tmp_path, SCAN, faults=faults, seed=seed).as_dict() for seed in (1, 1, 2)
    )

    assert one == same
    assert one != other


def test_waits_and_timeouts_pass_on_virtual_time(tmp_path):
    totals = rehearsed(
        tmp_path,
        "steps:\n  - {wait: 3 h}\n  - {do: libs.measure, timeout: 2 s, on_error: continue}\n",
    )

    assert totals.lasts_s == pytest.approx(3 * 3600 + 8, abs=15)
    assert totals.slow["libs.measure"][1] == 2


def test_a_person_is_not_waited_for_but_is_named(tmp_path):
    totals = rehearsed(tmp_path, "steps:\n  - {ask: 'Which one?', choices: [left, right]}\n")

    assert totals.questions == ["Which one?"]
    assert totals.fate == "succeeded"


def test_what_fails_for_good_is_told_with_its_reason(tmp_path):
    totals = rehearsed(tmp_path, "steps:\n  - {do: gantry.home}\n  - {fail: 'no argon'}\n")

    assert totals.fate == "failed"
    assert "no argon" in totals.reason


def test_no_driver_of_real_hardware_is_imported_to_find_a_twin(monkeypatch):
    asked: list[str] = []
    find = twin_choice.find_driver
    monkeypatch.setattr(
        twin_choice, "find_driver", lambda name, base: asked.append(name) or find(name, base)
    )
    lab, _ = load_lab(SHIPPED / "labs" / "aecp.yaml")
    assert lab is not None
    played = {name: twin_choice.player(name, lab)[2] for name in ("gantry", "reduce")}

    assert played == {"gantry": "the twin sim_gantry", "reduce": "the reduction itself"}
    assert {name for name in asked if not name.startswith("sim_")} == {
        "openbuilds",
        "gp",
        "reducer",
    }
    assert asked[-1] == "reducer"


def test_a_device_without_a_twin_is_played_by_a_stand_in(tmp_path):
    (tmp_path / "furnace.yaml").write_text(
        "type: furnace@1\nsafe_state: [cool]\nactions:\n"
        "  cool: {effect: idempotent, duration: 1 s}\n"
        "  heat:\n    effect: once\n    duration: 20 min\n"
        "    params: {type: object, required: [to], properties: {to: {type: number, unit: degC}}}\n"
        "    returns: {type: object, required: [to, state], properties:"
        " {to: {type: number, unit: degC}, state: {enum: [hot, cold]}}}\n"
        "    errors: {Door: {happened: no}}\n"
    )
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "name: l\ncontracts: [./furnace.yaml]\n"
        "devices: {oven: {contract: furnace@1, driver: not_installed_here}}\n"
    )
    head = "labrun: 1\nname: r\ndevices: {oven: furnace@1}\n"
    steps = (
        "steps:\n  - {id: h, do: oven.heat, with: {to: 800}}\n"
        "  - require: ${{ steps.h.state == 'hot' }}\n"
    )
    totals = rehearsed(tmp_path, steps, lab=lab, head=head)
    broken = rehearsed(tmp_path, steps, lab=lab, head=head, faults={"oven": {"heat": {"Door": 1}}})

    assert totals.fate == "succeeded", totals.reason
    assert totals.lasts_s == pytest.approx(1201)  # the safe state takes a second
    assert "no twin keeps furnace@1" in totals.players["oven"]
    assert [t.error for t in broken.troubles] == ["Door"]
    assert broken.fate == "failed"


def test_a_lab_of_real_devices_is_rehearsed_with_their_twins(tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "name: bench\ndevices:\n"
        "  gantry: {contract: gantry@1, driver: some_gantry, config: {port: /dev/ttyUSB0}}\n"
        "  libs: {contract: libs_analyzer@1, url: 'http://10.0.0.7:4101'}\n"
    )
    totals = rehearsed(tmp_path, "steps:\n  - {do: gantry.home}\n  - {do: libs.measure}\n", lab=lab)

    assert totals.players == {"gantry": "the twin sim_gantry", "libs": "the twin sim_libs"}
    assert totals.fate == "failed"  # home leaves the gantry at 100 mm: no light from there
    assert "out of focus" in totals.reason


@pytest.mark.parametrize("part", [("3 mm", ""), ("0 s", "soon"), ("2 min", "1 min")])
def test_a_part_of_the_time_that_cannot_be_is_said(part):
    with pytest.raises(WrongUsage, match=r"write times, such as|is not before"):
        looked_at(*part)


def test_faults_that_cannot_be_are_said(tmp_path):
    with pytest.raises(NoRehearsal, match="libs: faults: measure of libs_analyzer@1 cannot fail"):
        rehearsed(tmp_path, SCAN, faults={"libs": {"measure": {"Rain": 0.5}}})


def test_an_action_that_is_to_fail_and_is_never_done_is_told(tmp_path):
    move = "steps: [{do: gantry.move_to, with: {x: 1 mm}}]\n"
    totals = rehearsed(tmp_path, move, faults={"gantry": {"home": 1.0}})

    assert totals.fate == "succeeded"
    assert (
        list(lines(totals, 0.1))[-1] == "gantry.home cannot fail here: no step that runs does it."
    )


@pytest.mark.soak
def test_the_shipped_map_takes_four_hours(tmp_path):
    checked = check_file(SHIPPED / "pegmatite_map.yaml", params={"pitch": "2 mm"})
    totals = Rehearsal(checked).play()

    scan = next(part for part in totals.parts if part.name == "scan")
    assert scan.iterations == 18
    assert 12 < scan.takes_s / scan.iterations < 18  # the paper states 15 s per point


@pytest.mark.parametrize(
    ("seconds", "told"),
    [
        (0, "0.0 s"),
        (59.94, "59.9 s"),
        (60, "1 min 00 s"),
        (3599.6, "1 h 00 min"),
        (14760, "4 h 06 min"),
    ],
)
def test_durations_are_told_as_people_do(seconds, told):
    assert duration(seconds) == told


ANY_ERROR = """
steps:
  - {do: gantry.home}
  - foreach: {x: "${{ range(20) }}"}
    keep_going: true
    steps:
      - {do: gantry.move_to, with: {x: "${{ x * 1 mm }}", y: 1 mm, z: 0 mm}, retry: 3}
      - {do: libs.measure, timeout: 15 s, on_unknown: skip}
"""


@pytest.mark.parametrize(
    ("device", "action", "error"),
    [
        ("libs", "measure", "Timeout"), ("libs", "measure", "Lost"), ("gantry", "move_to", "Busy"),
        ("gantry", "move_to", "Timeout"),
    ],
)  # fmt: skip
def test_errors_that_any_action_may_end_with_can_be_ordered_too(tmp_path, device, action, error):
    calm = rehearsed(tmp_path, ANY_ERROR)
    totals = rehearsed(tmp_path, ANY_ERROR, faults={device: {action: {error: 0.3}}})

    (trouble,) = totals.troubles
    assert (calm.troubles, calm.fate) == ([], "succeeded")
    assert (trouble.action, trouble.error) == (f"{device}.{action}", error)
    assert trouble.count == totals.sent_again + totals.holes > 2
    if error == "Timeout":  # it hangs until its run gives it up
        longer = totals.seconds[trouble.action] - calm.seconds[trouble.action]
        assert longer > trouble.count * 5


def test_a_while_that_never_ends_is_told_in_a_sentence(tmp_path):
    endless = "steps:\n  - while: true\n    steps: [{wait: 1 s}]\n"
    (tmp_path / "r.yaml").write_text(HEAD + endless)
    checked = check_file(tmp_path / "r.yaml")
    totals = Rehearsal(checked, turns=50).play()

    assert totals.fate == "aborted"
    assert "a `while` without `max` has taken 50 turns" in totals.reason
    assert totals.lasts_s == pytest.approx(50)


@pytest.mark.parametrize(
    ("read", "devices"),
    [("", set()), ("status.gantry.state == 'idle'", {"gantry"}),
     ("status[['gantry', 'libs'][0]] == 1", {"gantry", "libs"})],
)  # fmt: skip
def test_only_devices_whose_status_is_read_are_looked_at(tmp_path, read, devices):
    (tmp_path / "r.yaml").write_text(
        HEAD
        + f'steps: [{{do: gantry.home, when: "${{{{ {read or "true"} }}}}"}}, {{do: libs.locate}}]\n'
    )
    checked = check_file(tmp_path / "r.yaml")
    assert checked.survey is not None
    assert devices_read(checked.survey) == devices


@pytest.mark.parametrize(
    ("more", "heard"),
    [
        ("", set()),
        ("outputs: {li: '${{ steps.all.total }}'}", set()),
        ("outputs: {li: '${{ steps.one.areas.Li }}'}", {"reduce"}),
        ("outputs: {li: '${{ steps[\"one\"] }}', shot: '${{ steps.shoot.shot_id }}'}", {"libs", "reduce"}),
        ("outputs: {li: '${{ steps.some.areas.Li }}'}", {"gantry", "libs", "reduce"}),
        ("outputs: {li: '${{ steps }}'}", {"gantry", "libs", "reduce"}),
    ],
)  # fmt: skip
def test_an_answer_that_only_fills_a_table_decides_nothing(tmp_path, more, heard):
    (tmp_path / "r.yaml").write_text(
        HEAD.replace("libs:", "reduce: spectrum_reducer@1, libs:")
        + "steps:\n  - {id: shoot, do: libs.measure}\n  - id: all\n    repeat: 2\n"
        "    steps: [{id: one, do: reduce.reduce, with: {spectrum: s.csv}}]\n"
        "    collect: {li: '${{ steps.one.areas.Li }}'}\n"
        f"  - {{id: some, steps: [{{do: reduce.reduce, with: {{spectrum: s.csv}}}}]}}\n{more}\n"
    )
    checked = check_file(tmp_path / "r.yaml")
    assert checked.survey is not None
    assert devices_heard(checked.survey) == heard


def test_what_repeats_its_answers_computes_one_of_a_kind():
    computed: list[bytes] = []

    class Computing(Driver):
        async def reduce(self, goal, *, spectrum, elements=None):
            computed.append(goal.files["spectrum"].data)
            return {"areas": len(computed)}

    async def asked(spectrum, elements):
        goal = GoalContext("g", files={"spectrum": FileContent.of("s.csv", spectrum)})
        return (await driver.reduce(goal, spectrum="s.csv", elements=elements))["areas"]

    world = WorldInMemory()
    contract = shipped_contracts()["spectrum_reducer@1"]
    made = twin_choice.repeating(Computing, contract, world)
    driver: Any = made(Place("r", {}, {}, Path(), Path()))
    unmade = [world.content(lambda n=n: b"counts %d" % n) for n in range(3)]
    given = [*((one, None) for one in unmade), (unmade[2], ["Li"]), (b"a", None), (b"b", None)]

    assert [asyncio.run(asked(*one)) for one in [*given, (b"a", None)]] == [1, 1, 1, 2, 3, 4, 3]
    assert computed == [b"counts 0", b"counts 2", b"a", b"b"]


@pytest.mark.parametrize(
    ("takes_s", "heard"),
    [
        (0, ""),
        (0, "outputs: {li: '${{ steps.one.areas }}'}"),
        (0.05, "outputs: {li: '${{ steps.one.areas }}'}"),
    ],
)  # fmt: skip
def test_computing_takes_what_the_contract_says_on_a_slow_computer_too(
    tmp_path, monkeypatch, takes_s, heard
):
    monkeypatch.setattr(reducer, "_warm_up", lambda: None)
    monkeypatch.setattr(reducer, "_reduce", lambda *given: time.sleep(takes_s) or {"areas": {}})
    steps = f"""
steps:
  - {{do: gantry.home}}
  - {{do: gantry.move_to, with: {{z: 0 mm}}}}
  - repeat: 3
    steps:
      - {{id: shot, do: libs.measure}}
      - {{do: libs.export, with: {{shot: "${{{{ steps.shot.shot_id }}}}", file: s.csv}}}}
      - {{do: reduce.reduce, with: {{spectrum: s.csv}}}}
  - {{id: one, do: reduce.reduce, with: {{spectrum: s.csv}}}}
{heard}
"""
    totals = rehearsed(
        tmp_path, steps, head=HEAD.replace("libs:", "reduce: spectrum_reducer@1, libs:")
    )

    assert (totals.fate, totals.reason) == ("succeeded", "")
    assert totals.seconds["reduce.reduce"] == pytest.approx(4 * 0.05)


def test_a_thread_that_computes_when_a_rehearsal_ends_takes_no_virtual_time(tmp_path, monkeypatch):
    monkeypatch.setattr(reducer, "_warm_up", lambda: time.sleep(0.1))
    head = HEAD.replace("libs: libs_analyzer@1", "reduce: spectrum_reducer@1")

    assert rehearsed(tmp_path, "steps: [{do: gantry.home}]\n", head=head).lasts_s == 4


def test_a_pause_ends_a_rehearsal_in_a_sentence(tmp_path):
    steps = "steps:\n  - {wait: 3 s}\n  - {fail: no sample, on_error: pause}\n"

    totals = rehearsed(tmp_path, steps)

    assert totals.fate == "aborted"
    assert totals.reason == (
        "it pauses and waits for a person: no sample; `labrun continue` tries the step again"
    )


def test_times_of_day_are_those_of_the_virtual_clock(tmp_path):
    night = """
steps:
  - {id: night, wait: {until: "${{ now() + 9 h }}"}}
  - while: ${{ elapsed() < 20 h }}
    steps: [{wait: 30 min}]
  - {require: "${{ steps.night.took >= 9 h and steps.night.took < 9.1 h }}"}
"""
    totals = rehearsed(tmp_path, night, head="labrun: 1\nname: r\n")

    assert totals.fate == "succeeded"
    assert totals.lasts_s == pytest.approx(20 * 3600, abs=1801)


def test_a_fault_without_a_chance_always_comes(tmp_path):
    (tmp_path / "p.yaml").write_text(HEAD + ANY_ERROR, encoding="utf-8")
    checked = check_file(tmp_path / "p.yaml")

    assert ordered(["libs.measure.Timeout", "gantry.move_to:0.5"], checked) == {
        "libs": {"measure": {"Timeout": 1.0}}, "gantry": {"move_to": 0.5},
    }  # fmt: skip
    with pytest.raises(WrongUsage, match="a chance from 0 to 1"):
        ordered(["libs.measure:often"], checked)
