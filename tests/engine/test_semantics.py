"""What each construct sends, in which order and how often, on the real engine over the real wire."""

import pytest


def test_steps_run_one_after_the_other(run):
    ran = run("""
steps:
  - {do: a.act, with: {name: one}}
  - {do: b.act, with: {name: two}}
  - {do: a.act, with: {name: three}}
""")

    assert ran.status == 0
    assert ran.sent() == ["one", "two", "three"]


def test_a_set_starts_its_members_together_and_ends_when_all_have_ended(run):
    ran = run("""
steps:
  - parallel:
      - {do: a.act, with: {name: slow, seconds: 0.3}}
      - {do: b.act, with: {name: quick}}
  - {do: b.act, with: {name: after}}
""")

    words = [(c["name"], c["word"]) for c in ran.calls]
    assert {words[0], words[1]} == {("slow", "ok"), ("quick", "ok")}
    assert words.index(("slow", "done")) < words.index(("after", "ok"))


def test_a_failing_member_lets_the_others_finish(run):
    ran = run("""
steps:
  - parallel:
      - {do: a.act, with: {name: slow, seconds: 0.3}}
      - {do: b.act, with: {name: bad, script: Broken}}
""")

    assert ran.status == 1
    assert ("slow", "done") in [(c["name"], c["word"]) for c in ran.calls]
    assert ran.finished.fate == "failed"
    assert "Broken" in ran.finished.reason


def test_on_failure_cancel_stops_the_others(run):
    ran = run("""
steps:
  - on_failure: cancel
    parallel:
      - {do: a.act, with: {name: slow, seconds: 20}}
      - {do: b.act, with: {name: bad, script: Broken}}
""")

    assert ran.status == 1
    assert ("slow", "done") not in [(c["name"], c["word"]) for c in ran.calls]


def test_retry_counts_attempts_in_all(run):
    ran = run("steps: [{do: a.act, with: {name: x, script: 'Broken,Broken,ok'}, retry: 3}]\n")

    assert ran.status == 0
    assert ran.sent() == ["x", "x", "x"]


def test_retry_gives_up_after_its_attempts(run):
    ran = run("steps: [{do: a.act, with: {name: x, script: Broken}, retry: 2}]\n")

    assert ran.status == 1
    assert ran.sent() == ["x", "x"]


def test_retry_on_names_only_those_errors(run):
    ran = run("""
steps: [{do: a.act, with: {name: x, script: 'Half,ok'}, retry: {attempts: 3, on: [Broken]}}]
""")

    assert ran.status == 1
    assert ran.sent() == ["x"]


def test_only_the_members_that_failed_are_sent_again_in_a_retried_set(run):
    ran = run("""
steps:
  - retry: 3
    parallel:
      - {do: a.act, with: {name: good}}
      - {do: b.act, with: {name: bad, script: 'Broken,Broken,ok'}}
""")

    assert ran.status == 0
    assert sorted(ran.sent()) == ["bad", "bad", "bad", "good"]


def test_a_retried_group_starts_anew_and_no_goal_id_comes_twice(run):
    ran = run("""
steps:
  - retry: 2
    steps:
      - {do: a.act, with: {name: first}}
      - {do: a.act, with: {name: second, script: 'Broken,ok'}}
""")

    goals = [c["goal"] for c in ran.calls if c["word"] != "done"]
    assert ran.status == 0
    assert ran.sent() == ["first", "second", "first", "second"]
    assert len(set(goals)) == 4


def test_a_once_action_that_did_happen_is_not_sent_again_by_retry(run):
    ran = run("steps: [{do: a.shoot, with: {name: x, script: 'Half,ok'}, retry: 3}]\n")

    assert ran.status == 1
    assert ran.sent() == ["x"]


def test_a_once_action_that_did_not_happen_is_sent_again(run):
    ran = run("steps: [{do: a.shoot, with: {name: x, script: 'Broken,ok'}, retry: 3}]\n")

    assert ran.status == 0
    assert ran.sent() == ["x", "x"]


def test_an_unknown_once_action_that_the_probe_saw_is_taken_as_done(run):
    ran = run("""
steps:
  - {id: shot, do: a.shoot, with: {name: x, script: 'happened!'}, retry: 3}
  - {do: a.act, with: {name: after}}
outputs: {n: "${{ steps.shot.n }}"}
""")

    assert ran.status == 0
    assert ran.sent() == ["x", "after"]
    assert ran.finished.outputs == {"n": 1}


def test_an_unknown_once_action_that_the_probe_did_not_see_is_tried_again(run):
    ran = run("""
steps:
  - {do: a.shoot, with: {name: before}}
  - {do: a.shoot, with: {name: x, script: 'Foggy,ok'}, retry: 2}
""")

    assert ran.status == 0
    assert ran.sent() == ["before", "x", "x"]


@pytest.mark.parametrize(("policy", "sent"), [("skip", ["x"]), ("repeat", ["x", "x"])])
def test_on_unknown_says_what_happens_without_asking(run, policy, sent):
    ran = run(f"""
steps:
  - foreach: {{i: [1]}}
    keep_going: {{max_failed: 1}}
    steps:
      - {{do: a.shoot, with: {{name: x, script: 'Foggy,ok'}}, on_unknown: {policy}}}
""")

    assert ran.status == 0
    assert ran.sent() == sent


def test_fallback_is_tried_in_order_and_gives_the_step_its_result(run):
    ran = run("""
steps:
  - id: it
    do: a.act
    with: {name: x, script: Broken}
    fallback:
      - {do: a.act, with: {name: y, script: Broken}}
      - steps:
          - {do: b.act, with: {name: z1}}
          - {do: b.act, with: {name: z2, x: 2}}
  - log: "by ${{ steps.it.name }} at ${{ steps.it.x }}"
outputs: {by: "${{ steps.it.name }}"}
""")

    assert ran.status == 0
    assert ran.sent() == ["x", "y", "z1", "z2"]
    assert ran.finished.outputs == {"by": "z2"}


def test_a_question_in_a_fallback_repeats_the_step(run):
    ran = run(
        """
steps:
  - id: it
    do: a.act
    with: {name: x, script: 'Broken,ok'}
    fallback: [{ask: "${{ error.name }}?", choices: [repeat, skip, stop]}]
""",
        answers={"it": "repeat"},
    )

    assert ran.status == 0
    assert ran.sent() == ["x", "x"]


def test_skip_ends_the_iteration_as_a_hole(run):
    ran = run(
        """
steps:
  - id: all
    foreach: {i: [1, 2]}
    steps:
      - id: it
        do: a.act
        with: {name: "x${{ i }}", script: "${{ 'Broken' if i == 1 else 'ok' }}"}
        fallback: [{ask: "?", choices: [repeat, skip, stop]}]
      - {do: b.act, with: {name: "y${{ i }}"}}
    collect: {i: "${{ i }}", n: "${{ steps.it.n }}"}
""",
        answers={"it": "skip"},
    )

    assert ran.status == 0
    assert ran.sent() == ["x1", "x2", "y2"]
    assert [(row["i"], row["n"], row["fate"]) for row in ran.rows()] == [
        ("1", "", "failed"),
        ("2", "1", "succeeded"),
    ]
    assert ran.finished.holes == 1


def test_on_error_continue_goes_on_with_a_null_result(run):
    ran = run("""
steps:
  - {id: it, do: a.act, with: {name: x, script: Broken}, on_error: continue}
  - {do: a.act, with: {name: after}}
outputs: {n: "${{ steps.it.n }}"}
""")

    assert ran.status == 0
    assert ran.sent() == ["x", "after"]
    assert ran.finished.outputs == {"n": None}


def test_keep_going_leaves_holes_and_stops_at_one_too_many(run):
    body = """
steps:
  - foreach: {{i: "${{{{ range(4) }}}}"}}
    keep_going: {{max_failed: {limit}}}
    steps:
      - {{do: a.act, with: {{name: "x${{{{ i }}}}", script: "${{{{ 'ok' if i == 3 else 'Broken' }}}}"}}}}
"""
    enough = run(body.format(limit=3))

    assert enough.status == 0
    assert enough.finished.holes == 3
    assert enough.sent() == ["x0", "x1", "x2", "x3"]


def test_one_failure_too_many_stops_the_loop(run):
    ran = run("""
steps:
  - foreach: {i: "${{ range(4) }}"}
    keep_going: {max_failed: 1}
    steps:
      - {do: a.act, with: {name: "x${{ i }}", script: Broken}}
""")

    assert ran.status == 1
    assert ran.sent() == ["x0", "x1"]


def test_when_false_skips_the_step_and_its_result_is_null(run):
    ran = run("""
steps:
  - {id: it, when: "${{ 1 > 2 }}", do: a.act, with: {name: never}}
  - {do: a.act, with: {name: after}}
outputs: {n: "${{ steps.it.n }}"}
""")

    assert ran.sent() == ["after"]
    assert ran.finished.outputs == {"n": None}


def test_a_timeout_cancels_the_action_and_goes_up_the_ladder(run):
    ran = run("""
steps:
  - {do: a.act, with: {name: x, seconds: 30}, timeout: 0.3 s, fallback: [{do: b.act, with: {name: y}}]}
""")

    assert ran.status == 0
    assert ran.sent() == ["x", "y"]


def test_a_group_s_timeout_counts_in_total(run):
    ran = run("""
steps:
  - timeout: 0.5 s
    steps:
      - {do: a.act, with: {name: x}}
      - {do: a.act, with: {name: y, seconds: 30}}
""")

    assert ran.status == 1
    assert "Timeout" in ran.finished.reason


def test_background_actions_overlap_with_the_next_iteration_only(run):
    ran = run("""
steps:
  - foreach: {i: "${{ range(3) }}"}
    steps:
      - {do: a.act, with: {name: "a${{ i }}"}}
      - {id: later, do: b.act, with: {name: "b${{ i }}", seconds: 0.2}, mode: background}
    collect: {n: "${{ steps.later.name }}"}
""")

    words = [(c["name"], c["word"]) for c in ran.calls]
    assert words.index(("a1", "ok")) < words.index(("b0", "done"))
    assert words.index(("b0", "done")) < words.index(("a2", "ok"))
    assert [row["n"] for row in ran.rows()] == ["b0", "b1", "b2"]


def test_a_background_action_outside_a_loop_is_joined_at_the_end_of_its_steps(run):
    ran = run("""
steps:
  - steps:
      - {do: b.act, with: {name: aside, seconds: 0.3}, mode: background}
      - {do: a.act, with: {name: inside}}
  - {do: a.act, with: {name: after}}
""")

    words = [(c["name"], c["word"]) for c in ran.calls]
    assert words.index(("inside", "done")) < words.index(("aside", "done"))
    assert words.index(("aside", "done")) < words.index(("after", "ok"))


def test_finally_runs_after_a_failure_and_devices_are_made_safe(run):
    ran = run("""
steps: [{do: a.act, with: {name: x, script: Broken}}]
finally: [{do: b.act, with: {name: last}}]
""")

    assert ran.status == 1
    assert ran.sent() == ["x", "last"]
    assert [(r.device, r.confirmed) for r in ran.records if r.kind == "safe"] == [
        ("a", True),
        ("b", True),
    ]


def test_a_confirm_answered_no_ends_the_run_as_aborted_and_finally_runs(run):
    ran = run(
        """
steps:
  - {id: sure, confirm: "Sure?"}
  - {do: a.act, with: {name: never}}
finally: [{do: b.act, with: {name: last}}]
""",
        answers={"sure": "no"},
    )

    assert ran.status == 1
    assert ran.finished.fate == "aborted"
    assert ran.sent() == ["last"]


def test_set_names_are_seen_by_later_steps_and_iterations(run):
    ran = run("""
steps:
  - set: {total: 0}
  - foreach: {i: [1, 2, 3]}
    steps:
      - set: {total: "${{ total + i }}"}
  - {do: a.act, with: {name: "sum ${{ total }}"}}
""")

    assert ran.sent() == ["sum 6"]


def test_require_and_fail_end_the_run_with_their_words(run):
    ran = run("steps: [{set: {x: 1}}, {require: '${{ x > 1 }}'}]\n")

    assert ran.status == 1
    assert "x > 1 is not true" in ran.finished.reason


def test_loops_nest_and_their_counts_are_results(run):
    ran = run("""
steps:
  - id: outer
    foreach: {i: [1, 2]}
    steps:
      - id: inner
        foreach: {j: [1, 2, 3]}
        steps: [{do: a.act, with: {name: "${{ i }}${{ j }}"}}]
    collect: {done: "${{ steps.inner.succeeded }}"}
outputs: {all: "${{ steps.outer.total }}"}
""")

    assert ran.sent() == ["11", "12", "13", "21", "22", "23"]
    assert [row["done"] for row in ran.rows()] == ["3", "3"]
    assert ran.finished.outputs == {"all": 2}


def test_keys_that_come_twice_fail_before_anything_is_sent(run):
    ran = run("""
steps:
  - {id: one, do: a.act, with: {name: one}}
  - foreach: {i: [1, 2, "${{ steps.one.n }}"]}
    key: k${{ i }}
    steps: [{do: a.act, with: {name: x}}]
""")

    assert ran.status == 1
    assert "comes twice" in ran.finished.reason
    assert ran.sent() == ["one"]


def test_units_are_converted_on_the_way_to_the_device_and_back(run):
    ran = run("""
steps:
  - {id: it, do: a.act, with: {name: x, x: 500 um}}
  - {do: a.act, with: {name: y, x: "${{ steps.it.x * 2 }}"}}
  - log: "at ${{ steps.it.x }}"
""")

    goals = [r for r in ran.records if r.kind == "goal"]
    assert [g.params["x"] for g in goals] == [0.5, 1.0]
    assert [r.message for r in ran.records if r.kind == "step"] == ["at 0.5 mm"]


def test_an_error_that_the_contract_does_not_know_is_named_as_such(run):
    ran = run("steps: [{do: a.act, with: {name: x, script: Surprise}}]\n")

    assert ran.status == 1
    assert "Surprise" in ran.finished.reason
    assert "does not declare" in ran.finished.reason
