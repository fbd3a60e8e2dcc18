"""`foreach`: the same steps for each item

The items are taken in order, one after the other. `key` names an iteration permanently; without it
the index does. What an iteration computes is lost when it ends: `collect` keeps a row, `set` keeps a value.

    - foreach: {point: "${{ grid(x=span(0, 4, 2), y=span(0, 4, 2)) }}"}
      key: ${{ point.ix }},${{ point.iy }}
      steps: [{do: gantry.move_to, with: {x: "${{ point.x * 1 mm }}", y: "${{ point.y * 1 mm }}"}}]
"""

import pytest

from .table import table

# fmt: off
test_iterations = table(
    ("the_steps_run_for_each_item_in_order",
     "A list of items -> The steps run for each of them, one after the other, in the order of the list.",
     """
steps:
  - foreach: {i: [3, 1, 2]}
    steps:
      - {do: a.act, with: {name: "a${{ i }}"}}
      - {do: b.act, with: {name: "b${{ i }}"}}
""", {"sent": ["a3", "b3", "a1", "b1", "a2", "b2"]}),
    ("the_result_is_the_counts",
     "After it -> Its result says how many iterations there were, succeeded, failed and were skipped.", """
steps:
  - id: all
    foreach: {i: [1, 2, 3]}
    keep_going: {max_failed: 1}
    steps: [{do: a.act, with: {name: x, script: "ok,Broken,ok"}}]
outputs: {counts: "${{ steps.all }}"}
""", {"outputs": {"counts": {"total": 3, "succeeded": 2, "failed": 1, "skipped": 0}}}),
    ("no_items_is_a_success",
     "A list that turns out empty -> No step runs; the loop succeeds with all counts 0.", """
steps:
  - {id: one, do: a.act, with: {name: one}}
  - {id: all, foreach: {i: "${{ range(steps.one.n - 1) }}"}, steps: [{do: a.act, with: {name: never}}]}
outputs: {total: "${{ steps.all.total }}"}
""", {"sent": ["one"], "outputs": {"total": 0}}),
    ("a_failure_ends_the_loop",
     "An iteration fails -> The loop fails there; later items are not started.", """
steps:
  - foreach: {i: [1, 2, 3]}
    steps:
      - {do: a.act, with: {name: "a${{ i }}", script: "${{ 'Broken' if i == 2 else 'ok' }}"}}
""", {"status": 1, "sent": ["a1", "a2"]}),
    ("the_items_are_computed_once",
     "The items are an expression -> It is computed when the loop is entered, and not again.", """
steps:
  - set: {n: 2}
  - foreach: {i: "${{ range(n) }}"}
    steps:
      - set: {n: 5}
      - {do: a.act, with: {name: "a${{ i }}"}}
""", {"sent": ["a0", "a1"]}),
    ("loops_nest",
     "A loop in a loop -> The inner one runs again in each iteration of the outer one; its result is "
     "known there.", """
steps:
  - foreach: {i: [1, 2]}
    steps:
      - {id: inner, foreach: {j: [1, 2]}, steps: [{do: a.act, with: {name: "${{ i }}${{ j }}"}}]}
      - {do: b.act, with: {name: "did ${{ steps.inner.succeeded }}"}}
""", {"sent": ["11", "12", "did 2", "21", "22", "did 2"]}),
    ("a_result_of_an_earlier_iteration_is_not_seen",
     "A step did not run in this iteration, though it did in an earlier one -> Its result is null.", """
steps:
  - foreach: {i: [1, 2]}
    steps:
      - {id: look, when: "${{ i == 1 }}", do: a.act, with: {name: look}}
      - {do: b.act, with: {name: "${{ 'seen' if steps.look else 'null' }}"}}
""", {"sent": ["look", "seen", "null"]}),
    ("keys_that_come_twice_fail_before_anything_is_sent",
     "Two items have the same key -> The loop fails before its first action is sent.", """
steps:
  - {id: one, do: a.act, with: {name: one}}
  - foreach: {i: [1, 2, "${{ steps.one.n }}"]}
    key: k${{ i }}
    steps: [{do: a.act, with: {name: never}}]
""", {"status": 1, "reason": "occurs twice", "sent": ["one"]}),
    ("abort_ends_the_iteration_and_the_loop",
     "Abort in an iteration -> Its action is cancelled; later items are not started.", """
steps:
  - foreach: {i: [1, 2, 3]}
    steps: [{id: it, do: a.act, with: {name: "a${{ i }}", script: "${{ 'hang' if i == 2 else 'ok' }}"}}]
""", {"fate": "aborted", "sent": ["a1", "a2"]}, {"abort": "feedback .* main/0/1/it"}),
)
# fmt: on


def test_after_a_kill_finished_iterations_are_left_out(bench):
    """The engine is killed in the third iteration -> Resume skips the first two and continues in
    the third, at its first unfinished action."""
    bench.kill(
        """
steps:
  - id: all
    foreach: {i: [1, 2, 3, 4]}
    key: k${{ i }}
    steps:
      - {do: a.shoot, with: {name: "a${{ i }}"}}
      - {id: b, do: b.shoot, with: {name: "b${{ i }}", seconds: 0.1}}
    collect: {i: "${{ i }}"}
outputs: {counts: "${{ steps.all.succeeded }}"}
""",
        "ended main/all/k3/0",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["a1", "b1", "a2", "b2", "a3", "b3", "a4", "b4"]
    assert [row["key"] for row in ran.rows()] == ["k1", "k2", "k3", "k4"]
    assert ran.outputs == {"counts": 4}


def test_after_a_kill_what_was_set_on_a_touched_device_is_set_again(bench):
    """As before, with `idempotent` actions -> Those of the unfinished iteration are repeated in
    order, those of finished ones are not, unless their contract says that they set something."""
    bench.kill(
        """
steps:
  - foreach: {i: [1, 2]}
    steps:
      - {do: a.act, with: {name: "lower${{ i }}"}}
      - {do: a.shoot, with: {name: "shot${{ i }}"}}
      - {do: a.act, with: {name: "lift${{ i }}"}}
""",
        "goal main/0/1/1",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["lower1", "shot1", "lift1", "lower2", "lower2", "shot2", "lift2"]


def test_after_a_kill_what_was_read_before_something_once_is_not_read_again(bench):
    """As before, with `pure` actions -> Those that a `once` action came after count as done: what they
    have read cannot be read again. The others are done again."""
    bench.kill(
        """
steps:
  - foreach: {i: [1]}
    steps:
      - {id: before, do: a.read}
      - {do: a.shoot, with: {name: shot}}
      - {id: after, do: a.read}
      - {do: a.act, with: {name: lift}}
""",
        "goal main/0/0/3",
    )

    ran = bench.resume()
    read = [r.id.split("/")[-2] for r in ran.records if r.kind == "goal" and r.action == "read"]

    assert ran.status == 0
    assert read == ["before", "after", "after"]


def test_after_a_kill_what_finished_iterations_had_set_is_set_again(bench):
    """As before, with actions whose contract says what they set (`sets`) -> The last one of each that
    finished iterations had done is done again, in the old order, before the first unfinished one."""
    bench.kill(
        """
steps:
  - foreach: {i: [1, 2, 3]}
    steps:
      - {do: a.tune, with: {name: "two${{ i }}", x: 2 mm}, when: "${{ i < 3 }}"}
      - {do: a.tune, with: {name: one, x: 1 mm}, when: "${{ i == 1 }}"}
      - {do: a.act, with: {name: "go${{ i }}"}}
      - {do: a.shoot, with: {name: "shot${{ i }}"}}
on_resume: [{do: b.act, with: {name: home}}]
""",
        "goal main/0/2/3",
    )

    ran = bench.resume()

    assert ran.status == 0
    first = ["two1", "one", "go1", "shot1", "two2", "go2", "shot2", "go3"]
    assert ran.sent == [*first, "home", "one", "two2", "go3", "shot3"]


def test_after_a_kill_outer_and_inner_loops_set_again_what_they_had_set(bench):
    """As before, in loops within loops -> First what the outer loop's finished iterations had set, then
    the steps of the unfinished one, then what the inner loop had set: in the order of the run."""
    bench.kill(
        """
steps:
  - {do: a.tune, with: {name: first, x: 1 mm}}
  - foreach: {i: [1, 2]}
    steps:
      - {do: a.tune, with: {name: "outer${{ i }}", x: 2 mm}, when: "${{ i == 1 }}"}
      - {do: a.tune, with: {name: "low${{ i }}", x: 3 mm}}
      - {do: b.act, with: {name: "look${{ i }}"}}
      - foreach: {j: [1, 2, 3]}
        steps:
          - {do: a.tune, with: {name: "high${{ i }}${{ j }}", x: 3 mm}, when: "${{ j < 3 }}"}
          - {do: a.shoot, with: {name: "shot${{ i }}${{ j }}"}}
""",
        "goal main/1/1/3/2/1",
    )
    bench.laboratory.live_until(
        "ended main/1/1/3:again",
        ["resume", "last", "--runs", bench.folder / "runs"],
        bench.folder / "words.txt",
    )

    ran = bench.resume()

    assert ran.status == 0
    again = ["first", "outer1", "high12", "low2", "look2", "high22"]
    assert ran.sent[ran.sent.index("high22") :] == ["high22", "shot22", *again, *again, "shot23"]


def test_after_a_kill_names_set_in_finished_iterations_have_their_values(bench):
    """As before, with a `set` in the steps -> Names have the values that the finished iterations
    gave them."""
    bench.kill(
        """
steps:
  - set: {total: 0}
  - foreach: {i: [1, 2, 3, 4]}
    steps:
      - set: {total: "${{ total + i }}"}
      - {do: a.shoot, with: {name: "a${{ i }}"}}
  - {do: b.act, with: {name: "sum ${{ total }}"}}
""",
        "ended main/1/2/1",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["a1", "a2", "a3", "a4", "sum 10"]


def test_after_a_kill_an_inner_loop_goes_on_where_it_was(bench):
    """The engine is killed in an inner loop -> Its finished iterations are skipped, too."""
    bench.kill(
        """
steps:
  - set: {n: 0}
  - foreach: {i: [1, 2]}
    steps:
      - foreach: {j: [1, 2]}
        steps:
          - set: {n: "${{ n + 1 }}"}
          - {do: a.shoot, with: {name: "${{ i }}${{ j }}"}}
  - {do: b.act, with: {name: "${{ n }} shots"}}
""",
        "iteration main/1/1/0/0",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["11", "12", "21", "22", "4 shots"]


@pytest.mark.parametrize("order", ["rows", "snake", "columns"])
def test_a_grid_is_gone_through_in_its_order(run, order):
    """The items are a grid -> Its points come in the order given: rows, snake or columns."""
    ran = run(f"""
steps:
  - foreach: {{p: "${{{{ grid(x=span(0, 1, 1), y=span(0, 1, 1), order='{order}') }}}}"}}
    steps: [{{do: a.act, with: {{name: "${{{{ p.ix }}}}${{{{ p.iy }}}}"}}}}]
""")

    ways = {
        "rows": ["00", "10", "01", "11"],
        "snake": ["00", "10", "11", "01"],
        "columns": ["00", "01", "10", "11"],
    }
    assert ran.sent == ways[order]
