"""`when`, `on_error` and `keep_going`

`when: EXPR` decides whether a step runs at all. `on_error` decides what happens when its retries
and fallbacks have not helped. `keep_going` lets a loop continue after a limited number of
failed iterations.

    - foreach: {i: "${{ range(100) }}"}
      keep_going: {max_failed: 5}
      steps: [{do: libs.locate, when: "${{ i % 10 == 0 }}", on_error: continue}]
"""

from .table import table

LOOP = """
steps:
  - id: all
    foreach: {{i: "${{{{ range(4) }}}}"}}
    keep_going: {{max_failed: {most}}}
    steps:
      - id: x
        do: a.act
        with: {{name: "x${{{{ i }}}}", script: "${{{{ 'ok' if i == 3 else 'Broken' }}}}"}}
      - {{do: b.act, with: {{name: "y${{{{ i }}}}"}}}}
    collect: {{i: "${{{{ i }}}}", n: "${{{{ steps.x.n }}}}"}}
"""


# fmt: off
test_rules = table(
    ("when_is_true", "`when` is true -> The step runs.",
     "steps: [{set: {n: 1}}, {when: '${{ n == 1 }}', do: a.act, with: {name: x}}]\n", {"sent": ["x"]}),
    ("when_is_false",
     "`when` is false, or null -> The step is skipped: nothing is sent, it counts as succeeded, its "
     "result is null.", """
steps:
  - {id: it, when: "${{ 1 > 2 }}", do: a.act, with: {name: never}}
  - {when: "${{ steps.it.n > 0 }}", do: a.act, with: {name: never}}
  - {do: a.act, with: {name: after}}
outputs: {n: "${{ steps.it.n }}"}
""", {"status": 0, "sent": ["after"], "outputs": {"n": None}}),
    ("when_is_computed_once",
     "`when` on a step with a `retry` -> It is computed once, before the first attempt.", """
steps:
  - set: {n: 1}
  - when: ${{ n == 1 }}
    retry: 2
    steps:
      - set: {n: 2}
      - {do: a.act, with: {name: x, script: "Broken,ok"}}
""", {"status": 0, "sent": ["x", "x"]}),
    ("when_of_a_loop", "`when` on a loop or a group -> It is computed once, for the whole of it.", """
steps:
  - set: {n: 1}
  - when: ${{ n == 1 }}
    repeat: 2
    steps:
      - set: {n: 2}
      - {do: a.act, with: {name: x}}
""", {"sent": ["x", "x"]}),
    ("on_error_stop",
     "A step fails and has no other setting -> Its failure goes up: to the group, the set or the loop "
     "around it, and in the end to the run.", """
steps:
  - steps: [{do: a.act, with: {name: x, script: Broken}, on_error: stop}]
    fallback: [{do: b.act, with: {name: y}}]
""", {"status": 0, "sent": ["x", "y"]}),
    ("on_error_continue",
     "A step fails, `on_error: continue` -> The next step starts; the result of the failed one is null.",
     """
steps:
  - {id: it, do: a.act, with: {name: x, script: Broken}, on_error: continue}
  - {do: a.act, with: {name: after}}
outputs: {n: "${{ steps.it.n }}"}
""", {"status": 0, "sent": ["x", "after"], "outputs": {"n": None}}),
    ("on_error_comes_after_retry_and_fallback",
     "As before, with a `retry` and a `fallback` -> They come first.", """
steps:
  - do: a.act
    with: {name: x, script: Broken}
    retry: 2
    fallback: [{do: b.act, with: {name: y, script: Broken}}]
    on_error: continue
  - {do: c.act, with: {name: after}}
""", {"status": 0, "sent": ["x", "x", "y", "after"]}),
    ("on_error_pause",
     "A step fails, `on_error: pause` -> The run is paused; `labrun continue` tries the step again, with "
     "all its attempts. What had succeeded before is not done again.", """
steps:
  - {do: a.shoot, with: {name: shot}}
  - {id: it, do: a.act, with: {name: x, script: "Broken,ok"}, on_error: pause}
  - {do: b.act, with: {name: after}}
""", {"status": 0, "sent": ["shot", "x", "x", "after"]}, {"go_on": "control pause"}),
    ("keep_going_leaves_holes",
     "Iterations fail, no more than `max_failed` -> Each is a hole: its later steps are not sent, the "
     "next iteration begins, and the loop succeeds. The run reports how many holes it has.",
     LOOP.format(most=3), {"status": 0, "sent": ["x0", "x1", "x2", "x3", "y3"], "holes": 3}),
    ("one_failure_too_many_ends_the_loop",
     "One more fails -> The loop fails there; that iteration is not a hole, and stays unfinished.",
     LOOP.format(most=1), {"status": 1, "sent": ["x0", "x1"], "holes": 1}),
    ("keep_going_whatever_fails",
     "`keep_going: true` -> Any number of iterations may fail.",
     LOOP.format(most=0).replace("{max_failed: 0}", "true"),
     {"status": 0, "sent": ["x0", "x1", "x2", "x3", "y3"], "holes": 3}),
    ("too_many_in_a_row",
     "`in_a_row: 2`, and a third fails directly after two others -> The loop fails there. A success in "
     "between starts the count anew.", """
steps:
  - foreach: {i: "${{ range(8) }}"}
    keep_going: {max_failed: 7, in_a_row: 2}
    steps: [{do: a.act, with: {name: "x${{ i }}", script: "${{ 'ok' if i == 1 else 'Broken' }}"}}]
""", {"status": 1, "sent": ["x0", "x1", "x2", "x3", "x4"], "holes": 3}),
    ("nothing_succeeded",
     "Every iteration fails, within `keep_going` -> The loop fails when it is through, and with it the run.",
     """
steps:
  - {repeat: 3, keep_going: true, steps: [{do: a.shoot, with: {name: x, script: Broken}}]}
  - {do: a.act, with: {name: after}}
""", {"status": 1, "sent": ["x", "x", "x"], "holes": 3, "reason": "none of its 3 iterations succeeded"}),
    ("no_iterations",
     "A loop has no iterations -> It succeeds.",
     "steps: [{repeat: 0, keep_going: true, steps: [{log: x}]}]\n", {"status": 0}),
)
# fmt: on


def test_a_hole_has_a_row(run):
    """A hole, with `collect` -> It has a row, with null where nothing is known, and the fate
    `failed`."""
    ran = run(LOOP.format(most=3))

    assert [(row["i"], row["n"], row["fate"]) for row in ran.rows()] == [
        ("0", "", "failed"), ("1", "", "failed"), ("2", "", "failed"), ("3", "1", "succeeded"),
    ]  # fmt: skip


def test_in_nested_loops_each_counts_for_itself(run):
    """`keep_going` in an inner loop -> Its holes are its own: for the outer loop that iteration has
    succeeded."""
    ran = run("""
steps:
  - id: outer
    foreach: {i: [1, 2]}
    steps:
      - repeat: 2
        keep_going: {max_failed: 1}
        steps: [{do: a.act, with: {name: "x${{ i }}", script: "Broken,ok"}}]
outputs: {failed: "${{ steps.outer.failed }}"}
""")

    assert ran.status == 0
    assert ran.outputs == {"failed": 0}
    assert ran.finished.holes == 2


def test_holes_stay_holes_after_a_kill(bench):
    """The engine is killed after a hole -> The hole stays a hole, and counts for `max_failed`."""
    bench.kill(LOOP.format(most=1), "iteration main/all/0")

    ran = bench.resume()

    assert ran.status == 1
    assert ran.sent == ["x0", "x1"]
    assert [row["fate"] for row in ran.rows()] == ["failed"]


def test_failures_in_a_row_over_a_kill(bench):
    """The engine is killed after an iteration that failed -> It counts for `in_a_row`."""
    bench.kill(LOOP.format(most=3).replace("max_failed: 3", "in_a_row: 1"),
               "iteration main/all/0")  # fmt: skip

    ran = bench.resume()

    assert ran.status == 1
    assert ran.sent == ["x0", "x1"]


def test_a_loop_that_ended_goes_on_when_the_run_is_resumed(bench):
    """A run that ended with one failure too many is resumed -> The loop continues with that
    iteration; holes stay holes."""
    bench.run("""
steps:
  - foreach: {i: [1, 2, 3]}
    keep_going: {max_failed: 1}
    steps:
      - set: {script: "${{ 'Broken' if i == 1 else 'Broken,ok' if i == 2 else 'ok' }}"}
      - {do: a.act, with: {name: "x${{ i }}", script: "${{ script }}"}}
""")

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["x1", "x2", "x2", "x3"]


def test_on_error_continue_and_a_kill(bench):
    """A step failed, `on_error: continue`, and the engine is killed later -> The failed step is not
    sent again."""
    bench.kill(
        """
steps:
  - {do: a.act, with: {name: x, script: "Half,ok"}, on_error: continue}
  - {id: later, do: b.act, with: {name: later, seconds: 0.1}}
""",
        "feedback main/later",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent.count("x") == 1
