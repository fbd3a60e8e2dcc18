"""The smallest protocol and kill for each gap ever found in the promise, all now closed.

What the random tests find is written down here first, as small as it gets.
"""

import pytest


def do(what, name, *, step=None, **asked):
    return {"do": what, "with": {"name": name, **asked}, **(step or {})}


def shot(name, *, device="a", step=None, **asked):
    return do(f"{device}.shoot", name, step={"id": name, "retry": 3, **(step or {})}, **asked)


def fired(story, name):
    return [line for line in story.happened if (line["action"], line["name"]) == ("shoot", name)]


def test_a_shot_aside_whose_fate_is_unknown_is_probed_before_the_next_shot(laboratory):
    steps = [
        shot("first"),
        shot("aside", word="happened!", tries=1, ms=100, step={"mode": "background"}),
        do("b.look", "meanwhile"),
        shot("next"),
    ]

    assert len(fired(laboratory.live({"steps": steps}), "aside")) == 1


@pytest.mark.parametrize("phase", ["finally", "on_resume"])
def test_an_unknown_shot_is_probed_before_another_phase_fires(laboratory, phase):
    steps = [shot("first"), shot("x", word="happened!", tries=1)]
    story = laboratory.live({"steps": steps, phase: [shot("tidy")]}, [(3, "after", "")])

    assert len(fired(story, "x")) == 1


def test_a_shot_that_was_only_announced_waits_until_the_stopped_device_is_set_again(laboratory):
    steps = [do("a.set", "focus", to=5), shot("x", ms=5)]
    story = laboratory.live({"steps": steps}, [(3, "after", "stop")])

    assert [line["states"]["a"] for line in fired(story, "x")] == [5]


def test_a_fallback_after_a_crash_finds_what_the_failed_steps_had_set(laboratory):
    primary = [do("a.set", "focus", to=5), do("b.look", "bad", word="Broken", tries=99)]
    steps = [{"steps": primary, "fallback": [[do("b.look", "well"), shot("x")]]}]
    story = laboratory.live({"steps": steps}, [(4, "after", "")])

    assert [line["states"]["a"] for line in fired(story, "x")] == [5]


def test_a_retried_group_after_a_crash_counts_its_earlier_turns(laboratory):
    group = [{"set": {"v": "${{ v + 1 }}"}}, do("b.look", "bad", word="Broken", turns=1)]
    loop = {"foreach": {"i": [0]}, "steps": [{"log": "on"}], "collect": {"v": "${{ v }}"}}
    steps = [{"set": {"v": 0}}, {"steps": group, "retry": 2}, do("a.look", "on"), loop]
    story = laboratory.live({"steps": steps}, [(4, "after", "")])

    assert story.tables() == {"key,v,fate": ["0,2,succeeded"]}


def test_a_device_without_safe_state_is_set_again_however_often_the_engine_dies(laboratory):
    steps = [
        do("b.look", "begin"), do("b.set", "focus", to=5), do("a.look", "on"), shot("x", device="b"),
    ]  # fmt: skip
    story = laboratory.live({"steps": steps}, [(5, "after", "restart"), (4, "after", "")])

    assert [line["states"]["b"] for line in fired(story, "x")] == [5]


def test_what_a_finished_iteration_had_set_is_set_again(laboratory):
    loop = {"foreach": {"i": [0, 1]}, "steps": [do("a.set", "focus", to=5)]}
    story = laboratory.live({"steps": [loop, do("b.look", "on"), shot("x")]}, [(4, "after", "")])

    assert [line["states"]["a"] for line in fired(story, "x")] == [5]


def test_a_run_whose_iteration_ended_before_a_cancelled_member_can_be_resumed(laboratory):
    together = [
        do("a.look", "bad", word="Broken", tries=99),
        do("b.shoot", "slow", ms=30, step={"id": "slow"}),
    ]
    loop = {
        "foreach": {"i": [0, 1]}, "keep_going": {"max_failed": 1},
        "steps": [{"parallel": together, "on_failure": "cancel", "when": "${{ i == 0 }}"}],
    }  # fmt: skip
    story = laboratory.live({"steps": [loop, do("a.look", "on")]}, [(6, "after", "")])

    assert story.exits == ["killed", 0]


def test_a_shot_that_was_lost_and_did_not_happen_is_fired_by_the_next_engine(laboratory):
    steps = [shot("first"), shot("x", ms=300, step={"retry": 1})]
    story = laboratory.live({"steps": steps}, [(3, "later", "restart")])

    assert story.exits == ["killed", 0]


def test_a_retry_after_the_server_came_back_finds_what_was_set(laboratory):
    steps = [shot("first"), do("a.set", "focus", to=5), shot("x", word="die-", tries=1)]
    story = laboratory.live({"steps": steps})

    assert [line["states"]["a"] for line in fired(story, "x")] == [5]


def test_a_device_without_safe_state_that_somebody_stopped_is_set_again(laboratory):
    steps = [do("b.set", "focus", to=5), do("a.look", "on"), shot("x", device="b")]
    story = laboratory.live({"steps": steps}, [(3, "after", "stop b")])

    assert [line["states"]["b"] for line in fired(story, "x")] == [5]


def test_a_shot_lost_under_a_living_engine_is_probed_before_on_resume_fires(laboratory):
    steps = [shot("first"), shot("x", word="die+", tries=1)]
    story = laboratory.live({"steps": steps, "on_resume": [shot("tidy")]}, answers={"x": "repeat"})

    assert len(fired(story, "x")) == 1


@pytest.mark.parametrize("record", range(4, 9))
def test_a_probe_of_the_finally_of_who_lost_a_race_is_announced_once(laboratory, record):
    other = {
        "steps": [do("b.look", "long", ms=30)],
        "finally": [shot("tidy", device="b", word="dark", tries=1)],
        "devices": {"b": "bare@1"},
    }
    race = [{"steps": [{"use": other, "id": "loser"}]}, do("a.look", "quick", ms=10)]
    kills = [(record, "after", ""), (2, "after", "")]
    story = laboratory.live({"steps": [shot("first", device="b"), {"any": race}]}, kills)
    goals = [line.id for line in story.records if line.kind == "goal"]

    assert len(goals) == len(set(goals))
    assert len(fired(story, "tidy")) == 1
