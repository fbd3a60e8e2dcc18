"""`mode: background`

A `do` in the background is started, and the next step begins at once. An iteration is finished when
its steps and its background actions have ended.

    - foreach: {i: "${{ range(10) }}"}
      steps:
        - {do: gantry.move_to, with: {x: "${{ i * 1 mm }}"}}
        - {do: libs.locate, mode: background}
"""

LOOP = """
steps:
  - foreach: {{i: "${{{{ range(3) }}}}"}}
    {keep}
    steps:
      - {{do: a.act, with: {{name: "a${{{{ i }}}}"}}}}
      - id: later
        do: b.act
        with: {{name: "b${{{{ i }}}}", seconds: 0.2, script: "{script}"}}
        mode: background
    collect: {{n: "${{{{ steps.later.name }}}}"}}
"""


def test_the_next_iteration_begins_meanwhile(run):
    """A background action in a loop -> The next iteration starts meanwhile; the one after it
    waits."""
    ran = run(LOOP.format(keep="", script="ok"))

    words = ran.words
    assert words.index("a1") < words.index("b0.") < words.index("a2")


def test_rows_come_in_order(run):
    """Its result in `collect` -> It is known there; rows come in the order of the iterations."""
    ran = run(LOOP.format(keep="", script="ok"))

    assert [(row["key"], row["n"]) for row in ran.rows()] == [("0", "b0"), ("1", "b1"), ("2", "b2")]


def test_more_may_be_outstanding(run):
    """`defaults: {background: 2}` -> Two finished bodies may wait for their background actions."""
    ran = run("defaults: {background: 2}" + LOOP.format(keep="", script="ok"))

    assert ran.words.index("a2") < ran.words.index("b0.")


def test_its_device_does_one_thing_at_a_time(run):
    """Its device is busy -> It waits for it, in the order of the steps."""
    ran = run("""
steps:
  - {do: a.act, with: {name: one, seconds: 0.2}, mode: background}
  - {do: a.act, with: {name: two}}
""")

    assert ran.words == ["one", "one.", "two", "two."]


def test_its_arguments_are_computed_when_it_is_begun(run):
    """A later step changes a name that it uses -> It is sent with the value at its own place in the
    protocol."""
    ran = run("""
steps:
  - set: {n: 1}
  - {do: a.act, with: {name: "with ${{ n }}"}, mode: background}
  - set: {n: 2}
""")

    assert ran.sent == ["with 1"]


def test_a_failure_makes_the_iteration_fail(run):
    """It fails -> Its iteration fails when all has ended; without `keep_going` the loop ends; an
    iteration started meanwhile is ended in order, and stays unfinished."""
    ran = run(LOOP.format(keep="", script="Broken"))

    assert ran.status == 1
    assert "a2" not in ran.sent
    assert "b.act: Broken" in ran.finished.detail


def test_within_keep_going_a_failure_is_a_hole(run):
    """It fails, within `keep_going` -> The iteration is a hole; its result is null in the row."""
    ran = run(
        LOOP.format(
            keep="keep_going: {max_failed: 3}", script="${{ 'Broken' if i == 1 else 'ok' }}"
        )
    )

    assert ran.status == 0
    assert [(row["n"], row["fate"]) for row in ran.rows()] == [
        ("b0", "succeeded"), ("", "failed"), ("b2", "succeeded"),
    ]  # fmt: skip


def test_retry_and_fallback_go_on_in_the_background(run):
    """It has a `retry` or a `fallback` -> They continue in the background, too."""
    ran = run("""
steps:
  - foreach: {i: [1]}
    steps:
      - {do: b.act, with: {name: b, script: "Broken,ok"}, retry: {attempts: 2, wait: 0.1 s}, mode: background}
      - {do: a.act, with: {name: a}}
""")

    assert ran.status == 0
    assert ran.sent.count("b") == 2
    assert ran.sent[-1] == "b"


def test_on_error_continue_in_the_background(run):
    """It fails, `on_error: continue` -> Its iteration succeeds; its result is null."""
    ran = run("""
steps:
  - foreach: {i: [1]}
    steps: [{id: b, do: b.act, with: {name: b, script: Broken}, mode: background, on_error: continue}]
    collect: {n: "${{ steps.b.name }}"}
""")

    assert ran.status == 0
    assert [(row["n"], row["fate"]) for row in ran.rows()] == [("", "succeeded")]


def test_outside_loops_the_steps_around_it_wait_for_it(run):
    """Outside loops -> The list of steps that contains it ends when it has ended, too."""
    ran = run("""
steps:
  - steps:
      - {do: b.act, with: {name: aside, seconds: 0.3}, mode: background}
      - {do: a.act, with: {name: inside}}
  - {do: a.act, with: {name: after}}
""")

    assert ran.words.index("inside.") < ran.words.index("aside.") < ran.words.index("after")


def test_outputs_may_use_its_result(run):
    """Its result in `outputs` -> It is known there."""
    ran = run("""
steps: [{id: aside, do: b.act, with: {name: aside, seconds: 0.1}, mode: background}]
outputs: {name: "${{ steps.aside.name }}"}
""")

    assert ran.outputs == {"name": "aside"}


def test_when_false_it_is_not_begun(run):
    """Its `when` is false -> It is not started; its result is null."""
    ran = run("""
steps:
  - foreach: {i: [1, 2]}
    steps: [{id: b, when: "${{ i == 2 }}", do: b.act, with: {name: "b${{ i }}"}, mode: background}]
    collect: {n: "${{ steps.b.name }}"}
""")

    assert ran.sent == ["b2"]
    assert [row["n"] for row in ran.rows()] == ["", "b2"]


def test_finally_waits_for_it(run):
    """A step fails while it runs -> `finally` starts when it has ended."""
    ran = run("""
steps:
  - {do: b.act, with: {name: aside, seconds: 0.3}, mode: background}
  - {do: a.act, with: {name: bad, script: Broken}}
finally: [{do: c.act, with: {name: tidy}}]
""")

    assert ran.status == 1
    assert ran.words.index("aside.") < ran.words.index("tidy")


def test_abort_cancels_it(run):
    """Abort -> It is cancelled."""
    ran = run(
        """
steps:
  - {id: aside, do: b.act, with: {name: aside, script: hang}, mode: background}
  - {do: a.act, with: {name: long, script: hang}}
""",
        abort="feedback .* main/aside",
    )

    assert ran.finished.fate == "aborted"
    assert {r.state for r in ran.records if r.kind == "ended"} == {"CANCELED"}


def test_it_goes_on_after_a_kill(bench):
    """The engine is killed when the steps of an iteration had ended but its background action had
    not -> Resume takes over the background action; the steps are not done again if they are
    `once`."""
    bench.kill(
        """
steps:
  - foreach: {i: [1, 2]}
    steps:
      - {id: shot, do: a.shoot, with: {name: "a${{ i }}"}}
      - {id: aside, do: b.shoot, with: {name: "b${{ i }}", seconds: 0.3}, mode: background}
    collect: {n: "${{ steps.aside.name }}"}
""",
        "ended main/0/1/shot/1",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert sorted(ran.sent) == ["a1", "a2", "b1", "b2"]
    assert [row["n"] for row in ran.rows()] == ["b1", "b2"]
