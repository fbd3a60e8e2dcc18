"""`retry`

`retry: 3` means three attempts in all. What failed is tried again; only then comes the `fallback`.
An action that may be repeated and was lost with its device server is sent again by itself up to three
times; with a `retry` of its own or of its set, such an attempt counts like any other.

    - do: gantry.home
      retry: {attempts: 3, wait: 10 s, factor: 2, on: [HomingFailed]}
"""

from .table import table


def test_the_number_is_that_of_all_attempts(run):
    """`retry: 3`, and the third attempt succeeds -> The action is sent three times; the step has
    succeeded."""
    ran = run("""
steps: [{do: a.act, with: {name: x, script: "Broken,Broken,ok"}, retry: 3}]
""")

    assert (ran.status, ran.sent) == (0, ["x", "x", "x"])


def test_after_the_last_attempt_the_step_fails(run):
    """Every attempt fails -> The step fails, with the reason of the last attempt."""
    ran = run("""
steps: [{do: a.act, with: {name: x, script: "Broken,Half"}, retry: 2}]
""")

    assert (ran.status, ran.sent) == (1, ["x", "x"])
    assert "Half" in ran.finished.detail


def test_every_attempt_is_a_goal_of_its_own(run):
    """An action is sent again -> It is a new goal, with a new number, and the journal has both."""
    ran = run('steps: [{id: it, do: a.act, with: {name: x, script: "Broken,ok"}, retry: 2}]\n')

    assert [r.id.partition("/")[2] for r in ran.records if r.kind == "goal"] == [
        "main/it/1",
        "main/it/2",
    ]


def test_only_errors_that_are_named(run):
    """`on: [Broken]`, and another error comes -> It is not tried again."""
    ran = run("""
steps: [{do: a.act, with: {name: x, script: "Broken,Half,ok"}, retry: {attempts: 5, on: [Broken]}}]
""")

    assert (ran.status, ran.sent) == (1, ["x", "x"])


def test_arguments_are_computed_anew(run):
    """An argument is an expression -> It is computed again in each attempt."""
    ran = run("""
steps:
  - set: {n: 0}
  - retry: 3
    steps:
      - set: {n: "${{ n + 1 }}"}
      - {do: a.act, with: {name: "x${{ n }}", script: "${{ 'ok' if n == 3 else 'Broken' }}"}}
""")

    assert ran.sent == ["x1", "x2", "x3"]


def test_a_group_begins_anew(run):
    """A group with a `retry` -> It starts again with its first step; names that it has `set` keep
    their values."""
    ran = run("""
steps:
  - retry: 2
    steps:
      - {do: a.act, with: {name: first}}
      - {do: a.act, with: {name: second, script: "Broken,ok"}}
""")

    assert (ran.status, ran.sent) == (0, ["first", "second", "first", "second"])
    assert len({c["goal"] for c in ran.calls}) == 4


# fmt: off
test_attempts = table(
    ("the_result_is_that_of_the_attempt_that_succeeded",
     "A later attempt succeeds -> The result is that attempt's.", """
steps: [{id: it, do: a.act, with: {name: x, script: "Broken,ok"}, retry: 2}]
outputs: {n: "${{ steps.it.n }}"}
""", {"outputs": {"n": 2}}),
    ("retries_nest",
     "A retried action in a retried group -> The action has all its attempts in each attempt of the "
     "group.", """
steps:
  - retry: 2
    steps: [{do: a.act, with: {name: x, script: Broken}, retry: 2}]
""", {"sent": ["x"] * 4}),
    ("defaults_are_for_actions",
     "`defaults.retry` -> It applies to every `do` without its own, and to nothing else.", """
defaults: {retry: 2}
steps:
  - steps: [{do: a.act, with: {name: x, script: "Broken,Broken,ok"}}]
    on_error: continue
  - {do: a.act, with: {name: y, script: Broken}, retry: 1}
""", {"sent": ["x", "x", "y"]}),
)
# fmt: on


def test_between_attempts_it_waits(run):
    """`wait: 0.2 s` -> The next attempt is not made earlier; other members of a set continue
    meanwhile."""
    ran = run("""
steps:
  - parallel:
      - {do: a.act, with: {name: x, script: "Broken,ok"}, retry: {attempts: 2, wait: 0.3 s}}
      - steps: [{do: b.act, with: {name: y}}, {do: b.act, with: {name: z}}]
""")

    assert ran.sent[-1] == "x"
    assert sorted(ran.sent) == ["x", "x", "y", "z"]


def test_abort_between_attempts(run):
    """Abort while it waits for the next attempt -> No further attempt is made."""
    ran = run(
        "steps: [{do: a.act, with: {name: x, script: 'Broken,ok'}, retry: {attempts: 2, wait: 20 s}}]\n",
        abort="log .* main/0",
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == ["x"]


def test_a_kill_does_not_give_attempts_back(bench):
    """The engine is killed after the second of three attempts -> Resume continues with the
    third."""
    bench.kill(
        "steps: [{id: it, do: a.act, with: {name: x, script: Broken}, retry: 3}]\n",
        "ended main/it/2",
    )

    ran = bench.resume()

    assert (ran.status, ran.sent) == (1, ["x", "x", "x"])


def test_a_group_goes_on_in_its_second_attempt_after_a_kill(bench):
    """The engine is killed in the second attempt of a group -> Resume continues in the second
    attempt."""
    bench.kill(
        """
steps:
  - id: both
    retry: 2
    steps:
      - {do: a.shoot, with: {name: first}}
      - {id: check, do: b.shoot, with: {name: check, script: "Broken,ok"}}
      - {id: long, do: c.shoot, with: {name: long, seconds: 0.2}}
""",
        "feedback main/both/r2/both/long",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent == ["first", "check", "first", "check", "long"]


def test_a_run_that_failed_has_all_attempts_again(bench):
    """A run that ended after all attempts is resumed -> What failed has all its attempts again."""
    bench.run(
        'steps: [{do: a.act, with: {name: x, script: "Broken,Broken,Broken,ok"}, retry: 2}]\n'
    )

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["x"] * 4)


def test_a_retried_group_that_had_failed_goes_on_in_its_last_turn(bench):
    """A retried group has failed, and the run is resumed -> What its earlier turns had set is set again; the
    last one begins anew, with all attempts."""
    bench.run("""
steps:
  - id: it
    retry: 2
    steps:
      - {do: a.act, with: {name: low}}
      - {do: a.shoot, with: {name: x, script: "Broken,Broken,Broken,ok"}}
""")

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["low", "x", "low", "x", "low", "low", "x", "low", "x"])
    assert "main/it/r2/it/1/2" in [r.id.partition("/")[2] for r in ran.records if r.kind == "goal"]
