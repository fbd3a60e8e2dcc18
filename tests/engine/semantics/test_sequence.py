"""Steps, one after the other

`steps` is a list. The next step begins when the one before has ended. A group (`steps` inside a step)
is one step for everything around it.

    - {do: gantry.move_to, with: {x: 10 mm, y: 5 mm}}
    - {do: libs.measure, timeout: 60 s}
    - steps: [{do: gantry.home}, {do: libs.locate}]
"""


def test_steps_run_one_after_the_other(run):
    """Steps on several devices -> Each is sent when the one before has ended, in the order
    written."""
    ran = run("""
steps:
  - {do: a.act, with: {name: one, seconds: 0.1}}
  - {do: b.act, with: {name: two}}
  - {do: a.act, with: {name: three}}
""")

    assert ran.status == 0
    assert ran.words == ["one", "one.", "two", "two.", "three", "three."]


def test_a_step_that_fails_ends_the_run(run):
    """A step fails for good -> No later step is sent; the run fails; its reason says in words which
    step and action and why, its detail has path and error."""
    ran = run("""
steps:
  - {id: bad, do: a.act, with: {name: bad, script: Broken}}
  - {do: a.act, with: {name: never}}
""")

    assert (ran.status, ran.finished.fate) == (1, "failed")
    assert ran.sent == ["bad"]
    assert ran.finished.reason == "step bad: a.act: scripted Broken"
    assert ran.finished.detail == "main/bad: a.act: Broken: scripted Broken"


def test_the_result_of_a_group_is_that_of_its_last_step(run):
    """A group with an `id` -> Its result is that of its last step."""
    ran = run("""
steps:
  - id: both
    steps:
      - {do: a.act, with: {name: one}}
      - {do: b.act, with: {name: two}}
outputs: {name: "${{ steps.both.name }}"}
""")

    assert ran.outputs == {"name": "two"}


def test_a_step_inside_a_group_is_known_after_it(run):
    """A step inside a group -> Its result is known to all steps after it, also outside the
    group."""
    ran = run("""
steps:
  - steps: [{id: one, do: a.act, with: {name: one}}]
  - {do: b.act, with: {name: "after ${{ steps.one.name }}"}}
""")

    assert ran.sent == ["one", "after one"]


def test_values_are_in_the_units_of_the_device(run):
    """A value in another unit than the device's -> It is converted on the way there, and results
    have their unit."""
    ran = run("""
steps:
  - {id: it, do: a.act, with: {name: x, x: 500 um}}
  - {do: a.act, with: {name: y, x: "${{ steps.it.x * 2 }}"}}
  - log: "at ${{ steps.it.x }}"
""")

    assert [r.params["x"] for r in ran.records if r.kind == "goal"] == [0.5, 1.0]
    assert ran.logged == ["at 0.5 mm"]


def test_an_error_that_the_contract_does_not_declare_is_a_failure_too(run):
    """The device answers with an error that its contract does not declare -> The step fails, and
    the reason says so."""
    ran = run("steps: [{do: a.act, with: {name: x, script: Surprise}}]\n")

    assert ran.status == 1
    assert "Surprise" in ran.finished.detail
    assert "does not declare" in ran.finished.detail


def test_abort_cancels_what_runs(run):
    """Abort while an action runs -> It is cancelled, nothing after it is sent, the run ends as
    aborted."""
    ran = run(
        """
steps:
  - {id: long, do: a.act, with: {name: long, script: hang}}
  - {do: b.act, with: {name: never}}
""",
        abort="feedback .* main/long",
    )

    assert (ran.status, ran.finished.fate) == (1, "aborted")
    assert ran.words == ["long"]
    assert [r.state for r in ran.records if r.kind == "ended"] == ["CANCELED"]


def test_abort_waits_for_what_cannot_be_cancelled(run):
    """Abort while an action runs that cannot be cancelled -> It ends by itself first; then
    `finally` runs."""
    ran = run(
        """
steps:
  - {id: long, do: a.shoot, with: {name: long, seconds: 0.3}}
  - {do: b.act, with: {name: never}}
finally: [{do: b.act, with: {name: tidy}}]
""",
        abort="feedback .* main/long",
    )

    assert ran.finished.fate == "aborted"
    assert ran.words == ["long", "long.", "tidy", "tidy."]


def test_an_aborted_run_goes_on_where_it_was(bench):
    """An aborted run is resumed -> It resumes at the action that was cancelled."""
    ran = bench.run(
        """
steps:
  - {do: a.shoot, with: {name: shot}}
  - {id: long, do: b.act, with: {name: long, script: "hang,ok"}}
  - {do: b.act, with: {name: after}}
""",
        abort="feedback .* main/long",
    )
    assert ran.sent == ["shot", "long"]

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["shot", "long", "long", "after"]


def test_after_a_kill_once_actions_are_not_sent_again(bench):
    """The engine is killed and the run resumed -> Finished `once` actions are not sent again;
    finished `idempotent` ones are, in order, since their devices went into their safe state
    meanwhile."""
    bench.kill(
        """
steps:
  - {do: a.act, with: {name: lower}}
  - {do: a.shoot, with: {name: shot}}
  - {do: a.act, with: {name: lift}}
  - {do: b.act, with: {name: after}}
""",
        "ended main/2/1",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["lower", "shot", "lift", "lower", "lift", "after"]


def test_an_action_that_was_under_way_when_the_engine_died_is_adopted(bench):
    """The engine is killed while a `once` action runs -> The device ends it; resume takes its
    result as it came."""
    bench.kill(
        """
steps:
  - {id: shot, do: a.shoot, with: {name: shot, seconds: 0.3}}
  - {do: b.act, with: {name: "after ${{ steps.shot.name }}"}}
""",
        "feedback main/shot",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.words == ["shot", "shot.", "after shot", "after shot."]


def test_an_action_that_was_announced_and_never_begun_is_sent(bench):
    """The engine is killed after it recorded an action and before it sent it -> Resume sends it,
    once."""
    bench.kill("steps: [{id: shot, do: a.shoot, with: {name: shot}}]\n", "goal main/shot/1")

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["shot"]


def test_outputs_are_computed_at_the_end(run):
    """`outputs` of a run that succeeds -> They are computed after the last step and recorded in the
    journal."""
    ran = run("""
steps:
  - {id: one, do: a.act, with: {name: one, x: 2}}
outputs: {x: "${{ steps.one.x * 2 }}"}
""")

    assert ran.outputs == {"x": {"$quantity": [4.0, "mm"]}}
