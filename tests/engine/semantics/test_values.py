"""`set`, `collect`, `outputs`, `csv`, and steps that take no time

`set` gives names to values. `collect` writes a row of a table for each iteration. `outputs` are the
run's own result. `csv()` reads a table beside the protocol.

    - foreach: {sample: "${{ csv('samples.csv', x='mm') }}"}
      steps: [{id: look, do: balance.weigh}, {set: {last: "${{ steps.look.mass }}"}}]
      collect: {x: "${{ sample.x }}", mass: "${{ steps.look.mass }}"}
"""

from .table import table

# fmt: off
test_names = table(
    ("a_name_is_known_to_later_steps",
     "`set` gives a name a value -> All later steps see it, also those in loops and groups.", """
steps:
  - set: {n: 1}
  - foreach: {i: [10, 20]}
    steps: [{steps: [{do: a.act, with: {name: "x${{ n + i }}"}}]}]
""", {"sent": ["x11", "x21"]}),
    ("an_iteration_changes_a_name_of_outside",
     "A loop changes a name that was set before it -> The next iterations and all later steps see the "
     "new value.", """
steps:
  - set: {total: 0}
  - foreach: {i: [1, 2, 3]}
    steps: [{set: {total: "${{ total + i }}"}}]
  - {do: a.act, with: {name: "sum ${{ total }}"}}
""", {"sent": ["sum 6"]}),
    ("all_values_of_one_set_are_computed_first",
     "One `set` with several names -> All values are computed from those before it.", """
steps:
  - set: {a: 1, b: 2}
  - set: {a: "${{ b }}", b: "${{ a }}"}
  - {do: a.act, with: {name: "${{ a }} ${{ b }}"}}
""", {"sent": ["2 1"]}),
)
# fmt: on


def test_a_whole_expression_keeps_its_type(run):
    """A value that is a single expression -> It keeps its type and unit; inside a text it is
    written out."""
    ran = run("""
steps:
  - set: {far: "${{ 1 mm + 0.5 mm }}"}
  - {do: a.act, with: {name: "at ${{ far }}", x: "${{ far }}"}}
""")

    assert [r.params for r in ran.records if r.kind == "goal"] == [{"name": "at 1.5 mm", "x": 1.5}]


# fmt: off
test_steps_without_a_device = table(
    ("null_spreads",
     "A result that is null is computed with -> The result is null; a comparison with it counts as "
     "false.", """
steps:
  - {id: gone, when: "${{ 1 > 2 }}", do: a.act, with: {name: never}}
outputs: {sum: "${{ steps.gone.x + 1 mm }}", less: "${{ 'yes' if steps.gone.x < 1 mm else 'no' }}"}
""", {"outputs": {"sum": None, "less": "no"}}),
    ("require",
     "`require` of something that is not true -> The step fails, and the reason names the condition.",
     "steps: [{set: {x: 1}}, {require: '${{ x > 1 }}'}, {do: a.act, with: {name: never}}]\n",
     {"status": 1, "sent": [], "reason": "Required: x > 1 is not true"}),
    ("fail", "`fail: TEXT` -> The step fails, with this text.",
     "steps: [{set: {x: 1}}, {when: '${{ x == 1 }}', fail: 'x is ${{ x }}'}]\n",
     {"status": 1, "reason": "Failed: x is 1"}),
    ("wait", "`wait: 0.2 s` -> The next step begins after that time.", """
steps:
  - parallel:
      - steps: [{wait: 0.2 s}, {do: a.act, with: {name: later}}]
      - steps: [{do: b.act, with: {name: one}}, {do: b.act, with: {name: two}}]
""", {"sent": ["one", "two", "later"]}),
)
# fmt: on


def test_log(bench):
    """`log: TEXT` -> A line on the screen and in the journal; once, even if the engine is killed
    and the run resumed."""
    bench.kill(
        """
steps:
  - log: begun
  - {id: long, do: a.act, with: {name: x, seconds: 0.2}}
  - log: ${{ [1.5 mm, 20 degC, null, true] }}
""",
        "feedback main/long",
    )

    ran = bench.resume()

    assert ran.logged == ["begun", "1.5 mm, 20 °C, null, true"]


def test_collect_writes_a_row_an_iteration(run):
    """`collect` -> A row for each iteration, written when it is finished: `key` first, `fate`
    last."""
    ran = run("""
steps:
  - foreach: {i: [1, 2]}
    key: p${{ i }}
    steps: [{id: x, do: a.act, with: {name: "x${{ i }}", x: "${{ i }}"}}]
    collect: {name: "${{ steps.x.name }}", at: "${{ steps.x.x }}"}
""")

    assert (ran.folder / "data.csv").read_text().splitlines() == [
        "key,name,at_mm,fate", "p1,x1,1,succeeded", "p2,x2,2,succeeded",
    ]  # fmt: skip


def test_rows_of_an_inner_loop_bear_both_keys(run):
    """`collect` in a loop in a loop -> One table for all of them; the key of a row has the outer
    key first."""
    ran = run("""
steps:
  - foreach: {s: [A, B]}
    key: ${{ s }}
    steps:
      - foreach: {i: [1, 2]}
        steps: [{do: a.act, with: {name: x}}]
        collect: {i: "${{ i }}"}
""")

    assert [row["key"] for row in ran.rows()] == ["A/0", "A/1", "B/0", "B/1"]


def test_every_loop_that_collects_has_a_table(run):
    """Several loops collect -> Each has a table: `data.csv` is that of the first, the others are
    named after the ids of their steps."""
    ran = run("""
steps:
  - {id: coarse, foreach: {i: [1]}, steps: [{do: a.act, with: {name: x}}], collect: {i: "${{ i }}"}}
  - {id: fine, foreach: {j: [2]}, steps: [{do: a.act, with: {name: y}}], collect: {j: "${{ j }}"}}
""")

    assert [row["i"] for row in ran.rows()] == ["1"]
    assert [row["j"] for row in ran.rows("data-fine.csv")] == ["2"]


def test_rows_of_a_loop_that_is_begun_anew(run):
    """The loop is in a group that is retried -> Its rows are written again; those of the first
    attempt stay."""
    ran = run("""
steps:
  - retry: 2
    steps:
      - {foreach: {i: [1, 2]}, steps: [{do: a.act, with: {name: x}}], collect: {i: "${{ i }}"}}
      - {do: b.act, with: {name: check, script: "Broken,ok"}}
""")

    assert [row["i"] for row in ran.rows()] == ["1", "2", "1", "2"]


def test_rows_are_whole_after_a_kill(bench):
    """The engine is killed after a row -> After the resume every row is there once, in order."""
    bench.kill(
        """
steps:
  - foreach: {i: [1, 2, 3]}
    steps: [{do: a.shoot, with: {name: "x${{ i }}"}}]
    collect: {i: "${{ i }}"}
""",
        "iteration main/0/1",
    )

    ran = bench.resume()

    assert [row["i"] for row in ran.rows()] == ["1", "2", "3"]


def test_outputs(run):
    """The run succeeds -> `outputs` are computed at its end; what cannot be computed is null, and a
    message says why."""
    ran = run("""
steps:
  - {id: one, do: a.act, with: {name: one, x: 2}}
outputs: {x: "${{ steps.one.x * 2 }}", bad: "${{ 1 / (steps.one.n - 1) }}"}
""")

    assert ran.status == 0
    assert ran.outputs == {"x": {"$quantity": [4.0, "mm"]}, "bad": None}


def test_a_run_that_failed_has_no_outputs(run):
    """The run fails -> It has no outputs."""
    ran = run("steps: [{fail: no}]\noutputs: {x: 1}\n")

    assert ran.outputs == {}


def test_a_table_is_gone_through(run):
    """`foreach` over `csv()` -> The rows in order; their fields have the requested kinds and
    units."""
    ran = run(
        """
steps:
  - foreach: {row: "${{ csv('points.csv', x='mm') }}"}
    key: ${{ row.name }}
    steps: [{do: a.act, with: {name: "${{ row.name }}", x: "${{ row.x }}"}}]
""",
        beside={"points.csv": "name,x\nleft,1\nright,2.5\n"},
    )

    assert [r.params for r in ran.records if r.kind == "goal"] == [
        {"name": "left", "x": 1.0},
        {"name": "right", "x": 2.5},
    ]


def test_a_table_is_the_run_s_own_copy(bench):
    """The table is edited while the run is interrupted -> Resume uses the copy that the run has
    kept."""
    bench.kill(
        """
steps:
  - foreach: {row: "${{ csv('points.csv') }}"}
    key: ${{ row.name }}
    steps: [{do: a.shoot, with: {name: "${{ row.name }}"}}]
""",
        "iteration main/0/left",
        beside={"points.csv": "name\nleft\nright\n"},
    )
    (bench.folder / "points.csv").write_text("name\nleft\nmiddle\nright\n")

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["left", "right"])
