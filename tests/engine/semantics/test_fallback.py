"""`fallback`: alternatives after a failure

When a step has failed for good, the alternatives are tried in the order written, until one succeeds.

    - id: shoot
      do: libs.measure
      fallback:
        - [{do: libs.reconnect}, {do: libs.measure}]
        - {ask: No shot, choices: [repeat, skip, stop]}
"""

from .table import table

ASK = """
steps:
  - id: all
    foreach: {i: [1, 2]}
    steps:
      - id: it
        do: a.act
        with: {name: "x${{ i }}", script: "${{ 'Broken,ok' if i == 1 else 'ok' }}"}
        fallback: [{id: how, ask: "${{ error.name }}?", choices: [repeat, skip, stop]}]
      - {do: b.act, with: {name: "y${{ i }}"}}
    collect: {n: "${{ steps.it.n }}"}
"""


# fmt: off
test_alternatives = table(
    ("alternatives_are_tried_in_order",
     "The step fails -> Its alternatives are tried in order; the first that succeeds ends it.", """
steps:
  - do: a.act
    with: {name: x, script: Broken}
    fallback:
      - {do: b.act, with: {name: one, script: Broken}}
      - {do: b.act, with: {name: two}}
      - {do: b.act, with: {name: never}}
""", {"status": 0, "sent": ["x", "one", "two"]}),
    ("a_step_that_succeeds_needs_none", "The step succeeds -> No alternative is tried.",
     "steps: [{do: a.act, with: {name: x}, fallback: [{do: b.act, with: {name: never}}]}]\n",
     {"sent": ["x"]}),
    ("the_result_is_that_of_the_alternative",
     "An alternative succeeds -> The step's result is that alternative's; of a list of steps, that of "
     "the last.", """
steps:
  - id: it
    do: a.act
    with: {name: x, script: Broken}
    fallback: [[{do: b.act, with: {name: one}}, {do: b.act, with: {name: two, x: 2}}]]
outputs: {by: "${{ steps.it.name }}"}
""", {"sent": ["x", "one", "two"], "outputs": {"by": "two"}}),
    ("when_all_fail_the_step_fails",
     "Every alternative fails -> The step fails, with the reason of the last.", """
steps:
  - {do: a.act, with: {name: x, script: Broken}, fallback: [{do: b.act, with: {name: y, script: Half}}]}
""", {"status": 1, "reason": "b.act: Half"}),
    ("error_tells_why",
     "Inside a fallback -> `error` has the name, message, step, device and action of the failure before "
     "it.", """
steps:
  - id: it
    do: a.act
    with: {name: x, script: Broken}
    fallback:
      - {do: b.act, with: {name: "${{ error.name }} on ${{ error.device }}", script: Half}}
      - {do: c.act, with: {name: "${{ error.name }} of ${{ error.action }}"}}
""", {"sent": ["x", "Broken on a", "Half of b.act"]}),
    ("retry_comes_first",
     "The step has a `retry`, too -> All attempts are made first; alternatives are not retried with it.",
     """
steps:
  - do: a.act
    with: {name: x, script: Broken}
    retry: 2
    fallback: [{do: b.act, with: {name: y, script: Broken}}, {do: b.act, with: {name: z}}]
""", {"sent": ["x", "x", "y", "z"]}),
    ("an_alternative_has_a_ladder_of_its_own",
     "An alternative has a `retry` or a `fallback` -> Its own retries and fallbacks are used before the "
     "next is tried.", """
steps:
  - do: a.act
    with: {name: x, script: Broken}
    fallback: [{do: b.act, with: {name: y, script: "Broken,ok"}, retry: 2}]
""", {"status": 0, "sent": ["x", "y", "y"]}),
    ("names_set_in_a_fallback_stay",
     "An alternative gives a new value to a name -> The name keeps it after the step.", """
steps:
  - set: {way: first}
  - do: a.act
    with: {name: x, script: Broken}
    fallback: [[{set: {way: second}}, {do: b.act, with: {name: y}}]]
  - {do: c.act, with: {name: "${{ way }}"}}
""", {"sent": ["x", "y", "second"]}),
    ("a_person_may_repeat",
     "A person answers `repeat` -> The step is started again, with all its attempts.", ASK,
     {"sent": ["x1", "x1", "y1", "x2", "y2"]}, {"answers": {"how": "repeat"}}),
)
# fmt: on


def test_a_person_may_skip(run):
    """A person answers `skip` in a loop -> The iteration ends there as a hole, whatever
    `keep_going` says; the next one starts."""
    ran = run(ASK, answers={"how": "skip"})

    assert ran.status == 0
    assert ran.sent == ["x1", "x2", "y2"]
    assert [(row["n"], row["fate"]) for row in ran.rows()] == [("", "failed"), ("1", "succeeded")]
    assert ran.finished.holes == 1


def test_outside_loops_skip_leaves_the_step_out(run):
    """A person answers `skip` outside loops -> The step is skipped, its result is null, and the
    next one starts."""
    ran = run(
        """
steps:
  - id: it
    do: a.act
    with: {name: x, script: Broken}
    fallback: [{id: how, ask: "?", choices: [skip, stop]}]
  - {do: b.act, with: {name: "${{ 'null' if steps.it == null else 'there' }}"}}
""",
        answers={"how": "skip"},
    )

    assert (ran.status, ran.sent) == (0, ["x", "null"])


def test_a_person_may_stop(run):
    """A person answers `stop` -> The run ends as aborted; no `keep_going`, `on_error` or `fallback`
    above it keeps the run going."""
    ran = run(
        ASK.replace(
            "    collect", "    keep_going: {max_failed: 9}\n    on_error: continue\n    collect"
        ),
        answers={"how": "stop"},
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == ["x1"]


def test_abort_in_a_fallback(run):
    """Abort while an alternative runs -> It is cancelled; the next is not tried."""
    ran = run(
        """
steps:
  - id: it
    do: a.act
    with: {name: x, script: Broken}
    fallback: [{id: y, do: b.act, with: {name: y, script: hang}}, {do: c.act, with: {name: never}}]
""",
        abort="feedback .* main/it/f1/y",
    )

    assert ran.finished.fate == "aborted"
    assert ran.sent == ["x", "y"]


def test_a_fallback_goes_on_after_a_kill(bench):
    """The engine is killed in the second alternative -> Resume continues there; what had failed is
    not tried again."""
    bench.kill(
        """
steps:
  - id: it
    do: a.shoot
    with: {name: x, script: Broken}
    fallback:
      - {do: b.shoot, with: {name: y, script: Broken}}
      - [{do: c.shoot, with: {name: z1}}, {id: z2, do: c.shoot, with: {name: z2, seconds: 0.2}}]
""",
        "feedback main/it/f2/z2",
    )

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["x", "y", "z1", "z2"])


def test_after_a_kill_what_an_alternative_has_begun_to_replace_is_not_set_first(bench):
    """The engine is killed while the alternative sets otherwise (`sets`) what the steps had set, with nothing
    between that is done again -> Resume does not set the old value first: a furnace on its way down is
    not heated."""
    bench.kill(
        """
steps:
  - id: it
    steps:
      - {id: up, do: a.tune, with: {name: up, x: 1 mm}}
      - {do: a.shoot, with: {name: hold, script: Broken}}
    fallback:
      - - {id: down, do: a.tune, with: {name: down, x: 1 mm, seconds: 0.2}}
        - {id: after, do: a.tune, with: {name: after, x: 2 mm, seconds: 0.2}}
""",
        "feedback main/it/f1/down",
    )
    bench.kill_again("feedback main/it/f1/after")

    ran = bench.resume()

    assert (ran.status, ran.sent) == (0, ["up", "hold", "down", "down", "after", "down", "after"])
