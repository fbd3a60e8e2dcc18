"""`repeat` and `while`: the same steps again

`repeat: N` runs its steps N times, `while:` as long as its condition is true, `max` times at most. The
iterations are called 0, 1, 2 and so on. The condition is computed before each iteration.

    - set: {mass: "${{ 0 g }}"}
    - while: ${{ mass < 1 g }}
      max: 20
      steps: [{id: look, do: balance.weigh}, {set: {mass: "${{ steps.look.mass }}"}}]
"""

from .table import table

COUNT = """
steps:
  - set: {{n: 0}}
  - id: turns
    while: ${{{{ n < {until} }}}}
    max: {most}
    steps:
      - {{do: a.act, with: {{name: "a${{{{ n }}}}"}}}}
      - set: {{n: "${{{{ n + 1 }}}}"}}
  - {{do: b.act, with: {{name: "after ${{{{ n }}}}"}}}}
outputs: {{total: "${{{{ steps.turns.total }}}}"}}
"""


# fmt: off
test_turns = table(
    ("repeat_runs_its_steps_so_many_times",
     "`repeat: 3` -> Its steps run three times, one after the other; the result is the counts, as for "
     "`foreach`.", """
steps:
  - {id: turns, repeat: 3, steps: [{do: a.act, with: {name: x}}, {do: b.act, with: {name: y}}]}
outputs: {counts: "${{ steps.turns }}"}
""",
     {"sent": ["x", "y"] * 3,
      "outputs": {"counts": {"total": 3, "succeeded": 3, "failed": 0, "skipped": 0}}}),
    ("repeat_zero_times_is_a_success",
     "`repeat` of a number that turns out to be 0 -> No step runs, and the loop succeeds.", """
steps:
  - {id: one, do: a.act, with: {name: one}}
  - {repeat: "${{ steps.one.n - 1 }}", steps: [{do: a.act, with: {name: never}}]}
""", {"status": 0, "sent": ["one"]}),
    ("repeat_of_no_number_fails",
     "`repeat` of something that turns out not to be a whole number from 0 -> The step fails, and "
     "reports what it got.", """
steps:
  - {id: one, do: a.act, with: {name: one}}
  - {repeat: "${{ steps.one.n - 3 }}", steps: [{do: a.act, with: {name: never}}]}
""", {"status": 1, "sent": ["one"], "reason": "not -2"}),
    ("while_goes_on_as_long_as_its_condition_is_true",
     "`while` -> The condition is computed before each iteration, with the values that `set` gave in the "
     "iterations before.", COUNT.format(until=3, most=10),
     {"sent": ["a0", "a1", "a2", "after 3"], "outputs": {"total": 3}}),
    ("a_condition_that_is_false_at_once",
     "The condition is false from the beginning -> No step runs, and the loop succeeds.",
     COUNT.format(until=0, most=10), {"status": 0, "sent": ["after 0"]}),
    ("a_condition_that_turns_false_with_the_last_turn",
     "The condition turns false after exactly `max` iterations -> The loop succeeds.",
     COUNT.format(until=3, most=3), {"status": 0, "outputs": {"total": 3}}),
    ("a_condition_that_stays_true_fails",
     "The condition is still true after `max` iterations -> The loop fails with the error `MaxReached`; "
     "what was done stays done.", COUNT.format(until=99, most=2),
     {"status": 1, "sent": ["a0", "a1"],
      "reason": "MaxReached: the condition of `while` still holds after 2 turns"}),
    ("a_fallback_takes_max_reached",
     "As before, with a `fallback` -> It runs, and `error.name` is `MaxReached`.", """
steps:
  - while: ${{ 1 < 2 }}
    max: 2
    steps: [{do: a.act, with: {name: x}}]
    fallback: [{do: b.act, with: {name: "${{ error.name }}"}}]
""", {"status": 0, "sent": ["x", "x", "MaxReached"]}),
    ("on_error_continue_takes_max_reached",
     "As before, with `on_error: continue` -> The run continues; the result of the loop is null.", """
steps:
  - {id: turns, while: "${{ 1 < 2 }}", max: 2, on_error: continue, steps: [{do: a.act, with: {name: x}}]}
  - {do: b.act, with: {name: after}}
outputs: {total: "${{ steps.turns.total }}"}
""", {"sent": ["x", "x", "after"], "outputs": {"total": None}}),
    ("retry_of_a_while_begins_anew",
     "`while` with a `retry` -> After a failure it starts again with iteration 0; names keep the values "
     "they have.", """
steps:
  - set: {n: 0}
  - while: ${{ n < 3 }}
    max: 9
    retry: 2
    steps:
      - set: {n: "${{ n + 1 }}"}
      - {do: a.act, with: {name: "a${{ n }}", script: "${{ 'Broken' if n == 2 else 'ok' }}"}}
""", {"status": 0, "sent": ["a1", "a2", "a3"]}),
    ("a_condition_that_cannot_be_computed_fails",
     "The condition cannot be computed -> The loop fails after the iterations already done.", """
steps:
  - set: {n: 1}
  - while: ${{ 1 / n > 0 }}
    max: 9
    steps:
      - {do: a.act, with: {name: x}}
      - set: {n: "${{ n - 1 }}"}
""", {"status": 1, "sent": ["x"], "reason": "zero"}),
)
# fmt: on


def test_keep_going_in_a_while(run):
    """An iteration fails, `keep_going` -> It is a hole; the condition is computed, and the next
    iteration begins."""
    ran = run("""
steps:
  - set: {n: 0}
  - id: turns
    while: ${{ n < 3 }}
    max: 9
    keep_going: {max_failed: 1}
    steps:
      - set: {n: "${{ n + 1 }}"}
      - {do: a.act, with: {name: "a${{ n }}", script: "${{ 'Broken' if n == 2 else 'ok' }}"}}
    collect: {n: "${{ n }}"}
outputs: {failed: "${{ steps.turns.failed }}"}
""")

    assert ran.status == 0
    assert [(row["key"], row["fate"]) for row in ran.rows()] == [
        ("0", "succeeded"), ("1", "failed"), ("2", "succeeded"),
    ]  # fmt: skip
    assert ran.outputs == {"failed": 1}


def test_failed_turns_count_for_max(run):
    """Turns that fail within `keep_going` -> They count for `max`, too."""
    ran = run("""
steps:
  - while: ${{ 1 < 2 }}
    max: 2
    keep_going: {max_failed: 5}
    steps: [{do: a.act, with: {name: x, script: Broken}}]
""")

    assert ran.sent == ["x", "x"]
    assert "MaxReached" in ran.finished.detail


def test_loops_of_all_kinds_nest(run):
    """`while` in `repeat` -> It starts again in each iteration, with its own `max`."""
    ran = run("""
steps:
  - repeat: 2
    steps:
      - set: {n: 0}
      - while: ${{ n < 2 }}
        max: 2
        steps:
          - {do: a.act, with: {name: "a${{ n }}"}}
          - set: {n: "${{ n + 1 }}"}
""")

    assert ran.sent == ["a0", "a1", "a0", "a1"]


def test_background_in_a_while(run):
    """A background action in the steps -> The condition of the next iteration is computed while it
    runs; the iteration after that waits for it."""
    ran = run("""
steps:
  - set: {n: 0}
  - while: ${{ n < 3 }}
    max: 9
    steps:
      - {do: a.act, with: {name: "a${{ n }}"}}
      - {id: aside, do: b.act, with: {name: "b${{ n }}", seconds: 0.2}, mode: background}
      - set: {n: "${{ n + 1 }}"}
    collect: {name: "${{ steps.aside.name }}"}
""")

    assert ran.words.index("a1") < ran.words.index("b0.") < ran.words.index("a2")
    assert [row["name"] for row in ran.rows()] == ["b0", "b1", "b2"]


def test_abort_in_a_while(run):
    """Abort in an iteration -> Its action is cancelled; the condition is not computed again."""
    ran = run(
        """
steps:
  - while: ${{ 1 < 2 }}
    max: 9
    steps: [{id: it, do: a.act, with: {name: x, script: hang}}]
""",
        abort="feedback .* main/0/0/it",
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == ["x"]


def test_a_while_goes_on_after_a_kill(bench):
    """The engine is killed in the third iteration -> Resume skips the first two, with the values
    that they had set, and continues in the third."""
    bench.kill(
        """
steps:
  - set: {n: 0}
  - id: turns
    while: ${{ n < 4 }}
    max: 9
    steps:
      - {do: a.shoot, with: {name: "a${{ n }}"}}
      - set: {n: "${{ n + 1 }}"}
      - {do: b.shoot, with: {name: "b${{ n }}"}}
    collect: {n: "${{ n }}"}
outputs: {total: "${{ steps.turns.total }}"}
""",
        "ended main/turns/2/0",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["a0", "b1", "a1", "b2", "a2", "b3", "a3", "b4"]
    assert [row["n"] for row in ran.rows()] == ["1", "2", "3", "4"]
    assert ran.outputs == {"total": 4}


def test_a_while_killed_between_two_turns(bench):
    """The engine is killed between two iterations -> Finished iterations count for `max` after the
    resume, too."""
    bench.kill(
        """
steps:
  - set: {n: 0}
  - while: ${{ n < 99 }}
    max: 3
    steps:
      - set: {n: "${{ n + 1 }}"}
      - {do: a.shoot, with: {name: "a${{ n }}"}}
""",
        "iteration main/1/1",
    )

    ran = bench.resume()

    assert ran.status == 1
    assert ran.sent == ["a1", "a2", "a3"]
    assert "MaxReached" in ran.finished.detail


def test_repeat_goes_on_after_a_kill(bench):
    """`repeat`, killed in the second iteration -> Resume skips the first and continues in the
    second."""
    bench.kill(
        "steps: [{repeat: 3, steps: [{do: a.shoot, with: {name: x}}, {do: b.shoot, with: {name: y}}]}]\n",
        "ended main/0/1/0",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["x", "y", "x", "y", "x", "y"]


def test_a_while_that_failed_goes_on_when_the_run_is_resumed(bench):
    """A run that ended in the second iteration is resumed -> It continues in that iteration, with
    the values of the first."""
    bench.run("""
steps:
  - set: {n: 0}
  - while: ${{ n < 3 }}
    max: 9
    steps:
      - set: {n: "${{ n + 1 }}"}
      - {do: a.shoot, with: {name: "a${{ n }}", script: "${{ 'Broken,ok' if n == 2 else 'ok' }}"}}
""")

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["a1", "a2", "a2", "a3"]
