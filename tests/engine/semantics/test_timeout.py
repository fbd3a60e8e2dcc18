"""`timeout`

On a `do` the time counts for each attempt, from the moment it is sent. On any other step it counts
in total, with its retries and fallbacks. A pause does not count.

    - {do: libs.measure, timeout: 60 s, retry: 2}
    - timeout: 10 min
      steps: [{do: gantry.home}, {do: libs.locate}]
"""

from .table import table


def test_a_timeout_cancels_the_action(run):
    """An action takes longer -> It is cancelled and awaited; then the step fails with the error
    `Timeout`."""
    ran = run("""
steps:
  - do: a.act
    with: {name: x, script: hang}
    timeout: 0.2 s
    fallback: [{do: b.act, with: {name: "${{ error.name }}"}}]
""")

    assert ran.status == 0
    assert ran.sent == ["x", "Timeout"]
    # The engine cancels it, or the server ends it by itself: whichever clock is first.
    first, second = [r.state for r in ran.records if r.kind == "ended"]
    assert first in ("CANCELED", "ABORTED") and second == "SUCCEEDED"


# fmt: off
test_timeouts = table(
    ("each_attempt_has_the_whole_time",
     "An action with a `retry` takes longer -> It is sent again, and each attempt has the whole time.", """
steps: [{do: a.act, with: {name: x, script: "hang,ok"}, timeout: 0.2 s, retry: 2}]
""", {"status": 0, "sent": ["x", "x"]}),
    ("a_late_success_counts",
     "An action that cannot be cancelled ends after its time with success -> It has succeeded.", """
steps:
  - {id: it, do: a.shoot, with: {name: x, seconds: 0.4}, timeout: 0.1 s}
  - {do: b.act, with: {name: "after ${{ steps.it.name }}"}}
""", {"status": 0, "words": ["x", "x.", "after x", "after x."]}),
    ("waiting_for_the_device_does_not_count",
     "The device is busy with another action first -> Waiting for it does not count.", """
steps:
  - {do: a.act, with: {name: aside, seconds: 0.4}, mode: background}
  - {do: a.act, with: {name: x}, timeout: 0.3 s}
""", {"status": 0, "words": ["aside", "aside.", "x", "x."]}),
    ("a_pause_does_not_count", "The run is paused meanwhile -> A pause does not count.",
     "steps: [{timeout: 0.5 s, steps: [{do: a.act, with: {name: x, seconds: 0.1}}, {wait: 0.1 s}]}]\n",
     {"status": 0}, {"pause": "feedback .* main/0/0"}),
    ("defaults_are_for_actions_only",
     "`defaults.timeout` -> It applies to every `do` without its own; groups, questions and waits have "
     "none.", """
defaults: {timeout: 0.2 s}
steps:
  - {wait: 0.3 s}
  - {do: a.act, with: {name: x, seconds: 0.3}, timeout: 5 s}
  - {do: a.act, with: {name: y, script: hang}}
""", {"status": 1, "done": ["x"], "reason": "a.act took longer than 0.2 s"}),
    ("on_a_group_the_time_counts_in_total",
     "The steps of a group take longer together -> What runs is cancelled; the group fails with "
     "`Timeout`.", """
steps:
  - timeout: 0.4 s
    steps:
      - {do: a.act, with: {name: x, seconds: 0.2}}
      - {do: a.act, with: {name: y, script: hang}}
      - {do: a.act, with: {name: never}}
""", {"status": 1, "words": ["x", "x.", "y"], "reason": "Timeout"}),
    ("on_a_group_retries_and_fallbacks_count_too",
     "A group with a `retry` or a `fallback` takes longer -> Those count, too: they are not tried any "
     "more; `on_error` and `keep_going` take the failure.", """
steps:
  - timeout: 0.3 s
    on_error: continue
    retry: 3
    steps: [{do: a.act, with: {name: x, script: hang}}]
    fallback: [{do: b.act, with: {name: never}}]
  - {do: c.act, with: {name: after}}
""", {"status": 0, "sent": ["x", "after"]}),
    ("a_question_with_a_timeout", "Nobody answers a question in time -> It fails with `Timeout`.", """
steps:
  - {id: how, ask: "How?", choices: [well, badly], timeout: 0.2 s, on_error: continue}
  - {do: a.act, with: {name: "${{ 'null' if steps.how == null else 'told' }}"}}
""", {"sent": ["null"]}),
)
# fmt: on


def test_a_loop_with_a_timeout(run):
    """A loop takes longer -> The iteration that runs is cancelled; finished ones and their rows
    stay."""
    ran = run("""
steps:
  - id: all
    foreach: {i: [1, 2, 3]}
    timeout: 0.5 s
    on_error: continue
    steps: [{do: a.act, with: {name: "a${{ i }}", script: "${{ 'hang' if i == 2 else 'ok' }}"}}]
    collect: {i: "${{ i }}"}
outputs: {all: "${{ steps.all }}"}
""")

    assert ran.status == 0
    assert ran.sent == ["a1", "a2"]
    assert [row["i"] for row in ran.rows()] == ["1"]
    assert ran.outputs == {"all": None}


def test_a_step_whose_time_was_over_is_not_begun_again_after_a_kill(bench):
    """A step timed out, the run continued (`on_error: continue`), and the engine is killed later ->
    Resume does not start it again; what its finished steps had set is known."""
    bench.kill(
        """
steps:
  - timeout: 0.4 s
    on_error: continue
    steps:
      - {id: one, do: a.act, with: {name: one}}
      - {do: b.act, with: {name: long, script: "hang,ok"}}
  - {do: a.shoot, with: {name: shot}}
  - {id: later, do: c.act, with: {name: later, seconds: 0.1}}
outputs: {one: "${{ steps.one.name }}"}
""",
        "feedback main/later",
    )

    ran = bench.resume()

    assert ran.status == 0
    assert ran.sent.count("long") == 1
    assert ran.sent.count("shot") == 1
    assert ran.outputs == {"one": "one"}


def test_a_run_that_failed_by_a_timeout_tries_again_when_it_is_resumed(bench):
    """A run that ended because a step timed out is resumed -> The step is started again, with its
    whole time."""
    bench.run("""
steps:
  - timeout: 0.3 s
    steps:
      - {do: a.shoot, with: {name: one}}
      - {do: b.act, with: {name: long, script: "hang,ok"}}
""")

    for _ in range(20):  # a busy machine may need all the time before `long` is sent
        ran = bench.resume()
        if ran.status == 0:
            break

    assert ran.status == 0
    assert ran.sent.count("one") == 1 and ran.sent.count("long") >= 2
