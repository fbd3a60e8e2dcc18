"""`any`: the first success wins

The members of the set start together. The first that succeeds is the winner; the others are cancelled.

    - any:
        - {do: libs.locate, retry: 3}
        - {do: camera.capture, with: {image: bench.png}}
"""

from labrun.engine.dispatch import dispatcher

from .table import table

RACE = """
steps:
  - id: race
    any:
      - {id: left, do: a.act, with: {name: left, script: %s}}
      - {id: right, do: b.act, with: {name: right, script: %s, seconds: 0.1}}
  - {do: c.act, with: {name: "after ${{ steps.race.name }}"}}
outputs: {left: "${{ steps.left }}", right: "${{ steps.right.name }}", race: "${{ steps.race.name }}"}
"""


# fmt: off
test_the_winner = table(
    ("the_first_member_that_succeeds_wins",
     "A member succeeds while another runs -> It wins, wherever it is in the list; the other is "
     "cancelled.", RACE % ("hang", "ok"),
     {"status": 0, "words": ["left", "right", "right.", "after right", "after right."]}),
    ("the_result_is_the_winner_s",
     "As before -> The result of the set is the winner's; that of a loser is null.", RACE % ("hang", "ok"),
     {"outputs": {"left": None, "right": "right", "race": "right"}}),
    ("of_two_in_the_same_moment_the_first_written_wins",
     "Two members succeed at the same moment -> The one written first wins.", """
steps:
  - id: race
    any:
      - {id: left, steps: [{set: {x: 1}}]}
      - {id: right, steps: [{set: {x: 2}}]}
outputs: {x: "${{ x }}"}
""", {"outputs": {"x": 1}}),
)
# fmt: on


def test_a_member_that_fails_leaves_the_race_to_the_others(run):
    """A member fails -> The others continue; the set succeeds if one of them does."""
    ran = run(RACE % ("Broken", "ok"))

    assert ran.status == 0
    assert ran.outputs["race"] == "right"


def test_when_all_fail_the_set_fails(run):
    """Every member fails -> The set fails, with the reason of the last one that failed."""
    ran = run(RACE % ("Broken", "Half"))

    assert ran.status == 1
    assert ran.sent == ["left", "right"]
    assert "b.act: Half" in ran.finished.detail


def test_a_member_goes_up_its_own_ladder(run):
    """A member has a `retry` or a `fallback` -> It tries again while the others run, and may still
    win."""
    ran = run("""
steps:
  - id: race
    any:
      - do: a.act
        with: {name: left, script: Broken}
        retry: 2
        fallback: [{do: a.act, with: {name: other}}]
      - {do: b.act, with: {name: right, script: hang}}
outputs: {race: "${{ steps.race.name }}"}
""")

    assert [name for name in ran.sent if name != "right"] == ["left", "left", "other"]
    assert ran.outputs == {"race": "other"}


def test_the_retry_of_the_set_is_its_members(run):
    """The set has a `retry` -> Each member that fails is tried again while the others run."""
    ran = run("""
steps:
  - retry: 3
    any:
      - {do: a.act, with: {name: left, script: Broken}}
      - {do: b.act, with: {name: right, script: "Broken,Broken,ok", seconds: 0.05}}
""")

    assert ran.status == 0
    assert (ran.sent.count("left"), ran.sent.count("right")) == (3, 3)


def test_the_fallback_of_the_set_comes_when_all_have_failed(run):
    """The set has a `fallback` -> It is tried when every member has failed; its result is then that
    of the set."""
    ran = run("""
steps:
  - id: race
    any:
      - {do: a.act, with: {name: left, script: Broken}}
      - {do: b.act, with: {name: right, script: Broken}}
    fallback: [{do: c.act, with: {name: other}}]
outputs: {race: "${{ steps.race.name }}"}
""")

    assert sorted(ran.sent) == ["left", "other", "right"]
    assert ran.outputs == {"race": "other"}


def test_a_loser_that_cannot_be_cancelled_is_awaited(run):
    """A loser cannot be cancelled -> It ends by itself, and nothing new is sent until it has; its
    success is ignored."""
    ran = run("""
steps:
  - id: race
    any:
      - {id: left, do: a.shoot, with: {name: left, seconds: 0.4}}
      - {do: b.act, with: {name: right, seconds: 0.1}}
  - {do: b.act, with: {name: after}}
outputs: {left: "${{ steps.left }}"}
""")

    assert ran.words == ["left", "right", "right.", "left.", "after", "after."]
    assert ran.outputs == {"left": None}


def test_a_loser_that_does_not_end_holds_its_device(run, monkeypatch):
    """A loser does not end within 10 s of its cancel -> The run continues without it; requests to
    its device fail with `Busy` until it ends."""
    monkeypatch.setattr(dispatcher, "CANCEL_GRACE_S", 0.2)
    monkeypatch.setattr(dispatcher, "OWN_S", -2.8)  # beside the contract's own 3 s
    ran = run("""
steps:
  - any:
      - {do: a.shoot, with: {name: left, seconds: 1.5}}
      - {do: b.act, with: {name: right, seconds: 0.1}}
  - {do: b.act, with: {name: after}}
  - {do: a.act, with: {name: asked}, retry: {attempts: 30, wait: 0.2 s, on: [Busy]}}
""")

    assert ran.status == 0
    assert ran.words == [
        "left", "right", "right.", "after", "after.", "left.", "asked", "asked.",
    ]  # fmt: skip
    assert "a is still busy with a.shoot" in ran.said[0]


# fmt: off
test_members = table(
    ("a_group_that_loses_is_cancelled_as_a_whole",
     "A loser is a group of steps -> Its running action is cancelled, and its later steps are never "
     "sent.", """
steps:
  - any:
      - steps: [{do: a.act, with: {name: one, script: hang}}, {do: a.act, with: {name: two}}]
      - {do: b.act, with: {name: right, seconds: 0.1}}
  - {do: a.act, with: {name: after}}
""", {"sent": ["one", "right", "after"]}),
    ("a_member_whose_when_is_false_does_not_take_part",
     "A member's `when` is false -> It does not take part: a skipped step has not succeeded.", """
steps:
  - set: {cold: false}
  - id: race
    any:
      - {do: a.act, when: "${{ cold }}", with: {name: left}}
      - {do: b.act, with: {name: right, seconds: 0.05}}
outputs: {race: "${{ steps.race.name }}"}
""", {"sent": ["right"], "outputs": {"race": "right"}}),
    ("when_nobody_is_left_the_set_fails", "One member is skipped and all others fail -> The set fails.", """
steps:
  - set: {cold: false}
  - any:
      - {do: a.act, with: {name: left, script: Broken}}
      - {do: b.act, when: "${{ cold }}", with: {name: right}}
""", {"status": 1, "sent": ["left"], "reason": "Broken"}),
    ("when_all_are_skipped",
     "Every member is skipped -> Nothing is sent, and the set succeeds; its result is null.", """
steps:
  - set: {cold: false}
  - id: race
    retry: 2
    any:
      - {do: a.act, when: "${{ cold }}", with: {name: left}}
      - {do: b.act, when: "${{ cold }}", with: {name: right}}
outputs: {race: "${{ steps.race }}"}
""", {"status": 0, "sent": [], "outputs": {"race": None}}),
)
# fmt: on


def test_nobody_is_asked_about_a_loser(bench):
    """A `once` loser ends, and it is unknown whether it happened -> Nobody is asked, not even after
    a kill: the race is decided."""
    bench.kill(
        """
steps:
  - any:
      - {do: a.pulse, with: {name: left, script: Foggy, seconds: 0.3}}
      - {do: b.act, with: {name: right, seconds: 0.1}}
  - {id: later, do: c.act, with: {name: later, seconds: 0.2}}
""",
        "feedback main/later",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent.count("left") == 1
    assert [r for r in ran.records if r.kind == "asked"] == []


def test_a_stop_by_a_person_ends_the_race(run):
    """A person answers `stop` in a member's fallback -> The set ends at once, and the run with
    it."""
    ran = run(
        """
steps:
  - any:
      - id: left
        do: a.act
        with: {name: left, script: Broken, seconds: 0.1}
        fallback: [{ask: "?", choices: [repeat, stop]}]
      - {do: b.act, with: {name: right, script: hang}}
""",
        answers={"left": "stop"},
    )

    assert ran.finished.fate == "aborted"
    assert ran.done == []


def test_abort_in_a_race_cancels_every_member(run):
    """Abort -> Every member is cancelled; nobody wins."""
    ran = run(RACE % ("hang", "hang"), abort="feedback .* main/race/left")

    assert ran.finished.fate == "aborted"
    assert ran.done == []


def test_a_race_goes_on_after_a_kill(bench):
    """The engine is killed before the race is decided -> Resume continues with every member that
    has not failed."""
    bench.kill(
        """
steps:
  - id: race
    any:
      - {id: left, do: a.shoot, with: {name: left, script: Broken}}
      - {id: right, do: b.shoot, with: {name: right, seconds: 0.5}}
outputs: {race: "${{ steps.race.name }}"}
""",
        "ended main/race/left",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["left", "right"]
    assert ran.outputs == {"race": "right"}


def test_a_decided_race_stays_decided_after_a_kill(bench):
    """The engine is killed after the race was decided -> The winner stays the winner; losers are
    not sent again."""
    bench.kill(
        """
steps:
  - id: race
    any:
      - {id: left, do: a.act, with: {name: left, script: "hang,ok"}}
      - {id: right, do: b.shoot, with: {name: right, seconds: 0.1}}
  - {id: later, do: c.act, with: {name: later, seconds: 0.3}}
outputs: {race: "${{ steps.race.name }}"}
""",
        "feedback main/later",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert [name for name in ran.sent if name != "later"] == ["left", "right"]
    assert ran.outputs == {"race": "right"}


def test_a_race_in_a_retried_group_is_run_anew(run):
    """The set is in a group that is retried -> The race is run again, and another may win."""
    ran = run("""
steps:
  - retry: 2
    steps:
      - id: race
        any:
          - {do: a.act, with: {name: left, script: "Broken,ok"}}
          - {do: b.act, with: {name: right, script: "ok,hang", seconds: 0.05}}
      - {do: c.act, with: {name: check, script: "Broken,ok"}}
outputs: {race: "${{ steps.race.name }}"}
""")

    assert ran.status == 0
    assert ran.outputs == {"race": "left"}
