"""`parallel`: several at the same time

The members of a set start together. The set ends when all of them have ended, and then the next step
begins. A member is a `do`, or a group `steps`.

    - parallel:
        - {do: gantry.move_to, with: {z: 30 mm}}
        - {do: libs.locate, retry: 3}
"""


def test_members_start_together_and_the_set_ends_with_the_last(run):
    """All members succeed -> They start together; the next step waits for the slowest."""
    ran = run("""
steps:
  - parallel:
      - {do: a.act, with: {name: slow, seconds: 0.3}}
      - {do: b.act, with: {name: quick}}
  - {do: b.act, with: {name: after}}
""")

    assert ran.words.index("quick") < ran.words.index("slow.")
    assert ran.words[-3:] == ["slow.", "after", "after."]


def test_the_result_of_a_set_is_a_list(run):
    """A set with an `id` -> Its result is the list of its members' results, in the order written;
    a member's own `id` names its own result."""
    ran = run("""
steps:
  - id: both
    parallel:
      - {id: first, do: a.act, with: {name: one, seconds: 0.1}}
      - {do: b.act, with: {name: two}}
outputs: {names: "${{ [steps.both[0].name, steps.both[1].name, steps.first.name] }}"}
""")

    assert ran.outputs == {"names": ["one", "two", "one"]}


def test_a_failing_member_lets_the_others_finish(run):
    """A member fails -> The others finish; then the set fails, with the reason of the first that
    failed."""
    ran = run("""
steps:
  - parallel:
      - {do: a.act, with: {name: slow, seconds: 0.2}}
      - {do: b.act, with: {name: bad, script: Broken}}
  - {do: c.act, with: {name: never}}
""")

    assert (ran.status, ran.done) == (1, ["slow"])
    assert "b.act: Broken" in ran.finished.detail


def test_on_failure_cancel_stops_the_others(run):
    """A member fails, `on_failure: cancel` -> The others are cancelled; then the set fails."""
    ran = run("""
steps:
  - on_failure: cancel
    parallel:
      - {do: a.act, with: {name: slow, script: hang}}
      - {do: b.act, with: {name: bad, script: Broken, seconds: 0.2}}
""")

    assert (ran.status, ran.done) == (1, [])
    assert sorted(r.state for r in ran.records if r.kind == "ended") == ["ABORTED", "CANCELED"]


def test_with_cancel_a_member_that_has_succeeded_keeps_its_result(run):
    """As before, and one member had succeeded already -> It keeps its result; that of a cancelled
    one is null."""
    ran = run("""
steps:
  - on_failure: cancel
    on_error: continue
    parallel:
      - {id: good, do: a.act, with: {name: good}}
      - {id: slow, do: b.act, with: {name: slow, script: hang}}
      - {do: c.act, with: {name: bad, script: Broken, seconds: 0.3}}
outputs: {good: "${{ steps.good.name }}", slow: "${{ steps.slow.name }}"}
""")

    assert ran.status == 0
    assert ran.outputs == {"good": "good", "slow": None}


def test_each_member_has_a_ladder_of_its_own(run):
    """A member with a `retry` and a `fallback` -> Its own retries and fallbacks run while the
    others run."""
    ran = run("""
steps:
  - parallel:
      - {do: a.act, with: {name: slow, seconds: 0.4}}
      - {do: b.act, with: {name: bad, script: Broken}, retry: 2, fallback: [{do: c.act, with: {name: other}}]}
""")

    assert ran.status == 0
    assert ran.sent.count("bad") == 2
    assert ran.words.index("other.") < ran.words.index("slow.")


def test_only_the_members_that_failed_are_sent_again(run):
    """A set with `retry` -> Only the members that failed are sent again."""
    ran = run("""
steps:
  - retry: 3
    parallel:
      - {do: a.act, with: {name: good}}
      - {do: b.act, with: {name: bad, script: "Broken,Broken,ok"}}
""")

    assert ran.status == 0
    assert sorted(ran.sent) == ["bad", "bad", "bad", "good"]


def test_a_set_s_fallback_stands_in_for_the_members_that_failed(run):
    """A set with a `fallback`, and a member fails -> When all have ended the fallback runs, once.
    In the list, its result replaces that of each member that failed."""
    ran = run("""
steps:
  - id: all
    parallel:
      - {do: a.act, with: {name: bad, script: Broken}}
      - {id: good, do: b.act, with: {name: good, seconds: 0.1}}
    fallback: [{do: c.act, with: {name: other}}]
outputs: {all: "${{ [steps.all[0].name, steps.all[1].name, steps.good.name] }}"}
""")

    assert ran.status == 0
    assert ran.words[-3:] == ["good.", "other", "other."]
    assert ran.outputs == {"all": ["other", "good", "good"]}


ASKED = """
steps:
  - id: both
    parallel:
      - {id: good, do: a.shoot, with: {name: good}}
      - {id: bad, do: b.act, with: {name: bad, script: "Broken,ok"}}
    fallback: [{id: how, ask: "Again?", choices: [repeat, stop]}]
  - {id: after, do: c.act, with: {name: after, seconds: 0.1}}
outputs: {both: "${{ [steps.both[0].name, steps.both[1].name] }}"}
"""


def test_a_person_s_repeat_repeats_only_what_failed(run):
    """A person answers `repeat` in the fallback of a set -> Only the members that failed are sent
    again."""
    ran = run(ASKED, answers={"how": "repeat"})

    assert ran.status == 0
    assert sorted(ran.sent[:2]) == ["bad", "good"]
    assert ran.sent[2:] == ["bad", "after"]
    assert ran.outputs == {"both": ["good", "bad"]}


def test_after_a_person_s_repeat_and_a_kill(bench):
    """As before, and the engine is killed later -> What succeeded the first time is not sent
    again."""
    bench.kill(ASKED, "feedback main/after", answers={"how": "repeat"})

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent.count("good") == 1
    assert ran.outputs == {"both": ["good", "bad"]}


def test_a_group_may_be_a_member(run):
    """A member is a group -> Its steps run one after the other, beside the other members."""
    ran = run("""
steps:
  - parallel:
      - steps: [{do: a.act, with: {name: one, seconds: 0.2}}, {do: b.act, with: {name: two}}]
      - {do: c.act, with: {name: beside, seconds: 0.1}}
""")

    assert ran.words.index("beside.") < ran.words.index("two")
    assert ran.status == 0


def test_a_stop_by_a_person_outweighs_another_failure(run):
    """One member fails and in another a person answers `stop` -> The run stops, in spite of
    `keep_going`."""
    ran = run(
        """
steps:
  - foreach: {i: [1, 2]}
    keep_going: {max_failed: 2}
    steps:
      - parallel:
          - {do: a.act, with: {name: "bad${{ i }}", script: Broken}}
          - id: it
            do: b.act
            with: {name: "x${{ i }}", script: Broken, seconds: 0.2}
            fallback: [{ask: "?", choices: [repeat, skip, stop]}]
""",
        answers={"it": "stop"},
    )

    assert ran.finished.fate == "aborted"
    assert sorted(ran.sent) == ["bad1", "x1"]


def test_abort_in_a_set_cancels_every_member(run):
    """Abort -> Every member that runs is cancelled."""
    ran = run(
        """
steps:
  - parallel:
      - {id: one, do: a.act, with: {name: one, script: hang}}
      - {id: two, do: b.act, with: {name: two, script: hang}}
""",
        abort="feedback .* main/0/two",
    )

    assert ran.finished.fate == "aborted"
    assert [r.state for r in ran.records if r.kind == "ended"] == ["CANCELED", "CANCELED"]


def test_after_a_kill_only_the_unfinished_member_goes_on(bench):
    """The engine is killed when one member had ended -> Resume does not send a finished `once`
    member again."""
    bench.kill(
        """
steps:
  - parallel:
      - {id: quick, do: a.shoot, with: {name: quick}}
      - {id: slow, do: b.shoot, with: {name: slow, seconds: 0.4}}
  - {do: c.act, with: {name: after}}
""",
        "ended main/0/quick",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert sorted(ran.sent) == ["after", "quick", "slow"]
    assert ran.words[-3:] == ["slow.", "after", "after."]
