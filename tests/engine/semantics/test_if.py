"""`if`: one of two branches

The condition is computed once, when the step is reached. One branch is taken; the other never runs.

    - if: ${{ params.dose > 1 g }}
      then: [{do: balance.weigh}]
      else: [{do: balance.zero}]
"""

from .table import table

CHOICE = """
steps:
  - set: {x: %s}
  - id: choice
    if: ${{ x > 1 }}
    then: [{id: high, do: a.act, with: {name: high}}]
    else: [{id: low, do: b.act, with: {name: low}}]
  - {do: c.act, with: {name: "after ${{ steps.choice.name }}"}}
outputs: {high: "${{ steps.high.name }}", low: "${{ steps.low.name }}", choice: "${{ steps.choice.name }}"}
"""


# fmt: off
test_choices = table(
    ("true_runs_then", "The condition is true -> `then` runs, `else` does not.", CHOICE % 2,
     {"sent": ["high", "after high"]}),
    ("false_runs_else", "The condition is false -> `else` runs, `then` does not.", CHOICE % 1,
     {"sent": ["low", "after low"]}),
    ("the_result_is_that_of_the_way_taken",
     "After it -> Its result is that of the last step of the branch taken; a step of the other branch "
     "has the result null.", CHOICE % 2, {"outputs": {"high": "high", "low": None, "choice": "high"}}),
    ("without_else_nothing_happens",
     "The condition is false and there is no `else` -> Nothing is sent, the step succeeds, its result is "
     "null.", """
steps:
  - {id: choice, if: "${{ 1 > 2 }}", then: [{do: a.act, with: {name: never}}]}
  - {do: b.act, with: {name: after}}
outputs: {choice: "${{ steps.choice }}"}
""", {"sent": ["after"], "outputs": {"choice": None}}),
    ("a_failure_in_the_way_taken_is_a_failure_of_the_step",
     "A step of the branch taken fails -> The `if` fails; the other branch is not a fallback and is not "
     "tried.", """
steps:
  - if: ${{ 2 > 1 }}
    then: [{do: a.act, with: {name: high, script: Broken}}]
    else: [{do: b.act, with: {name: low}}]
    fallback: [{do: c.act, with: {name: other}}]
""", {"status": 0, "sent": ["high", "other"]}),
    ("a_condition_that_cannot_be_computed_is_a_failure",
     "The condition cannot be computed (a division by zero) -> The step fails; neither branch runs.", """
steps:
  - {id: one, do: a.act, with: {name: one}}
  - if: ${{ 1 / (steps.one.n - 1) > 2 }}
    then: [{do: b.act, with: {name: never}}]
    else: [{do: c.act, with: {name: never}}]
""", {"status": 1, "sent": ["one"], "reason": "zero"}),
    ("null_counts_as_false",
     "The condition is null because it compares a result that is null -> It counts as false.", """
steps:
  - {id: gone, do: a.act, with: {name: gone, script: Broken}, on_error: continue}
  - if: ${{ steps.gone.x > 1 mm }}
    then: [{do: b.act, with: {name: high}}]
    else: [{do: c.act, with: {name: low}}]
""", {"sent": ["gone", "low"]}),
    ("the_condition_is_computed_once",
     "The branch taken changes what the condition is computed from -> The choice does not change.", """
steps:
  - set: {x: 2}
  - if: ${{ x > 1 }}
    then:
      - set: {x: 0}
      - {do: a.act, with: {name: "still ${{ x }}"}}
    else: [{do: b.act, with: {name: never}}]
  - {do: c.act, with: {name: "after ${{ x }}"}}
""", {"sent": ["still 0", "after 0"]}),
    ("in_a_loop_each_iteration_chooses", "Inside a loop -> Each iteration chooses again.", """
steps:
  - foreach: {i: [1, 2, 3]}
    steps:
      - if: ${{ i == 2 }}
        then: [{do: a.act, with: {name: "two"}}]
        else: [{do: b.act, with: {name: "not ${{ i }}"}}]
""", {"sent": ["not 1", "two", "not 3"]}),
    ("a_retried_choice_is_made_anew",
     "The `if` has a `retry` -> The condition is computed again in each attempt.", """
steps:
  - set: {x: 2}
  - retry: 2
    if: ${{ x > 1 }}
    then:
      - set: {x: 0}
      - {do: a.act, with: {name: high, script: Broken}}
    else: [{do: b.act, with: {name: low}}]
""", {"status": 0, "sent": ["high", "low"]}),
)
# fmt: on


def test_the_choice_stands_after_a_kill(bench):
    """The engine is killed in `then`, and the condition would now be different -> Resume continues
    in `then`."""
    bench.kill(
        """
steps:
  - {id: look, do: a.act, with: {name: look}}
  - if: ${{ steps.look.n == 1 }}
    then:
      - {do: b.shoot, with: {name: first}}
      - {do: b.act, with: {name: then, seconds: 0.2}}
    else: [{do: c.act, with: {name: never}}]
""",
        "feedback main/1/then/1",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent.count("look") == 2  # what was measured is measured again: now it is number 2
    assert ran.sent.count("first") == 1
    assert "never" not in ran.sent


def test_abort_in_the_way_taken(run):
    """Abort in the branch taken -> Its action is cancelled; the other branch never runs."""
    ran = run(
        """
steps:
  - if: ${{ 2 > 1 }}
    then: [{id: long, do: a.act, with: {name: long, script: hang}}]
    else: [{do: b.act, with: {name: never}}]
""",
        abort="feedback .* main/0/then/long",
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == ["long"]


def test_a_timeout_counts_for_the_way_taken(run):
    """The `if` has a `timeout` -> It counts from the choice to the end of the branch taken."""
    ran = run("""
steps:
  - timeout: 0.4 s
    if: ${{ 2 > 1 }}
    then:
      - {do: a.act, with: {name: quick}}
      - {do: a.act, with: {name: long, script: hang}}
""")

    assert ran.status == 1
    assert "Timeout" in ran.finished.detail
