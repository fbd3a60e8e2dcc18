"""What a resume sees of the time between two sessions, and what it takes over from the one before."""

from pathlib import Path

import pytest
from ruamel.yaml import YAML

SCRIPTED = f"{Path(__file__).parents[1] / 'scripted_lab' / 'scripted.py'}:Scripted"
NO_SAFE_STATE = {"safe_state": []}
"""A device that is left as it is when a run ends: only somebody else changes it."""


@pytest.mark.parametrize("somebody", ["stops", "uses"])
def test_what_somebody_else_may_have_undone_in_between_is_done_again(own_device, somebody):
    device = own_device(**NO_SAFE_STATE)
    device.run("""
steps:
  - {do: a.act, with: {name: lower}}
  - {do: a.shoot, with: {name: shot, script: "Broken,ok"}}
""")
    device.stop_by_hand() if somebody == "stops" else device.use_by_hand()

    ran = device.resume()

    assert ran.status == 0
    assert ran.sent() == ["lower", "shot", "lower", "shot"]
    assert [(r.device, r.reason) for r in ran.records if r.kind == "touched"] == [
        ("a", "another client held or stopped it in between")
    ]


def test_what_nobody_has_touched_in_between_is_not_done_again(own_device):
    device = own_device(**NO_SAFE_STATE)
    device.run("""
steps:
  - {do: a.act, with: {name: lower}}
  - {do: a.shoot, with: {name: shot, script: "Broken,ok"}}
""")

    ran = device.resume()

    assert ran.status == 0
    assert ran.sent() == ["lower", "shot", "shot"]
    assert not [r for r in ran.records if r.kind == "touched"]


IN_DOUBT = """
steps:
  - {id: shot, do: a.shoot, with: {name: shot, script: "WORDS"}, on_unknown: ask}
"""


def test_a_shot_that_somebody_elses_shot_may_hide_is_not_fired_again(own_device):
    device = own_device()
    device.run(IN_DOUBT.replace("WORDS", "happened!,ok"), answers={"shot": "stop"})
    device.use_by_hand()

    ran = device.resume(answers={"shot": "skip"})

    assert ran.sent() == ["shot"]
    assert [r.choice for r in ran.records if r.kind == "answered"] == ["stop", "skip"]


def test_a_shot_that_nobody_elses_shot_can_hide_is_settled_by_the_device(own_device):
    device = own_device()
    device.use_by_hand()
    device.run(IN_DOUBT.replace("WORDS", "Foggy,ok"), answers={"shot": "stop"})

    ran = device.resume(answers={"shot": "skip"})

    assert ran.status == 0
    assert ran.sent() == ["shot", "shot"]
    assert [r.choice for r in ran.records if r.kind == "answered"] == ["stop"]


@pytest.mark.parametrize(
    ("step", "refusal", "consent", "sent"),
    [
        ("{id: sure, confirm: 'Sure?'}", "no", "yes", ["after"]),
        (
            "{id: sure, do: a.pulse, with: {name: x, script: 'Foggy,ok'}}",
            "stop",
            "repeat",
            ["x", "x", "after"],
        ),
    ],
)
def test_who_stopped_a_run_by_an_answer_is_asked_again_when_it_is_resumed(
    own_device, step, refusal, consent, sent
):
    device = own_device()
    stopped = device.run(
        f"steps: [{step}, {{do: a.act, with: {{name: after}}}}]\n", answers={"sure": refusal}
    )
    ran = device.resume(answers={"sure": consent})

    assert stopped.status == 1
    assert ran.status == 0
    assert ran.sent() == sent
    assert [r.choice for r in ran.records if r.kind == "answered"] == [refusal, consent]


def test_what_the_finally_of_a_failed_use_has_moved_is_set_again(own_device):
    device = own_device(**NO_SAFE_STATE)
    device.run(
        "steps: [{do: a.act, with: {name: lower}}, {use: ./other.yaml}]\n",
        beside="""
steps: [{do: a.shoot, with: {name: shot, script: "Broken,ok"}}]
finally: [{do: a.act, with: {name: raise}}]
""",
    )

    ran = device.resume()

    assert ran.status == 0
    assert ran.sent() == ["lower", "shot", "raise", "lower", "shot", "raise"]


def test_a_shot_in_doubt_is_settled_however_many_were_requested_after_it(own_device):
    device = own_device()
    device.run("""
steps:
  - {do: a.shoot, with: {name: before}}
  - steps: [{id: doubt, do: a.shoot, with: {name: doubt, script: "Foggy,ok"}, on_unknown: skip}]
    on_error: continue
  - {do: a.shoot, with: {name: later, script: Broken}, retry: 60}
""")

    ran = device.resume()

    assert ran.sent().count("doubt") == 2
    assert not [r for r in ran.records if r.kind == "asked"]


PROBE_FAILS_ONCE = f"""
from pathlib import Path

from labrun.drivers.driver import ActionFailed
from labrun.drivers.find import find_driver


class Shy(find_driver("{SCRIPTED}", Path())):
    async def last(self, goal):
        if not self.place.config.get("asked"):
            self.place.config["asked"] = True
            raise ActionFailed("Broken", "not now")
        return await super().last(goal)
"""


def test_a_shot_in_doubt_is_asked_about_anew_and_before_anything_else_is_done(own_device, tmp_path):
    (tmp_path / "shy.py").write_text(PROBE_FAILS_ONCE)
    device = own_device(tmp_path / "shy.py:Shy")
    device.run(
        "on_resume: [{do: a.shoot, with: {name: home}}]\n"
        "steps: [{id: shot, do: a.shoot, with: {name: shot, script: 'happened!,ok'}}]\n",
        answers={"shot": "stop"},
    )

    ran = device.resume(answers={"shot": "stop"})

    assert ran.status == 0
    assert ran.sent() == ["shot", "home"]
    assert [r.choice for r in ran.records if r.kind == "answered"] == ["stop"]


def test_a_shot_that_the_device_has_settled_is_not_asked_about_again(own_device):
    device = own_device()
    device.run("""
steps:
  - {do: a.shoot, with: {name: before}}
  - {id: shot, do: a.shoot, with: {name: shot, script: "Foggy,ok"}}
""")

    ran = device.resume()

    assert (ran.status, ran.sent()) == (0, ["before", "shot", "shot"])
    assert [r.action for r in ran.records if r.kind == "goal"].count("last") == 1


UNSURE = f"""
from pathlib import Path

from labrun.drivers.driver import ActionFailed
from labrun.drivers.find import find_driver


class Unsure(find_driver("{SCRIPTED}", Path())):
    async def shoot(self, goal, **params):
        if not self.place.config.get("tried"):
            self.place.config["tried"] = True
            raise ActionFailed("Broken", "something", "unknown")
        return await super().shoot(goal, **params)
"""


def test_a_shot_that_did_not_happen_by_its_contract_needs_no_question_to_the_device(
    own_device, tmp_path
):
    (tmp_path / "unsure.py").write_text(UNSURE)
    device = own_device(tmp_path / "unsure.py:Unsure")
    first = device.run("steps: [{do: a.shoot, with: {name: x}}]\n")

    ran = device.resume()

    assert (first.status, ran.status) == (1, 0)
    assert [r.action for r in ran.records if r.kind == "goal"] == ["shoot", "shoot"]


def test_a_shot_that_a_person_has_denied_is_fired_by_the_next_session(own_device):
    contract = Path(__file__).parents[1] / "scripted_lab" / "scripted.yaml"
    actions = YAML(typ="safe").load(contract.read_text())["actions"]
    del actions["shoot"]["probe"]
    device = own_device(actions=actions)

    def watch(event):
        if (event.event, event.state) == ("question", "open"):
            device.answer("shot", "did_not_happen")

    body = 'steps: [{id: shot, do: a.shoot, with: {name: shot, script: "Foggy,ok"}}]\n'
    first = device.run(body, watch=watch)
    ran = device.resume(watch=watch)

    assert (first.status, ran.status, ran.sent()) == (1, 0, ["shot", "shot"])
    assert [r.choice for r in ran.records if r.kind == "answered"] == ["did_not_happen"]


def test_a_run_whose_folder_was_renamed_keeps_the_ids_of_its_goals(own_device):
    """By these its devices know what they did: under another id a shot in flight was fired again."""
    device = own_device()
    first = device.run('steps: [{do: a.shoot, with: {name: shot, script: "Broken,ok"}}]')
    first_goals = {r.id for r in first.records if r.kind == "goal"}
    (folder,) = device.folder.glob("runs/*")
    folder.rename(folder.with_name("the good one"))

    ran = device.resume()

    goals = [r.id for r in ran.records if r.kind == "goal"]
    assert ran.status == 0
    assert goals[0] in first_goals
    assert {goal.partition("/")[0] for goal in goals} == {folder.name}
